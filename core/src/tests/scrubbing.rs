//! Memory faults in a running filter: the damage that is found is repaired, and the filter continues.

use crate::particles::cursor::Cursor;
use crate::tests::alone::{Alone, Lidar, Models};
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;
use std::vec::Vec;

type Still = MapMemory<Static<Vector2<f32>>, 8, 48, 8, 64>;
type Moving = MapMemory<Dynamic<Vector2<f32>>, 8, 48, 8, 64>;
type Memory = State<PlanarPose<f32>, 8, 16, Still, Moving>;
type Filter<'s> = Alone<'s, Unicycle<f32>, Lidar<f32>>;

const AHEAD: UnicycleControl<f32> = UnicycleControl { speed_mps: 1.0, rate_radps: 0.1 };
/// The particles, the page lists, and the pages of either kind.
const PARTS: usize = 2 + 2 * 48;

fn filter(config: Config<f32>, state: &mut Memory) -> Filter<'_> {
    let window = RangeBearingWindow::full_circle(20.0, 0.9).unwrap();
    let models = Models {
        motion: Unicycle::new(Step::Arc, ControlNoise::white(0.3, 0.05)).unwrap(),
        sensing: Sensing::range_bearing([0.2, 0.02], window, 2.0).unwrap(),
    };
    let mut filter = Filter::new(models, Births { of_static: 0.01, of_moving: 0.002 }, config, state).unwrap();
    filter.reset(PlanarPose::ZERO, 1).unwrap();
    filter
}

fn step(filter: &mut Filter<'_>, scan: usize) {
    filter.predict(&AHEAD, 0.1).unwrap();
    let bearing = |k: usize| wrap(0.5 * k as f32 + 0.02 * scan as f32);
    let measurements: Vec<_> = (0..10).map(|k| Vector2::new(4.0 + 1.2 * k as f32, bearing(k))).collect();
    filter.scan(&measurements).unwrap();
}

/// The blind proposal with several samples, and the informed one.
fn configs() -> [Config<f32>; 2] {
    [Config::blind(8, 2), Config { samples: 2, ..Config::informed(8) }]
}

#[test]
fn what_is_sound_is_left_to_the_bit_and_all_of_it_is_looked_at() {
    for config in configs() {
        let mut states = [(); 2].map(|()| Box::new(Memory::new()));
        let [mut scrubbed, mut left] = states.each_mut().map(|state| filter(config, state));
        let (mut scrubber, mut rounds) = (Scrubber::new(), 0);
        for scan in 0..70 {
            let parts = 1 + scan % 13;
            let found = scrubbed.scrub(&mut scrubber, parts).unwrap();
            assert!(found.is_clean(), "{scan}: {found:?}");
            rounds += usize::from(found.round);
            [&mut scrubbed, &mut left].into_iter().for_each(|filter| step(filter, scan));
            assert_eq!((scrubbed.digest(), scrubbed.seal()), (left.digest(), left.seal()));
            // Also between a prediction and its scan.
            if scan % 5 == 0 {
                [&mut scrubbed, &mut left].into_iter().for_each(|filter| _ = filter.predict(&AHEAD, 0.1).unwrap());
                assert!(
                    scrubbed.scrub(&mut scrubber, PARTS + 9).unwrap()
                        == Scrubbed { round: true, ..Scrubbed::default() }
                );
            }
        }
        let parts: usize = (0..70).map(|scan| 1 + scan % 13).sum();
        assert_eq!(rounds, parts / PARTS);
    }
}

/// In a state with room for more particles than the filter has.
#[test]
fn a_wrong_number_of_particles_is_detected() {
    let mut state = Box::new(Memory::new());
    let mut filter = filter(Config::blind(4, 2), &mut state);
    (0..5).for_each(|scan| step(&mut filter, scan));
    assert!(filter.slam.save(1, |_| Ok::<(), ()>(())).is_ok());
    for count in [3, 5, 8] {
        filter.slam.memory.cursor.particles = count;
        assert_eq!(filter.scrub(&mut Scrubber::new(), PARTS), Err(Flaw::Cursor), "{count}");
        assert_eq!(filter.slam.save(1, |_| Ok::<(), ()>(())), Err(SaveError::Damaged(Flaw::Cursor)), "{count}");
    }
}

/// Flips one bit. Returns the name of its part.
fn flip(filter: &mut Filter<'_>, noise: &mut Noise) -> &'static str {
    let mut below = |bound: usize| ((noise.uniform::<f32>() * bound as f32) as usize).min(bound - 1);
    let (what, bit, word_bit) = (below(9), below(32), below(16));
    let flip = |number: &mut f32| *number = f32::from_bits(number.to_bits() ^ 1 << bit);
    let memory = &mut filter.slam.memory;
    let candidates = memory.cursor.candidates();
    match what {
        0 => flip(&mut memory.candidates[below(candidates)].ln_weight),
        1 => flip(&mut memory.candidates[below(candidates)].pose.y_m),
        2 => {
            let spread = &mut memory.pose_covariances[below(8)];
            let (row, column) = [(0, 0), (1, 0), (2, 2)][below(3)];
            let mut number = spread.get(row, column);
            flip(&mut number);
            *spread = Symmetric::from_fn(|r, c| if (r, c) == (row, column) { number } else { spread.get(r, c) });
        }
        3 | 4 => {
            let held = memory.static_maps.pool.held_mut().count();
            if let Some(page) = memory.static_maps.pool.held_mut().nth(below(held.max(1))) {
                let fields = page.fields();
                match below(5) {
                    0 => flip(&mut fields.components[below(8)].ln_weight),
                    1 => flip(&mut fields.components[below(8)].mean.x),
                    2 => flip(&mut fields.weights[below(8)]),
                    3 => flip(&mut fields.bounds.high.x),
                    _ => *fields.len ^= 1 << word_bit,
                }
            }
        }
        5 => {
            let count = memory.static_maps.pool.words().count();
            *memory.static_maps.pool.words().nth(below(count)).unwrap() ^= 1 << word_bit;
        }
        6 => {
            let count = memory.moving_maps.pool.words().count();
            *memory.moving_maps.pool.words().nth(below(count)).unwrap() ^= 1 << word_bit;
        }
        7 => {
            let count = memory.static_maps.table.words().count();
            *memory.static_maps.table.words().nth(below(count)).unwrap() ^= 1 << word_bit;
        }
        _ => {
            let count = memory.moving_maps.table.words().count();
            *memory.moving_maps.table.words().nth(below(count)).unwrap() ^= 1 << word_bit;
        }
    }
    ["a weight", "a pose", "a covariance", "a page", "a page", "a count", "a count", "a list", "a list"][what]
}

/// Thousands of bit flips, one after the other: after each round of scrubbing the state is valid, and the filter continues.
#[test]
fn the_state_is_valid_after_any_flip_and_a_round() {
    for config in configs() {
        let mut state = Box::new(Memory::new());
        let mut filter = filter(config, &mut state);
        (0..5).for_each(|scan| step(&mut filter, scan));
        let (mut noise, mut scrubber, mut mended) = (Noise::seeded(5), Scrubber::new(), [0; 4]);
        for scan in 0..4000 {
            let what = flip(&mut filter, &mut noise);
            let scrubbed = filter.scrub(&mut scrubber, PARTS).unwrap();
            assert_eq!(filter.audit(), Ok(()), "{scan}: {what}, {scrubbed:?}");
            let Scrubbed { isolated, rescaled, lists, pages, .. } = scrubbed;
            for (sum, found) in mended.iter_mut().zip([isolated, usize::from(rescaled), lists, pages]) {
                *sum += found;
            }
            if scan % 3 == 0 {
                step(&mut filter, scan);
                assert_eq!(filter.audit(), Ok(()), "{scan}: {what}");
            }
        }
        assert!(mended.iter().all(|&sum| sum > 50), "{mended:?}");
    }
}

/// After the loss of a particle, a page or all lists, the rest gives the estimate.
#[test]
fn the_estimate_survives_a_lost_particle_and_a_lost_page() {
    let mut state = Box::new(Memory::new());
    let mut filter = filter(Config::informed(8), &mut state);
    (0..20).for_each(|scan| step(&mut filter, scan));
    let landmark = Component { covariance: Symmetric::from_diagonal([0.01; 2]), ..Component::ZERO };
    filter.load_map(&[landmark]).unwrap();
    let before = filter.estimate_pose().unwrap().mean;
    let heaviest = filter.memory.cursor.heaviest;
    filter.memory.candidates[heaviest].pose.x_m = f32::NAN;
    filter.memory.pose_covariances[(heaviest + 1) % 8] = Symmetric::from_diagonal([f32::INFINITY; 3]);
    let id = filter.memory.static_maps.table.pages(0)[0];
    filter
        .memory
        .static_maps
        .pool
        .held(id.index())
        .unwrap()
        .fields()
        .components
        .fill(Component { mean: Vector2::new(f32::NAN, 0.0), ..Component::ZERO });
    let mut scrubber = Scrubber::new();
    let scrubbed = filter.scrub(&mut scrubber, PARTS).unwrap();
    assert_eq!((scrubbed.isolated, scrubbed.pages, scrubbed.lists, filter.audit()), (2, 1, 0, Ok(())));
    let after = filter.estimate_pose().unwrap().mean;
    assert!((after.x_m - before.x_m).hypot(after.y_m - before.y_m) < 0.2, "{before:?} {after:?}");
    step(&mut filter, 20);
    assert!(filter.scrub(&mut scrubber, PARTS).unwrap().is_clean());
}

/// Counts far above the capacities: every step ends, and uses the capacity.
#[test]
fn counts_that_cannot_be_are_clamped_by_every_step() {
    type Count = fn(&mut Cursor<f32>) -> &mut usize;
    let counts: [Count; 4] = [
        |cursor| &mut cursor.particles,
        |cursor| &mut cursor.children,
        |cursor| &mut cursor.weighed,
        |cursor| &mut cursor.heaviest,
    ];
    for config in configs() {
        for (count, bit) in counts.into_iter().flat_map(|count| [5, 31, 62].map(|bit| (count, bit))) {
            let mut state = Box::new(Memory::new());
            let mut filter = filter(config, &mut state);
            step(&mut filter, 0);
            *count(filter.slam.memory.cursor) ^= 1 << bit;
            step(&mut filter, 1);
            filter.predict(&AHEAD, 0.1).unwrap();
            *count(filter.slam.memory.cursor) ^= 1 << bit;
            let _ = filter.scan(&[]);
            assert!(filter.memory.cursor.particles <= 8 && filter.memory.cursor.heaviest < 8);
            filter.scatter(&Symmetric::from_diagonal([0.01; 3])).unwrap();
        }
    }
}

#[test]
fn irreparable_damage_is_reported_and_the_seal_detects_the_rest() {
    type Damage = fn(&mut Filter<'_>);
    let damages: [(Damage, Flaw); 5] = [
        (|filter| filter.memory.cursor.particles = 9, Flaw::Cursor),
        (|filter| filter.memory.cursor.children = 0, Flaw::Cursor),
        (|filter| filter.memory.cursor.waited_s = f32::NAN, Flaw::Cursor),
        (|filter| filter.memory.cursor.noise = None, Flaw::Cursor),
        (|filter| filter.memory.candidates.iter_mut().for_each(|candidate| candidate.pose.x_m = 1e30), Flaw::Pose),
    ];
    for (damage, flaw) in damages {
        let mut state = Box::new(Memory::new());
        let mut filter = filter(Config::blind(8, 2), &mut state);
        assert!(filter.scrub(&mut Scrubber::new(), PARTS).unwrap().is_clean());
        step(&mut filter, 0);
        damage(&mut filter);
        assert_eq!(filter.scrub(&mut Scrubber::new(), PARTS), Err(flaw));
    }
    let mut state = Box::new(Memory::new());
    let mut filter = filter(Config::blind(8, 2), &mut state);
    step(&mut filter, 0);
    let seal = filter.seal();
    filter.memory.cursor.next_label ^= 1 << 20;
    assert_ne!(filter.seal(), seal);
    assert!(filter.scrub(&mut Scrubber::new(), PARTS).unwrap().is_clean());
    // Before a reset there is nothing to check.
    let mut empty = Box::new(Memory::new());
    let mut fresh = ScPhd::new(*filter.motion(), Config::blind(8, 2), &mut *empty).unwrap();
    assert_eq!(fresh.scrub(&mut Scrubber::new(), PARTS), Ok(Scrubbed::default()));
}
