//! The window of a joint map with an archive, in a world with more landmarks than the window can store.

use super::archive::{Archive, Entry, Split};
use super::*;
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;
use std::time::Instant;
use std::vec::Vec;

type Room<T, const N: usize, const L: usize> = JointState<PlanarPose<T>, Vector2<T>, N, L, 64>;
type Window<T> = Room<T, 40, { joint_numbers(3, 2, 40) }>;
type Wide = Room<f64, 250, { joint_numbers(3, 2, 250) }>;
type Lidar<T> = Detector<Sensing<RangeBearing<T>, RangeBearingWindow<T>, UniformClutter<T>>>;

const REACH_M: f64 = 12.0;
const DT_S: f64 = 0.25;
/// Standard deviations of the odometry, m/s and rad/s in every step.
const SIGMAS: [f64; 2] = [0.2, 0.04];

fn motion<T: Real>() -> Unicycle<T> {
    let [speed, rate] = SIGMAS.map(T::from_f64);
    Unicycle::new(Step::Arc, ControlNoise::white(speed, rate)).unwrap()
}

fn lidar<T: Real>() -> Lidar<T> {
    let real = T::from_f64;
    let window = RangeBearingWindow::full_circle(real(REACH_M), real(0.9)).unwrap();
    let sensing = Sensing::range_bearing([real(0.15), real(0.015)], window, real(2.0)).unwrap();
    Detector::new(sensing, Births::of_static(real(1e-3))).unwrap()
}

/// Landmarks, and a vehicle that drives in a circle among them.
struct World {
    landmarks: Vec<[f64; 2]>,
    pose: PlanarPose<f64>,
    radius_m: f64,
    draws: Noise,
}

impl World {
    /// 250 landmarks in a square with sides of 100 m, at least 1.5 m apart. About 140 of them come into view.
    fn new(seed: u64) -> Self {
        let mut draws = Noise::seeded(seed);
        let mut landmarks: Vec<[f64; 2]> = Vec::new();
        while landmarks.len() < 250 {
            let [x, y] = [(); 2].map(|()| 100.0 * (draws.uniform::<f64>() - 0.5));
            if landmarks.iter().all(|[other_x, other_y]| (x - other_x).hypot(y - other_y) > 1.5) {
                landmarks.push([x, y]);
            }
        }
        let radius_m = 36.0;
        Self { landmarks, pose: PlanarPose::new(radius_m, 0.0, core::f64::consts::FRAC_PI_2), radius_m, draws }
    }

    /// The odometry of the next step, and the scan after it.
    fn step<T: Real>(&mut self) -> (UnicycleControl<T>, Vec<Vector2<T>>) {
        let control = UnicycleControl { speed_mps: 2.0, rate_radps: 2.0 / self.radius_m };
        let real = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
        self.pose = real.propagate(&self.pose, &control, DT_S);
        let odometry = UnicycleControl {
            speed_mps: T::from_f64(control.speed_mps + SIGMAS[0] * self.draws.normal::<f64>()),
            rate_radps: T::from_f64(control.rate_radps + SIGMAS[1] * self.draws.normal::<f64>()),
        };
        let mut seen = Vec::new();
        let mut see = |range: f64, bearing: f64| seen.push(Vector2::new(range, wrap(bearing)).map(T::from_f64));
        for [x, y] in &self.landmarks {
            let (dx, dy) = (x - self.pose.x_m, y - self.pose.y_m);
            if dx.hypot(dy) < REACH_M && self.draws.uniform::<f64>() < 0.9 {
                let noise = [0.15 * self.draws.normal::<f64>(), 0.015 * self.draws.normal::<f64>()];
                see(dx.hypot(dy) + noise[0], dy.atan2(dx) - self.pose.heading_rad + noise[1]);
            }
        }
        for _ in 0..2 {
            let (range, turn) = (REACH_M * self.draws.uniform::<f64>(), self.draws.uniform::<f64>());
            see(range.max(0.1), core::f64::consts::TAU * turn);
        }
        (odometry, seen)
    }

    fn start<T: Real>(&self) -> PlanarPose<T> {
        let [x, y, heading] = self.pose.on_ground().map(T::from_f64);
        PlanarPose::new(x, y, heading)
    }
}

/// The errors of several runs, step by step, and the sums of their counts.
#[derive(Debug, Default)]
struct Score {
    squares: Vec<f64>,
    nees: Vec<f64>,
    archived: usize,
    reactivated: usize,
    merged: usize,
    lost: usize,
}

impl Score {
    /// Drives about three laps.
    fn take<T: Real, A: Archive<PlanarPose<T>>>(
        &mut self,
        slam: &mut JointSlam<'_, Unicycle<T>, Vector2<T>, A>,
        world: &mut World,
    ) {
        let eyes = lidar();
        slam.reset(world.start()).unwrap();
        for _ in 0..1320 {
            let (odometry, seen) = world.step();
            slam.predict(&odometry, T::from_f64(DT_S)).unwrap();
            let report = slam.scan(&eyes, &seen).unwrap();
            self.archived += report.archived;
            self.reactivated += report.reactivated;
            self.merged += report.merged;
            self.lost += report.lost + report.evicted;
            let pose = slam.estimate_pose().unwrap();
            let [x, y, _] = pose.mean.on_ground().map(T::to_f64);
            let off = Vector2::new(x - world.pose.x_m, y - world.pose.y_m);
            let covariance = Symmetric::<Vector2<f64>>::from_fn(|r, c| pose.covariance.get(r, c).to_f64());
            self.squares.push(off.norm_squared());
            self.nees.push(covariance.factor().unwrap().mahalanobis(&off) / 2.0);
        }
    }

    /// RMSE, m, and the median, mean and 95th percentile of NEES/2.
    fn figures(&mut self) -> [f64; 4] {
        let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
        let (rmse, mean) = (mean(&self.squares).sqrt(), mean(&self.nees));
        self.nees.sort_by(f64::total_cmp);
        let at = |probability: usize| self.nees[self.nees.len() * probability / 100];
        [rmse, at(50), mean, at(95)]
    }
}

fn with_window<T: Real>(seeds: core::ops::Range<u64>) -> Score {
    let mut score = Score::default();
    for seed in seeds {
        let (mut state, mut archive) = (Box::new(Window::<T>::new()), Box::new(JointArchive::<_, 300>::new()));
        let config =
            JointConfig { persistence: Persistence::FOR_EVER, occlusion_factor: T::ONE, ..JointConfig::default() };
        let slam = JointSlam::new(motion(), config, &mut *state).unwrap();
        score.take(&mut slam.with_archive(&mut archive, T::from_f64(REACH_M)).unwrap(), &mut World::new(seed));
    }
    score
}

/// The settings were chosen on the seeds 0 to 15.
#[test]
fn a_window_of_forty_is_consistent_over_three_rounds() {
    let mut score = with_window::<f32>(100..110);
    let figures = score.figures();
    std::println!(
        "window: {figures:.3?} archived {} reactivated {} merged {}",
        score.archived,
        score.reactivated,
        score.merged
    );
    let [rmse, median, mean, _] = figures;
    assert!(rmse < 1.4 && (0.3..1.4).contains(&median) && mean < 5.0, "{figures:?}");
    let Score { archived, reactivated, lost, .. } = score;
    assert!(
        archived > 3000 && reactivated > 2000 && lost < 20,
        "{archived} archived, {reactivated} reactivated, {lost} lost"
    );
}

/// For the figures of docs/joint.md.
#[test]
#[ignore = "minutes"]
fn a_window_with_an_archive_with_none_and_with_room_for_all() {
    let seeds = 100..120;
    let [mut drop, mut all] = [(); 2].map(|()| Score::default());
    for seed in seeds.clone() {
        let (mut state, mut wide) = (Box::new(Window::<f64>::new()), Box::new(Wide::new()));
        let mut slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
        drop.take(&mut slam, &mut World::new(seed));
        let mut slam = JointSlam::new(motion(), JointConfig::default(), &mut *wide).unwrap();
        all.take(&mut slam, &mut World::new(seed));
    }
    for (name, mut score) in [("drop", drop), ("window", with_window::<f64>(seeds)), ("all", all)] {
        std::println!("{name}: {:.3?} lost {}", score.figures(), score.lost);
    }
}

/// An archived feature far away.
fn far_away(label: u32) -> Entry<PlanarPose<f32>> {
    let existence = existence::Existence::of(1.0);
    let mean = Vector2::new(1000.0 + label as f32, -500.0);
    Entry { label, submap: label / 8, mean, existence, detections: 9.0, ..Entry::ZERO }
}

#[test]
fn the_time_of_a_scan_does_not_depend_on_the_size_of_the_archive() {
    let mut least = [[f64::INFINITY; 150]; 2];
    for round in 0..6 {
        let mut states = [(); 2].map(|()| Box::new(Window::<f32>::new()));
        let mut archives = [(); 2].map(|()| Box::new(JointArchive::<PlanarPose<f32>, 1200>::new()));
        let mut worlds = [(); 2].map(|()| World::new(7));
        let mut slams = Vec::new();
        for ((state, archive), features) in states.iter_mut().zip(&mut archives).zip([60, 960]) {
            let slam = JointSlam::new(motion(), JointConfig::default(), &mut **state).unwrap();
            let mut slam = slam.with_archive(archive, REACH_M as f32).unwrap();
            slam.reset(worlds[0].start()).unwrap();
            let mut view = slam.archive.view().unwrap();
            // New submaps get identifiers that these features do not have.
            view.index.next_submap = 1_000;
            (0..features).for_each(|label| assert_eq!(view.put(far_away(label)), 0));
            slams.push(slam);
        }
        for step in 0..150 {
            // Each filter is first in every second round, because the second one finds all data in the cache.
            for turn in 0..2 {
                let which = (round + turn) % 2;
                let (slam, world, least) = (&mut slams[which], &mut worlds[which], &mut least[which]);
                let (odometry, seen) = world.step();
                slam.predict(&odometry, DT_S as f32).unwrap();
                let started = Instant::now();
                slam.scan(&lidar(), &seen).unwrap();
                least[step] = least[step].min(started.elapsed().as_secs_f64());
            }
        }
        assert!(slams[1].held() > slams[0].held() + 800);
    }
    // From the step on in which the window is full.
    let [few, many] = least.map(|of| of[70..].iter().sum::<f64>());
    std::println!("{:.3} times as long", many / few);
    assert!(many < 1.2 * few, "{few} s with a hundred features, {many} s with a thousand");
}

#[test]
fn archived_features_keep_their_labels() {
    let (mut state, mut archive) = (Box::new(Window::<f64>::new()), Box::new(JointArchive::<_, 300>::new()));
    let slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
    let mut slam = slam.with_archive(&mut archive, REACH_M).unwrap();
    let mut world = World::new(102);
    slam.reset(world.start()).unwrap();
    let mut drive = |slam: &mut JointSlam<'_, _, _, _>, steps: usize| {
        for _ in 0..steps {
            let (odometry, seen) = world.step();
            slam.predict(&odometry, DT_S).unwrap();
            slam.scan(&lidar(), &seen).unwrap();
        }
    };
    drive(&mut slam, 30);
    let early: Vec<_> = slam.features().map(|feature| feature.label).collect();
    // Half a lap later these features are in the archive, except the anchors, and still in the map.
    drive(&mut slam, 200);
    let archived = |slam: &JointSlam<'_, _, _, Archived<'_, _>>| {
        let kept: Vec<_> = slam.archive.kept().iter().map(|entry: &Entry<PlanarPose<f64>>| entry.label).collect();
        early.iter().filter(|&label| kept.contains(label)).count()
    };
    let anchors = slam.memory.landmarks.iter().take(slam.memory.header.len).filter(|landmark| landmark.is_anchor);
    let anchors = anchors.filter(|landmark| early.contains(&landmark.label)).count();
    assert!(early.len() >= 10 && archived(&slam) > 5, "{anchors} of {early:?}");
    assert!((archived(&slam) + anchors) * 10 >= early.len() * 8, "{early:?}");
    let in_map = slam.features().filter(|feature| early.contains(&feature.label)).count();
    assert!(in_map + 1 >= early.len() && early.iter().all(|&label| slam.existence(label).is_some()));
    assert_eq!(slam.held(), slam.memory.header.len + slam.archive.kept().len());
    // After the whole lap they are in the window again, with the same labels.
    drive(&mut slam, 240);
    let found = early.iter().filter(|&&label| slam.existence(label).is_some()).count();
    assert!(
        archived(&slam) * 2 <= early.len() && found * 10 >= early.len() * 8,
        "{found}, {} archived of {}",
        archived(&slam),
        early.len()
    );
}

/// The only submap within reach is the one that was tried last: it is re-activated once, and none of its features twice.
#[test]
fn a_submap_is_tried_once_in_a_scan() {
    let (mut state, mut archive) = (Box::new(Window::<f32>::new()), Box::new(JointArchive::<_, 300>::new()));
    let slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
    let mut slam = slam.with_archive(&mut archive, REACH_M as f32).unwrap();
    slam.reset(PlanarPose::new(0.0, 0.0, 0.0)).unwrap();
    let places = [[4.0, 1.0], [5.0, -2.0], [6.5, 3.0]];
    let mut view = slam.archive.view().unwrap();
    view.index.next_submap = 1;
    for (label, place) in (0..).zip(places) {
        let known = Split { own: Symmetric::from_diagonal([0.01; 2]), ..Split::ZERO };
        let mean = Vector2::from(place);
        view.put(Entry { label, submap: 0, mean, alone: known, given: known, ..far_away(label) });
    }
    // Two scans detect none of its features, the third one all of them.
    for _ in 0..2 {
        let report = slam.scan(&lidar(), &[]).unwrap();
        assert_eq!((report.reactivated, slam.held()), (0, 3));
    }
    let seen = places.map(|[x, y]: [f32; 2]| Vector2::new(x.hypot(y), (y / x).atan()));
    let report = slam.scan(&lidar(), &seen).unwrap();
    assert_eq!((report.reactivated, report.births, slam.held()), (3, 0, 3));
}

#[test]
fn a_full_archive_loses_the_least_certain_features() {
    let mut archive = Box::new(JointArchive::<PlanarPose<f32>, 3>::new());
    let mut archived = archive.archived(1.0);
    let mut view = archived.view().unwrap();
    let of = |label: u32, visible: f32| {
        let existence = existence::Existence::of(visible);
        Entry { existence, ..far_away(label) }
    };
    let gone = [of(1, 0.9), of(2, 0.5), of(3, 0.8), of(4, 0.7), of(5, 0.6)].map(|entry| view.put(entry));
    assert_eq!(gone, [0, 0, 0, 1, 1]);
    let mut labels: Vec<_> = archived.kept().iter().map(|entry| entry.label).collect();
    labels.sort_unstable();
    assert_eq!(labels, [1, 3, 4]);
}

fn go<A: Archive<PlanarPose<f32>>>(
    slam: &mut JointSlam<'_, Unicycle<f32>, Vector2<f32>, A>,
    odometry: &UnicycleControl<f32>,
    seen: &[Vector2<f32>],
) {
    slam.predict(odometry, DT_S as f32).unwrap();
    slam.scan(&lidar(), seen).unwrap();
}

#[test]
fn a_snapshot_contains_the_archive() {
    let (mut state, mut archive) = (Box::new(Window::<f32>::new()), Box::new(JointArchive::<_, 200>::new()));
    let slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
    let mut slam = slam.with_archive(&mut archive, REACH_M as f32).unwrap();
    let mut world = World::new(3);
    slam.reset(world.start()).unwrap();
    for step in 0..600 {
        let (odometry, seen) = world.step();
        go(&mut slam, &odometry, &seen);
        if step % 100 != 99 {
            continue;
        }
        let mut bytes = Vec::new();
        let sink = |part: &[u8]| {
            bytes.extend_from_slice(part);
            Ok::<(), ()>(())
        };
        slam.save(1, sink).unwrap();
        let (mut state, mut archive) = (Box::new(Window::<f32>::new()), Box::new(JointArchive::<_, 250>::new()));
        let mut plain = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
        assert!(matches!(plain.restore(1, from_slice(&bytes)), Err(RestoreError::NoRoom { .. })));
        let mut same = plain.with_archive(&mut archive, REACH_M as f32).unwrap();
        same.restore(1, from_slice(&bytes)).unwrap();
        assert_eq!((same.digest(), same.held(), same.audit()), (slam.digest(), slam.held(), Ok(())));
        let (odometry, seen) = world.step();
        go(&mut slam, &odometry, &seen);
        go(&mut same, &odometry, &seen);
        assert_eq!(same.digest(), slam.digest());
    }
    assert!(slam.archive.kept().len() > 40);
}

#[test]
fn with_any_input_window_and_archive_stay_finite() {
    let mut draws = Noise::seeded(12);
    let mut moved = [0, 0, 0];
    for _ in 0..40 {
        type Small = Room<f32, 12, { joint_numbers(3, 2, 12) }>;
        let (mut state, mut archive) = (Box::new(Small::new()), Box::new(JointArchive::<_, 10>::new()));
        let slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
        let mut slam = slam.with_archive(&mut archive, 6.0).unwrap();
        slam.reset(PlanarPose::ZERO).unwrap();
        for _ in 0..300 {
            let mut pick = |values: &[f32]| {
                let place = (draws.uniform::<f64>() * values.len() as f64) as usize;
                values[place.min(values.len() - 1)]
            };
            let control = UnicycleControl {
                speed_mps: pick(&[0.0, 3.0, -3.0, 9.0, -9.0, 300.0, f32::NAN]),
                rate_radps: pick(&[0.0, 0.0, 0.0, 0.2, f32::INFINITY]),
            };
            let _refused = slam.predict(&control, pick(&[0.0, 0.1, 1.0, 1e20, -1.0]));
            let count = pick(&[0.0, 3.0, 6.0, 9.0]) as usize;
            let scan: Vec<_> = (0..count)
                .map(|_| Vector2::new(pick(&[0.0, 0.5, 5.0, 5.1, 11.0, 1e7, -4.0]), pick(&[0.0, 0.01, 1.0, -1.0, 1e6])))
                .collect();
            if let Ok(report) = slam.scan(&lidar(), &scan) {
                let counts = [report.archived, report.reactivated, report.evicted];
                moved.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
            }
            assert_eq!(slam.audit(), Ok(()));
            let covariance = slam.estimate_pose().unwrap().covariance;
            assert!((0..3).all(|k| covariance.get(k, k) >= 0.0), "{covariance:?}");
        }
    }
    assert!(moved.iter().all(|&count| count > 20), "{moved:?}");
}

#[test]
fn a_loaded_map_replaces_window_and_archive() {
    let mut state = Box::new(Window::<f32>::new());
    let mut archive = Box::new(JointArchive::<PlanarPose<f32>, 400>::new());
    let slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
    let mut slam = slam.with_archive(&mut archive, REACH_M as f32).unwrap();
    let mut world = World::new(5);
    slam.reset(PlanarPose::new(36.0, 0.0, core::f32::consts::FRAC_PI_2)).unwrap();
    for _ in 0..300 {
        let (control, scan) = world.step();
        slam.predict(&control, DT_S as f32).unwrap();
        slam.scan(&lidar(), &scan).unwrap();
    }
    assert!(slam.held() > 60);
    let near: Vec<_> = slam.features().take(20).collect();
    slam.load_map(&near).unwrap();
    assert_eq!(slam.held(), 20);
    let (_, scan) = world.step();
    let report = slam.localise(&lidar(), &scan).unwrap();
    assert!(report.detections > 1.0 && slam.held() == 20 && slam.audit().is_ok(), "{report:?}");
}

#[test]
fn an_invalid_reach_is_refused() {
    for reach_m in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let (mut state, mut archive) = (Box::new(Window::<f32>::new()), JointArchive::<_, 2>::new());
        let slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
        assert!(slam.with_archive(&mut archive, reach_m).is_err());
    }
}
