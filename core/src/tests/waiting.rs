//! Delayed births: the estimate is that of a filter without the delay, with fewer components.

use crate::numerics::flip::flip_one;
use crate::tests::snapshots::world::{Eyes, KIND, Scratch, detector, lidar, motion, saved, start, world};
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;
use std::vec::Vec;

type Still<T> = MapMemory<Static<Vector2<T>>, 16, 512, 64, 256>;
type Moving<T> = MapMemory<Dynamic<Vector2<T>>, 16, 512, 64, 256>;
type Memory<T> = State<PlanarPose<T>, 16, 32, Still<T>, Moving<T>>;

/// A birth of weight w_b/(κ + Σ w_b) = 0.04 is pruned after a miss.
fn config<T: Real>(births_wait: bool) -> Config<T> {
    Config { births_wait, prune_weight: T::from_f64(0.01), ..Config::blind(16, 2) }
}

fn informed<T: Real>(births_wait: bool) -> Config<T> {
    let Config { proposal, .. } = Config::<T>::informed(4);
    Config { particles: 4, samples: 1, proposal, ..config(births_wait) }
}

/// Two filters in the same world, step by step, of which only one delays births.
fn side_by_side<T: Real>(
    of: fn(bool) -> Config<T>,
    steps: usize,
    mut each: impl FnMut([&mut ScPhd<'_, Unicycle<T>>; 2], [ScanReport<T>; 2]) -> bool,
) {
    let mut memory = [(); 2].map(|()| (Box::new(Memory::<T>::new()), Scratch::new()));
    let [(at_once, scratch), (late, late_scratch)] = &mut memory;
    let mut slam = [(at_once, false), (late, true)].map(|(memory, births_wait)| {
        let mut slam = ScPhd::new(motion(), of(births_wait), &mut **memory).unwrap();
        slam.reset(start(), 5).unwrap();
        slam
    });
    let mut eyes = [detector(scratch, true), detector(late_scratch, true)];
    for step in world::<T>(steps) {
        let mut reports = slam.iter_mut().zip(&mut eyes).map(|(slam, eyes)| {
            slam.predict(&step.odometry, T::from_f64(0.1)).unwrap();
            slam.scan(eyes, &step.scan).unwrap()
        });
        let reports = [reports.next().unwrap(), reports.next().unwrap()];
        let [at_once, late] = &mut slam;
        if !each([at_once, late], reports) {
            return;
        }
    }
}

/// The stated bound: a birth whose detection would be pruned contributes less than `prune_weight` times the measurement's
/// intensity without features. A few may be near one measurement. While the same particles survive, there is no other difference.
#[test]
fn likelihoods_differ_by_the_omitted_terms() {
    let mut compared = 0;
    side_by_side(config::<f64>, 100, |[at_once, late], [report, late_report]| {
        let bound = 0.05 * f64::from(u16::try_from(report.measurements).unwrap());
        for (one, other) in at_once.ln_likelihoods().iter().zip(late.ln_likelihoods()) {
            assert!((one - other).abs() < bound, "{one} {other}");
        }
        assert!((report.expected_detections - late_report.expected_detections).abs() < 0.05);
        compared += 1;
        at_once.survivors() == late.survivors()
    });
    assert!(compared >= 20, "{compared} scans of the same particles");
}

#[test]
fn the_estimate_is_the_same_with_fewer_components() {
    for of in [config::<f32>, informed::<f32>] {
        let (mut components, mut births, mut apart, mut scans) = ([0; 2], [0; 2], 0.0, 0);
        side_by_side(of, 200, |slam, reports| {
            for (which, (slam, report)) in slam.iter().zip(&reports).enumerate() {
                components[which] += slam.map(0).count() + slam.moving_map(0).count();
                births[which] += report.births / report.survivors.max(1);
                assert_eq!(report.lost, 0);
            }
            let [one, other] = slam.map(|slam| slam.estimate_pose().unwrap().mean);
            apart = one.distance_m(&other).max(apart);
            scans += 1;
            true
        });
        assert_eq!(scans, 200);
        assert!(5 * components[1] < 4 * components[0], "{components:?}");
        // The number of births is about the same: delayed births are counted when they are measured.
        assert!((births[1] as f32 / births[0] as f32 - 1.0).abs() < 0.05, "{births:?}");
        assert!(apart < 0.3, "{apart} m");
    }
}

/// Births of a sensor that looks ahead enter the maps at the scan of one that looks back, and the other way round: nothing is lost, and
/// the map is that of a filter without the delay.
#[test]
fn births_of_one_sensor_enter_at_the_scan_of_another() {
    let looking = |half_width: f32| {
        let limits =
            RangeBearingLimits { bearing_half_width_rad: half_width, ..RangeBearingLimits::full_circle(10.0, 0.9) };
        Sensing { field_of_view: RangeBearingWindow::new(limits).unwrap(), ..lidar::<f32>() }
    };
    let births = Births { of_static: 0.002, of_moving: 0.0 };
    let mut found = [(); 2].map(|()| Vec::new());
    for (births_wait, found) in [false, true].into_iter().zip(&mut found) {
        let mut memory = Box::new(Memory::<f32>::new());
        let mut slam = ScPhd::new(motion(), config(births_wait), &mut *memory).unwrap();
        slam.reset(start(), 5).unwrap();
        let (mut scratch, mut other_scratch) = (Scratch::new(), Scratch::new());
        let mut ahead = Detector::new(looking(1.5), births).unwrap().over(&mut scratch).unwrap();
        let mounting = Mounting::in_plane(-0.5, 0.0, core::f32::consts::PI).unwrap();
        let back = Detector::new(looking(core::f32::consts::PI - 1.5), births).unwrap();
        let mut back = back.mounted(mounting).unwrap().over(&mut other_scratch).unwrap();
        let mut delayed = 0;
        for step in world::<f32>(60) {
            slam.predict(&step.odometry, 0.1).unwrap();
            let seat = |z: &Vector2<f32>| {
                let (sine, cosine) = z.y.sin_cos();
                let (x, y) = (z.x * cosine + 0.5, z.x * sine);
                Vector2::new(x.hypot(y), (-y).atan2(-x))
            };
            let (before, behind): (Vec<_>, Vec<_>) = step.scan.iter().partition(|z| z.y.abs() < 1.5);
            let behind: Vec<_> = behind.iter().map(seat).filter(|z| z.x < 10.0).collect();
            let reports = [slam.scan(&mut ahead, &before).unwrap(), slam.scan(&mut back, &behind).unwrap()];
            assert_eq!((reports.map(|report| report.lost), slam.audit()), ([0; 2], Ok(())));
            delayed += usize::from(slam.memory.waiting.is_anything());
        }
        assert_eq!(delayed > 30, births_wait, "{delayed}");
        let mut features = [Component::ZERO; 32];
        let map = slam.estimate_map(&ahead, &mut features);
        assert!((6..=13).contains(&map.features), "{map:?}");
        *found = features[..map.features].iter().map(|feature| feature.mean).collect();
    }
    let [at_once, late] = found;
    assert_eq!(at_once.len(), late.len());
    for one in &at_once {
        assert!(late.iter().any(|other| (one - other).norm() < 0.2), "{one:?} {late:?}");
    }
}

/// Drafts delay the same births.
#[test]
fn drafts_delay_births_too() {
    let mut memory = [(); 2].map(|()| (Box::new(Memory::<f32>::new()), Scratch::new()));
    let mut updates = Box::new(UpdateMemory::<Memory<f32>, 3>::new());
    let [alone, drafted] = memory.each_mut().map(|(memory, scratch)| {
        let mut slam = ScPhd::new(motion(), config(true), &mut **memory).unwrap();
        slam.reset(start(), 5).unwrap();
        (slam, detector(scratch, true))
    });
    let ((mut alone, mut eyes), (mut drafted, mut other_eyes)) = (alone, drafted);
    for step in world::<f32>(60) {
        for slam in [&mut alone, &mut drafted] {
            slam.predict(&step.odometry, 0.1).unwrap();
        }
        let report = alone.scan(&mut eyes, &step.scan);
        let drafts = &mut updates.drafts();
        assert_eq!(drafted.scan_on(&mut other_eyes, &step.scan, &Serial, drafts, &mut ()), report);
        assert_eq!(alone.digest(), drafted.digest());
    }
}

/// Clutter of a hundred measurements a scan: all births are delayed if there is room for them, otherwise as many as fit; a
/// snapshot contains them.
#[test]
fn as_many_births_are_delayed_as_there_is_room_for() {
    type Wide = State<PlanarPose<f32>, 16, 32, Still<f32>, Moving<f32>, 2>;
    let window = RangeBearingWindow::full_circle(10.0, 0.9).unwrap();
    let sensing = || Sensing { clutter: UniformClutter::of_scan(103.0, window.measure()).unwrap(), ..lidar::<f32>() };
    let births = Births { of_static: 0.05, of_moving: 0.05 };
    let mut scratch = [(); 3].map(|()| DetectorMemory::<Vector2<f32>, 128>::new());
    let mut eyes = scratch.each_mut().map(|scratch| Detector::new(sensing(), births).unwrap().over(scratch).unwrap());
    let (mut none, mut narrow) = (Box::new(Memory::<f32>::new()), Box::new(Memory::<f32>::new()));
    let (mut wide, mut copy) = (Box::new(Wide::new()), Box::new(Wide::new()));
    let mut slam = [
        ScPhd::new(motion(), config(false), &mut *none).unwrap(),
        ScPhd::new(motion(), config(true), &mut *narrow).unwrap(),
        ScPhd::new(motion(), config(true), &mut *wide).unwrap(),
    ];
    slam.iter_mut().for_each(|slam| slam.reset(start(), 5).unwrap());
    let (mut components, mut draws) = ([0; 3], Noise::seeded(9));
    for (index, mut step) in world::<f32>(60).into_iter().enumerate() {
        step.scan.extend((0..100).map(|_| {
            let (range, bearing) = (draws.uniform::<f32>(), draws.uniform::<f32>());
            Vector2::new(10.0 * range, core::f32::consts::PI * (2.0 * bearing - 1.0))
        }));
        for ((slam, eyes), components) in slam.iter_mut().zip(&mut eyes).zip(&mut components) {
            slam.predict(&step.odometry, 0.1).unwrap();
            let report = slam.scan(eyes, &step.scan).unwrap();
            assert_eq!((report.lost, slam.audit()), (0, Ok(())), "scan {index}");
            *components += slam.map(0).count() + slam.moving_map(0).count();
        }
        let [_, narrow, wide] = &mut slam;
        let bytes = saved(|sink| wide.save(KIND, sink));
        let mut again = ScPhd::new(motion(), config(true), &mut *copy).unwrap();
        again.restore(KIND, from_slice(&bytes)).unwrap();
        assert_eq!(again.digest(), wide.digest());
        assert_eq!(saved(|sink| again.save(KIND, sink)), bytes);
        if index == 0 {
            assert!(narrow.restore(KIND, from_slice(&bytes)).is_err(), "no room for so many");
            narrow.reset(start(), 5).unwrap();
            narrow.scan(&mut eyes[1], &step.scan).unwrap();
        }
    }
    let [at_once, some, all] = components;
    assert!(5 * some < 4 * at_once && 4 * all < 3 * some, "{components:?}");
    let [at_once, _, all] = slam.each_ref().map(|slam| slam.estimate_pose().unwrap().mean);
    assert!(at_once.distance_m(&all) < 0.3, "{at_once:?} {all:?}");
}

/// With very few pages births are left out, which is reported as a raised pruning threshold; the state remains valid.
#[test]
fn births_without_room_are_left_out() {
    type Tight = State<PlanarPose<f32>, 4, 4, MapMemory<Static<Vector2<f32>>, 4, 3, 2, 24>>;
    let mut memory = Box::new(Tight::new());
    let config = Config { particles: 4, samples: 1, ..config(true) };
    let mut slam = ScPhd::new(motion(), config, &mut *memory).unwrap();
    slam.reset(start(), 5).unwrap();
    let mut scratch = Scratch::new();
    let mut eyes: Eyes<'_, f32> = detector(&mut scratch, false);
    let (mut lost, mut tightened) = (0, 0);
    for step in world::<f32>(100) {
        slam.predict(&step.odometry, 0.1).unwrap();
        let report = slam.scan(&mut eyes, &step.scan).unwrap();
        (lost, tightened) = (lost + report.lost, tightened + report.tightened);
        assert_eq!(slam.audit(), Ok(()));
    }
    assert!(lost == 0 && tightened > 0, "{lost} {tightened}");
}

/// Flips a bit of the delayed births after every prediction, and calls `before_the_scan`. Returns the final pose.
fn flipped(steps: usize, seed: u64, mut before_the_scan: impl FnMut(&mut ScPhd<'_, Unicycle<f32>>)) -> PlanarPose<f32> {
    let mut memory = Box::new(Memory::<f32>::new());
    let mut slam = ScPhd::new(motion(), config(true), &mut *memory).unwrap();
    slam.reset(start(), 5).unwrap();
    let mut scratch = Scratch::new();
    let mut eyes = detector(&mut scratch, true);
    let mut draws = Noise::seeded(seed);
    for step in world::<f32>(steps) {
        slam.predict(&step.odometry, 0.1).unwrap();
        flip_one(|each| slam.memory.waiting.words(16, each), &mut draws);
        before_the_scan(&mut slam);
        slam.scan(&mut eyes, &step.scan).unwrap();
        assert_eq!(slam.audit(), Ok(()));
    }
    slam.estimate_pose().unwrap().mean
}

/// A memory fault in the delayed births is repaired, or leaves valid data; the filter continues.
#[test]
fn flips_in_delayed_births_are_repaired_or_harmless() {
    let mut mended = 0;
    let pose = flipped(300, 3, |slam| {
        let damaged = slam.audit().is_err();
        let scrubbed = slam.scrub(&mut Scrubber::new(), 1).unwrap();
        assert_eq!(scrubbed.waiting, damaged);
        assert_eq!(slam.audit(), Ok(()));
        mended += usize::from(damaged);
    });
    assert!(mended > 10, "{mended}");
    assert!(pose.x_m.hypot(pose.y_m) < 6.0, "{pose:?}");
}

/// Without scrubbing it causes no panic, and the maps remain valid.
#[test]
fn undetected_flips_in_delayed_births_leave_the_maps_valid() {
    flipped(1000, 4, |_| ());
}
