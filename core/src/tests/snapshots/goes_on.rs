//! A restored filter continues with the same bits.

use super::world::{KIND, Scratch, detector, motion, saved, start, world};
use crate::filter::state::Memory;
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;
use std::vec::Vec;

type Still<T, const N: usize, const PAGES: usize, const MAP: usize, const VIEW: usize> =
    MapMemory<Static<Vector2<T>>, N, PAGES, MAP, VIEW>;
type Moving<T, const N: usize, const PAGES: usize, const MAP: usize, const VIEW: usize> =
    MapMemory<Dynamic<Vector2<T>>, N, PAGES, MAP, VIEW>;
type Roomy<T> = State<PlanarPose<T>, 16, 32, Still<T, 16, 256, 32, 256>, Moving<T, 16, 256, 32, 256>>;
type Roomier<T> = State<PlanarPose<T>, 31, 67, Still<T, 40, 301, 33, 300>, Moving<T, 35, 400, 50, 280>>;
type Fixed<T> = State<PlanarPose<T>, 16, 32, Still<T, 16, 256, 32, 256>>;

/// Allocates a new state.
type Make<T, S, V, const N: usize, const C: usize> = fn() -> Box<State<PlanarPose<T>, N, C, S, V>>;

fn informed<T: Real>(particles: usize, samples: usize, drawn: f64) -> Config<T> {
    let proposal = Proposal::Informed(Informed { sampled_fraction: T::from_f64(drawn), ..Informed::default() });
    Config { particles, samples, proposal, ..Config::default() }
}

/// The length of a snapshot by the documented format, from the content of the state.
fn documented<T: Real>(slam: &mut ScPhd<'_, Unicycle<T>>) -> usize {
    let particles = slam.particles();
    let informed = matches!(slam.config().proposal, Proposal::Informed(_));
    let candidates = slam.candidates().len();
    let Memory { static_maps, moving_maps, .. } = &mut slam.memory;
    let has_moving = moving_maps.pool.capacity() > 0;
    let pages: usize =
        (0..particles).map(|p| static_maps.table.pages(p).len() + moving_maps.table.pages(p).len()).sum();
    let components: usize = static_maps.pool.held_mut().map(|page| page.components().len()).sum();
    let moving_components: usize = moving_maps.pool.held_mut().map(|page| page.components().len()).sum();
    // Head, checksum and cursor; candidates; particles; components. Words, and scalars, which are one or two words each.
    let words = 24 + if has_moving { 6 } else { 4 } * particles + pages + components + moving_components;
    let a_particle = if has_moving { 8 } else { 4 } + if informed { 6 } else { 0 };
    let scalars = 7 + 6 * candidates + a_particle * particles + 6 * components + 15 * moving_components;
    let [waiting_words, waiting_scalars] = slam.memory.waiting.documented(particles);
    4 * (words + waiting_words) + size_of::<T>() * (scalars + waiting_scalars)
}

/// Runs a filter without interruption, and in parallel a filter that is restored from its snapshot every `every` scans: alternately
/// before and after the prediction, and into memory of the same and of another capacity. The digests of every step agree. Returns
/// the length of the longest snapshot.
fn unbroken_and_broken<T, SM, VM, SO, VO, const N: usize, const C: usize, const NO: usize, const CO: usize>(
    config: Config<T>,
    moves: bool,
    [steps, every]: [usize; 2],
    fresh: Make<T, SM, VM, N, C>,
    other: Make<T, SO, VO, NO, CO>,
) -> usize
where
    T: Real,
    SM: MapStorage<Static<Vector2<T>>>,
    VM: MapStorage<Dynamic<Vector2<T>>>,
    SO: MapStorage<Static<Vector2<T>>>,
    VO: MapStorage<Dynamic<Vector2<T>>>,
{
    let (dt, inputs) = (T::from_f64(0.1), world::<T>(steps));
    let mut scratch = [(); 2].map(|()| Scratch::new());
    let [mut eyes, mut eyes_of_broken] = scratch.each_mut().map(|scratch| detector(scratch, moves));
    let mut first = fresh();
    let mut unbroken = ScPhd::new(motion(), config, &mut *first).unwrap();
    unbroken.reset(start(), 5).unwrap();
    let mut memory: Vec<_> = (0..steps).step_by(every).map(|_| (fresh(), other())).collect();
    let mut memory = memory.iter_mut().enumerate();
    let mut broken: Option<ScPhd<'_, _>> = None;
    let (mut longest, mut digests) = (0, Vec::new());
    for (index, step) in inputs.iter().enumerate() {
        let breaks = index % every == 0;
        let before_prediction = index / every % 2 == 0;
        if !(breaks && before_prediction) {
            let report = unbroken.predict(&step.odometry, dt).unwrap();
            if let Some(broken) = broken.as_mut() {
                assert_eq!(broken.predict(&step.odometry, dt), Ok(report));
            }
        }
        if breaks {
            let digest = unbroken.digest();
            let bytes = saved(|sink| unbroken.save(KIND, sink));
            assert_eq!((unbroken.digest(), unbroken.audit()), (digest, Ok(())), "saving changes nothing");
            longest = longest.max(bytes.len());
            assert_eq!(bytes.len(), documented(&mut unbroken), "as docs/snapshot.md has it");
            if let Some(broken) = broken.as_mut() {
                assert_eq!(saved(|sink| broken.save(KIND, sink)), bytes, "wherever in the pool anything lies");
            }
            let (turn, (same, another)) = memory.next().unwrap();
            let mut fresh = match turn % 4 {
                0 | 3 => ScPhd::new(motion(), config, &mut **same).unwrap(),
                _ => {
                    // The previous state of the memory has no effect.
                    let mut stale = ScPhd::new(motion(), config, &mut **another).unwrap();
                    stale.reset(PlanarPose::ZERO, 77).unwrap();
                    stale.scan(&mut eyes_of_broken, &step.scan).unwrap();
                    stale
                }
            };
            fresh.restore(KIND, from_slice(&bytes)).unwrap();
            assert_eq!((fresh.digest(), fresh.audit()), (digest, Ok(())));
            assert_eq!(saved(|sink| fresh.save(KIND, sink)), bytes);
            broken = Some(fresh);
        }
        let broken = broken.as_mut().unwrap();
        if breaks && before_prediction {
            assert_eq!(unbroken.predict(&step.odometry, dt), broken.predict(&step.odometry, dt));
        }
        let (report, of_broken) = (unbroken.scan(&mut eyes, &step.scan), broken.scan(&mut eyes_of_broken, &step.scan));
        let of_broken = of_broken.unwrap();
        // The capacities differ.
        let ScanReport { pages, moving_pages, .. } = of_broken;
        assert_eq!(ScanReport { pages, moving_pages, ..report.unwrap() }, of_broken);
        assert_eq!(unbroken.digest(), broken.digest(), "step {index}");
        digests.push(unbroken.digest());
    }
    std::println!("{} particles: {longest} bytes", config.particles);
    digests.dedup();
    assert_eq!(digests.len(), steps, "the state changes");
    longest
}

fn both<T: Real>(config: Config<T>, steps: usize, every: usize) -> usize {
    unbroken_and_broken(config, true, [steps, every], || Box::new(Roomy::<T>::new()), || Box::new(Roomier::<T>::new()))
}

/// The long run: 300 scans, restored every fifty.
#[test]
fn three_hundred_scans_with_six_breaks() {
    let longest = both::<f32>(Config::blind(16, 2), 300, 50);
    assert!((4096..64 * 1024).contains(&longest), "{longest}");
}

#[test]
fn every_proposal_in_either_precision() {
    for config in
        [Config::blind(8, 2), Config::blind(16, 1), informed(4, 1, 0.0), informed(7, 2, 0.5), informed(8, 2, 1.0)]
    {
        both::<f32>(config, 40, 7);
    }
    for config in [Config::blind(8, 2), informed(4, 1, 0.0), informed(8, 2, 0.5)] {
        both::<f64>(config, 40, 9);
    }
}

#[test]
fn without_moving_features_and_in_memory_that_has_them() {
    let config = informed::<f32>(4, 1, 0.0);
    let fixed: fn() -> Box<Fixed<f32>> = || Box::new(Fixed::new());
    // Four informed particles among a dozen posts, a typical robot.
    let longest = unbroken_and_broken(config, false, [300, 30], fixed, fixed);
    assert!((1024..8 * 1024).contains(&longest), "{longest}");
    // A filter with moving maps restores a snapshot without them, and vice versa if there are no moving features.
    let step = &world::<f32>(1)[0];
    let (mut fixed, mut roomy, mut scratch) =
        (Box::new(Fixed::<f32>::new()), Box::new(Roomy::<f32>::new()), Scratch::new());
    let mut eyes = detector(&mut scratch, false);
    let mut still = ScPhd::new(motion(), config, &mut *fixed).unwrap();
    still.reset(start(), 5).unwrap();
    still.scan(&mut eyes, &step.scan).unwrap();
    let mut moving = ScPhd::new(motion(), config, &mut *roomy).unwrap();
    moving.restore(KIND, from_slice(&saved(|sink| still.save(KIND, sink)))).unwrap();
    assert_eq!(moving.digest(), still.digest());
    still.restore(KIND, from_slice(&saved(|sink| moving.save(KIND, sink)))).unwrap();
    assert_eq!((moving.digest(), still.audit()), (still.digest(), Ok(())));
}

/// Also while births are delayed.
#[test]
fn delayed_births_are_restored() {
    for config in [Config::blind(16, 2), informed(4, 1, 0.2)] {
        both::<f32>(Config { births_wait: true, prune_weight: 0.01, ..config }, 60, 7);
    }
}

/// With the smallest memory, which would not suffice if pages were not shared as before.
#[test]
fn with_one_page_for_four_particles() {
    type Tight = State<PlanarPose<f32>, 4, 4, Still<f32, 4, 1, 1, 8>>;
    let fresh: fn() -> Box<Tight> = || Box::new(Tight::new());
    unbroken_and_broken(Config::blind(4, 1), false, [30, 3], fresh, fresh);
    type Odd = State<PlanarPose<f32>, 3, 7, Still<f32, 3, 5, 3, 9>, Moving<f32, 3, 2, 1, 8>>;
    let fresh: fn() -> Box<Odd> = || Box::new(Odd::new());
    unbroken_and_broken(Config::blind(3, 2), true, [30, 3], fresh, fresh);
    type One = State<PlanarPose<f64>, 1, 1, Still<f64, 1, 1, 1, 8>>;
    let fresh: fn() -> Box<One> = || Box::new(One::new());
    unbroken_and_broken(Config::tracking(), false, [30, 4], fresh, fresh);
}

/// Before the first scan, and after a refused prediction, which the next report shows.
#[test]
fn a_refused_prediction_is_remembered() {
    let mut memory: [Box<Fixed<f32>>; 2] = [Box::new(Fixed::new()), Box::new(Fixed::new())];
    let [first, second] = &mut memory;
    let mut scratch = Scratch::new();
    let mut eyes = detector(&mut scratch, false);
    let mut slam = ScPhd::new(motion(), Config::blind(8, 1), &mut **first).unwrap();
    slam.reset(start(), 5).unwrap();
    let mad = UnicycleControl { speed_mps: f32::NAN, rate_radps: 0.0 };
    assert!(slam.predict(&mad, 0.1).is_err());
    let bytes = saved(|sink| slam.save(KIND, sink));
    let mut restored = ScPhd::new(motion(), Config::blind(8, 1), &mut **second).unwrap();
    restored.restore(KIND, from_slice(&bytes)).unwrap();
    let scan = &world::<f32>(1)[0].scan;
    let (report, of_restored) = (slam.scan(&mut eyes, scan), restored.scan(&mut eyes, scan));
    assert_eq!((report.unwrap().refused, of_restored.unwrap()), (1, report.unwrap()));
}
