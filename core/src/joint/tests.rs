//! The joint filter against closed forms, and with extreme and invalid input.

use super::course::{self, Course, motion};
use super::*;
use crate::tests::alone::Lidar;
use crate::tests::linear::{Drift, linear_sensing};
use crate::*;
use nalgebra::{Matrix2, SMatrix, SVector, Vector2};
use std::boxed::Box;
use std::vec::Vec;

type Linear<const N: usize, const L: usize> = JointState<PlanarPose<f64>, Vector2<f64>, N, L, 16>;

/// Positions of landmarks, m. They are so far apart that every measurement has one possible origin.
const LANDMARKS: [[f64; 2]; 4] = [[300.0, 0.0], [0.0, 400.0], [-500.0, 20.0], [40.0, -600.0]];

#[test]
fn with_linear_models_and_known_association_it_is_the_kalman_filter() {
    let sensing = linear_sensing([0.09, 0.16], 1.0 - 1e-15, 1e-60);
    let detector = Detector::new(sensing, Births::of_static(1e-16)).unwrap();
    let config = JointConfig { gate: 400.0, ..JointConfig::default() };
    let mut state = Box::new(Linear::<4, { joint_numbers(3, 2, 4) }>::new());
    let mut slam = JointSlam::new(Drift { sigmas: [0.5, 0.2] }, config, &mut *state).unwrap();
    slam.reset(PlanarPose::new(1.0, -2.0, 0.3)).unwrap();
    let mut draws = Noise::seeded(4);

    // The same with full matrices; the heading has no effect.
    let r = Matrix2::new(0.09, 0.0, 0.0, 0.16);
    let (mut x, mut p) = (SVector::<f64, 10>::zeros(), SMatrix::<f64, 10, 10>::zeros());
    (x[0], x[1]) = (1.0, -2.0);
    let mut n = 2;
    let mut truth = Vector2::new(1.0, -2.0);
    for step in 0..40 {
        let control = Vector2::new(0.7, if step % 8 < 4 { 0.3 } else { -0.5 });
        slam.predict(&control, 0.5).unwrap();
        truth += control * 0.5 + Vector2::new(0.35 * draws.normal::<f64>(), 0.14 * draws.normal::<f64>());
        x[0] += control.x * 0.5;
        x[1] += control.y * 0.5;
        p[(0, 0)] += 0.125;
        p[(1, 1)] += 0.02;
        // The last landmark is detected only later, and the first one is out of view for a while.
        let seen = |k: usize| (k < 3 || step > 10) && (k > 0 || !(15..25).contains(&step));
        let kept: Vec<usize> = (0..4).filter(|&k| seen(k)).collect();
        let z: Vec<Vector2<f64>> = kept
            .iter()
            .map(|&k| {
                let noise = Vector2::new(0.3 * draws.normal::<f64>(), 0.4 * draws.normal::<f64>());
                Vector2::from(LANDMARKS[k]) - truth + noise
            })
            .collect();
        slam.scan(&detector, &z).unwrap();
        let order: Vec<Option<usize>> = (0..4).map(|k| kept.iter().position(|&of| of == k)).collect();
        for (k, index) in order.iter().enumerate() {
            let Some(index) = *index else { continue };
            let at = 2 + 2 * k;
            if n <= at {
                // A new landmark: the position of the vehicle plus the measurement.
                for d in 0..2 {
                    x[n + d] = x[d] + z[index][d];
                    for column in 0..n {
                        p[(n + d, column)] = p[(d, column)];
                        p[(column, n + d)] = p[(d, column)];
                    }
                    for other in 0..2 {
                        p[(n + d, n + other)] = p[(d, other)] + r[(d, other)];
                    }
                }
                n += 2;
                continue;
            }
            let mut h = SMatrix::<f64, 2, 10>::zeros();
            for d in 0..2 {
                h[(d, d)] = -1.0;
                h[(d, at + d)] = 1.0;
            }
            let s = h * p * h.transpose() + r;
            let gain = p * h.transpose() * s.try_inverse().unwrap();
            x += gain * (z[index] - h * x);
            p -= gain * s * gain.transpose();
        }
        let pose = slam.estimate_pose().unwrap();
        assert!((pose.mean.x_m - x[0]).abs() < 1e-9 && (pose.mean.y_m - x[1]).abs() < 1e-9, "{step} {pose:?} {x}");
        for row in 0..2 {
            for column in 0..2 {
                let off = pose.covariance.get(row, column) - p[(row, column)];
                assert!(off.abs() < 1e-9, "{step}: {off}");
            }
        }
        assert_eq!(slam.held(), (n - 2) / 2);
        // Means of the features, and all covariances of features and pose. The filter has the heading at index 2 in
        // addition.
        let with_heading = |index: usize| if index < 2 { index } else { index + 1 };
        for (at, off) in (2..n).map(|at| (at, slam.memory.landmarks[(at - 2) / 2].mean[at % 2] - x[at])) {
            assert!(off.abs() < 1e-9, "{step}, {at}: {off}");
        }
        for (row, column) in (0..n).flat_map(|row| (0..n).map(move |column| (row, column))) {
            let off = slam.memory.joint.get(with_heading(row), with_heading(column)) - p[(row, column)];
            assert!(off.abs() < 1e-9, "{step}, {row}, {column}: {off}");
        }
    }
}

#[test]
fn a_feature_that_contradicts_those_before_it_corrects_nothing() {
    let sensing = linear_sensing([0.09, 0.16], 0.999, 1e-60);
    let detector = Detector::new(sensing, Births::of_static(1e-16)).unwrap();
    let told_by = |shifts: &[f64]| {
        let mut state = Box::new(Linear::<4, { joint_numbers(3, 2, 4) }>::new());
        let mut slam = JointSlam::new(Drift { sigmas: [0.5, 0.2] }, JointConfig::default(), &mut *state).unwrap();
        slam.reset(PlanarPose::new(0.0, 0.0, 0.0)).unwrap();
        let seen: Vec<Vector2<f64>> = LANDMARKS[..2].iter().map(|&landmark| Vector2::from(landmark)).collect();
        for _ in 0..20 {
            slam.scan(&detector, &seen).unwrap();
        }
        slam.scatter(&Symmetric::from_diagonal([1.0, 1.0, 0.0])).unwrap();
        let shifted: Vec<_> = seen.iter().zip(shifts).map(|(z, &by)| z + Vector2::new(by, 0.0)).collect();
        let report = slam.scan(&detector, &shifted).unwrap();
        (slam.estimate_pose().unwrap(), report)
    };
    let (alone, both) = (told_by(&[4.0]), told_by(&[4.0, -4.0]));
    assert!((alone.0.mean.x_m + 4.0).abs() < 0.5, "{:?}", alone.0);
    assert_eq!(both.0, alone.0);
    assert!(both.1.innovation > 4.0 * alone.1.innovation, "{:?} {:?}", both.1, alone.1);
    // If the two disagree by less, both correct the pose.
    let (alone, both) = (told_by(&[1.0]), told_by(&[1.0, -1.0]));
    assert!(both.0.mean.x_m > alone.0.mean.x_m + 0.5, "{:?} {:?}", both.0, alone.0);
}

type Car<T, const N: usize, const L: usize, const Z: usize> = JointState<PlanarPose<T>, Vector2<T>, N, L, Z>;

fn lidar<T: Real>() -> Detector<Lidar<T>> {
    course::lidar(2.0, Births::of_static(1e-3))
}

type CarSlam<'s, T> = JointSlam<'s, Unicycle<T>, Vector2<T>>;

fn run<T: Real>(
    slam: &mut CarSlam<'_, T>,
    course: &mut Course,
    steps: usize,
    hidden: impl Fn(usize) -> bool + Copy,
) -> JointReport<T> {
    let mut last = None;
    for _ in 0..steps {
        let (odometry, seen) = course.step(hidden);
        let [speed_mps, rate_radps] = [odometry.speed_mps, odometry.rate_radps].map(T::from_f64);
        slam.predict(&UnicycleControl { speed_mps, rate_radps }, T::from_f64(0.1)).unwrap();
        let seen: Vec<_> = seen.iter().map(|z| z.map(T::from_f64)).collect();
        last = Some(slam.scan(&lidar(), &seen).unwrap());
    }
    last.unwrap()
}

const ROOM: usize = 48;

#[test]
fn a_round_trip_is_accurate_and_consistent() {
    let mut squares = 0.0;
    let runs = 20;
    for seed in 0..runs {
        let mut state = Box::new(Car::<f32, ROOM, { joint_numbers(3, 2, ROOM) }, 32>::new());
        let config = JointConfig { persistence: Persistence::FOR_EVER, ..JointConfig::default() };
        let mut slam = JointSlam::new(motion(), config, &mut *state).unwrap();
        let mut course = Course::new(seed, false, 2);
        slam.reset(PlanarPose::new(8.0, 0.0, core::f32::consts::FRAC_PI_2)).unwrap();
        run(&mut slam, &mut course, 300, |_| false);
        let pose = slam.estimate_pose().unwrap();
        let off = Vector2::new(f64::from(pose.mean.x_m) - course.pose.x_m, f64::from(pose.mean.y_m) - course.pose.y_m);
        assert!(off.norm() < 0.2, "{off}");
        let covariance = Symmetric::<Vector2<f64>>::from_fn(|r, c| f64::from(pose.covariance.get(r, c)));
        squares += covariance.factor().unwrap().mahalanobis(&off) / 2.0;
        assert_eq!(slam.features().count(), 12, "seed {seed}");
    }
    // Mean of 40 squared standard normal numbers: within five standard deviations.
    let nees = squares / runs as f64;
    assert!((0.3..2.2).contains(&nees), "{nees}");
}

#[test]
fn both_precisions_agree_and_a_full_state_goes_on() {
    let mut coarse = Box::new(Car::<f32, ROOM, { joint_numbers(3, 2, ROOM) }, 32>::new());
    let mut fine = Box::new(Car::<f64, ROOM, { joint_numbers(3, 2, ROOM) }, 32>::new());
    let mut slam32 = JointSlam::new(motion(), JointConfig::default(), &mut *coarse).unwrap();
    let mut slam64 = JointSlam::new(motion(), JointConfig::default(), &mut *fine).unwrap();
    slam32.reset(PlanarPose::new(8.0, 0.0, core::f32::consts::FRAC_PI_2)).unwrap();
    slam64.reset(PlanarPose::new(8.0, 0.0, core::f64::consts::FRAC_PI_2)).unwrap();
    run(&mut slam32, &mut Course::new(3, false, 2), 200, |_| false);
    run(&mut slam64, &mut Course::new(3, false, 2), 200, |_| false);
    let (a, b) = (slam32.estimate_pose().unwrap().mean, slam64.estimate_pose().unwrap().mean);
    assert!((f64::from(a.x_m) - b.x_m).abs() < 2e-3 && (f64::from(a.y_m) - b.y_m).abs() < 2e-3, "{a:?} {b:?}");
    // Capacity for a third of the landmarks.
    let mut small = Box::new(Car::<f32, 4, { joint_numbers(3, 2, 4) }, 32>::new());
    let mut slam = JointSlam::new(motion(), JointConfig::default(), &mut *small).unwrap();
    slam.reset(PlanarPose::new(8.0, 0.0, core::f32::consts::FRAC_PI_2)).unwrap();
    let report = run(&mut slam, &mut Course::new(3, false, 2), 200, |_| false);
    assert!(report.lost > 0 && report.health.contains(Health::COMPONENTS_LOST) && slam.held() <= 4);
}

/// A landmark is detected for 60 s, then missed for 10 s, and then detected again or not. Returns whether the map has
/// it with the same label: before, after the 10 s, a second later, and three minutes after that.
fn missing_for_a_while<T: Real>(seed: u64, comes_back: bool) -> [bool; 4] {
    let mut state = Box::new(Car::<T, ROOM, { joint_numbers(3, 2, ROOM) }, 32>::new());
    let mut slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
    let mut course = Course::new(seed, false, 2);
    slam.reset(PlanarPose::new(T::from_f64(8.0), T::ZERO, T::PI / T::from_f64(2.0))).unwrap();
    run(&mut slam, &mut course, 600, |_| false);
    // The first landmark is at (12, 0).
    let near = |feature: &Component<Vector2<T>>| (feature.mean.x.to_f64() - 12.0).hypot(feature.mean.y.to_f64()) < 0.5;
    let known = slam.features().find(near).map(|feature| feature.label);
    let has = |slam: &CarSlam<'_, T>| slam.features().any(|feature| near(&feature) && Some(feature.label) == known);
    let before = known.is_some();
    run(&mut slam, &mut course, 100, |k| k == 0);
    let missing = has(&slam);
    run(&mut slam, &mut course, 10, |k| k == 0 && !comes_back);
    let soon = has(&slam);
    run(&mut slam, &mut course, 1800, |k| k == 0 && !comes_back);
    [before, missing, soon, has(&slam)]
}

/// A missed landmark is first assumed to be occluded and stays in the map; within minutes it is dropped. With the
/// default configuration, in both precisions.
#[test]
fn an_occluded_landmark_stays_and_a_removed_one_is_dropped() {
    fn of<T: Real>(seeds: u64) {
        for seed in 0..seeds {
            assert_eq!(missing_for_a_while::<T>(seed, true), [true; 4], "seed {seed}");
            assert_eq!(missing_for_a_while::<T>(seed, false), [true, true, true, false], "seed {seed}");
        }
    }
    of::<f32>(4);
    of::<f64>(1);
}

#[test]
fn invalid_input_is_refused_and_leaves_the_state_unchanged() {
    let mut state = Box::new(Car::<f32, 4, { joint_numbers(3, 2, 4) }, 2>::new());
    let mut slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
    let ahead = UnicycleControl { speed_mps: 1.0, rate_radps: 0.0 };
    assert_eq!(slam.predict(&ahead, 0.1).unwrap_err(), PredictError::NotStarted);
    assert_eq!(slam.scan(&lidar(), &[]).unwrap_err(), ScanError::NotStarted);
    assert!(slam.estimate_pose().is_none());
    assert_eq!(slam.reset(PlanarPose::new(f32::NAN, 0.0, 0.0)).unwrap_err(), ResetError::NonFinitePose);
    slam.reset(PlanarPose::ZERO).unwrap();
    assert_eq!(slam.predict(&ahead, -1.0).unwrap_err(), PredictError::TimeStep);
    let fast = UnicycleControl { speed_mps: 1e6, ..ahead };
    assert_eq!(slam.predict(&fast, 0.1).unwrap_err(), PredictError::Implausible(Implausible::Speed));
    let bad = [SVector::from([1.0, f32::NAN])];
    assert_eq!(slam.scan(&lidar(), &bad).unwrap_err(), ScanError::NonFinite { index: 0 });
    let many = [SVector::from([1.0, 0.0]); 3];
    assert_eq!(
        slam.scan(&lidar(), &many).unwrap_err(),
        ScanError::TooManyMeasurements { measurements: 3, capacity: 2 }
    );
    assert_eq!(slam.estimate_pose().unwrap().mean, PlanarPose::ZERO);
    assert_eq!(slam.scan(&lidar(), &[]).unwrap().refused, 2);
    for (field, config) in [
        ("birth_probability_min", JointConfig { birth_probability_min: 1.5, ..JointConfig::default() }),
        ("gate", JointConfig { gate: f32::NAN, ..JointConfig::default() }),
        (
            "persistence.occluded_s",
            JointConfig {
                persistence: Persistence { occluded_s: 0.0, ..Persistence::FOR_EVER },
                ..JointConfig::default()
            },
        ),
    ] {
        assert_eq!(config.check().unwrap_err().field, field);
    }
}

#[test]
fn unknown_landmarks_give_no_information_on_the_heading() {
    // Odometry with an error proportional to its controls: 2 % of the speed, 30 % of the turn rate.
    let noise = ControlNoise { speed_sigma_ratio: 0.02, turn_sigma_ratio: 0.3, ..ControlNoise::white(0.0, 0.0) };
    let motion = Unicycle::new(Step::Arc, noise).unwrap();
    let mut state = Box::new(Car::<f64, 40, { joint_numbers(3, 2, 40) }, 32>::new());
    let mut slam = JointSlam::new(motion, JointConfig::default(), &mut *state).unwrap();
    slam.reset(PlanarPose::new(0.0, 0.0, 0.0)).unwrap();
    let mut draws = Noise::seeded(7);
    // Turns without landmarks, until the standard deviation of the heading is about 0.2 rad; then unknown landmarks,
    // and only straight motion, forwards and backwards.
    let mut truth = PlanarPose::new(0.0, 0.0, 0.0);
    let mut drive = |slam: &mut CarSlam<'_, f64>, truth: &mut PlanarPose<f64>, v: f64, w: f64| {
        let u = UnicycleControl { speed_mps: v, rate_radps: w };
        slam.predict(&u, 0.1).unwrap();
        let actual = UnicycleControl { speed_mps: v * (1.0 + 0.02 * draws.normal::<f64>()), rate_radps: 1.2 * w };
        *truth = motion.propagate(truth, &actual, 0.1);
    };
    for step in 0..40 {
        drive(&mut slam, &mut truth, 0.0, if step < 20 { 1.0 } else { -0.9 });
    }
    let heading = |slam: &CarSlam<'_, f64>| slam.estimate_pose().unwrap().covariance.get(2, 2);
    let before = heading(&slam);
    assert!(before > 0.02, "{before}");
    let mut scatter = Noise::seeded(8);
    for step in 0..400 {
        drive(&mut slam, &mut truth, if step % 100 < 50 { 1.0 } else { -1.0 }, 0.0);
        let z: Vec<_> = [[6.0_f64, 3.0_f64], [9.0, -4.0], [2.0, 5.0], [12.0, 1.0]]
            .iter()
            .map(|[x, y]| {
                let (dx, dy) = (x - truth.x_m, y - truth.y_m);
                let noise = Vector2::new(0.1 * scatter.normal::<f64>(), 0.01 * scatter.normal::<f64>());
                Vector2::new(dx.hypot(dy), wrap(dy.atan2(dx) - truth.heading_rad)) + noise
            })
            .collect();
        slam.scan(&lidar(), &z).unwrap();
    }
    let after = heading(&slam);
    assert!((after / before - 1.0).abs() < 1e-9, "{before} {after}");
}

#[test]
fn a_landmark_is_found_at_a_low_birth_intensity() {
    // A birth intensity of a thousandth of the clutter intensity: one detection hardly gives a landmark, two at one
    // position do.
    let clutter = lidar::<f64>().sensing().clutter.intensity();
    let detector = course::lidar(2.0, Births::of_static(clutter / 1000.0));
    let mut state = Box::new(Car::<f64, 8, { joint_numbers(3, 2, 8) }, 4>::new());
    let mut slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
    slam.reset(PlanarPose::new(0.0, 0.0, 0.0)).unwrap();
    let mut draws = Noise::seeded(3);
    for step in 0..10 {
        slam.predict(&UnicycleControl { speed_mps: 0.0, rate_radps: 0.0 }, 0.1).unwrap();
        let noise = Vector2::new(0.1 * draws.normal::<f64>(), 0.01 * draws.normal::<f64>());
        // One false measurement, at another position in every scan.
        let elsewhere = Vector2::new(4.0 + f64::from(step), -2.0 + 0.3 * f64::from(step));
        slam.scan(&detector, &[Vector2::new(7.0, 0.5) + noise, elsewhere]).unwrap();
    }
    let features: Vec<_> = slam.features().collect();
    assert_eq!(features.len(), 1, "{features:?}");
    assert!((features[0].mean - Vector2::new(7.0 * 0.5_f64.cos(), 7.0 * 0.5_f64.sin())).norm() < 0.2);
}

#[test]
fn without_clutter_and_births_nothing_is_initiated() {
    let Sensing { sensor, field_of_view, .. } = *lidar::<f32>().sensing();
    let clutter = UniformClutter::of_scan(0.0, field_of_view.measure()).unwrap();
    let detector = Detector::new(Sensing { sensor, field_of_view, clutter }, Births::NONE).unwrap();
    let mut state = Box::new(Car::<f32, 4, { joint_numbers(3, 2, 4) }, 4>::new());
    let mut slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
    slam.reset(PlanarPose::new(0.0, 0.0, 0.0)).unwrap();
    let report = slam.scan(&detector, &[Vector2::new(7.0, 0.5)]).unwrap();
    assert_eq!((report.births, slam.features().count()), (0, 0));
    assert!(report.health.contains(Health::UNEXPLAINED_SCAN));
}

/// The features of a loaded map may have any label; births continue from the greatest one.
#[test]
fn missed_features_of_a_loaded_map_are_dropped_at_any_label() {
    let index = |label: u32, x: f32| Component {
        label,
        ln_weight: -0.01,
        mean: Vector2::new(x, 1.0),
        covariance: Symmetric::from_diagonal([0.01, 0.01]),
    };
    let last = CarSlam::<f32>::GREATEST_LOADED_LABEL;
    let config = JointConfig { persistence: Persistence::FOR_EVER, occlusion_factor: 1.0, ..JointConfig::default() };
    for other in [10, last] {
        let mut state = Box::new(Car::<f32, 8, { joint_numbers(3, 2, 8) }, 4>::new());
        let mut slam = JointSlam::new(motion(), config, &mut *state).unwrap();
        slam.reset(PlanarPose::new(0.0, 0.0, 0.0)).unwrap();
        slam.load_map(&[index(0, 5.0), index(other, -5.0)]).unwrap();
        for scan in 0..200 {
            slam.predict(&UnicycleControl { speed_mps: 0.0, rate_radps: 0.0 }, 0.1).unwrap();
            let new = Vector2::new(8.0 + 0.05 * scan as f32, 2.0);
            slam.scan(&lidar(), &[new]).unwrap();
        }
        let landmarks = slam.memory.landmarks.iter().take(slam.memory.header.len);
        assert!(landmarks.into_iter().all(|landmark| landmark.label != 0 && landmark.label != other), "{other}");
    }
}

#[test]
fn a_vehicle_displaced_soon_after_the_start_is_reported_as_lost() {
    let carried = |known_scans: usize| {
        let mut draws = Noise::seeded(1);
        type State = JointState<PlanarPose<f64>, Vector2<f64>, 40, { joint_numbers(3, 2, 40) }, 16>;
        let mut state = Box::new(State::new());
        let mut slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
        slam.reset(PlanarPose::new(0.0, 0.0, 0.0)).unwrap();
        let known = [[4.0, 0.3], [6.0, -1.0], [5.0, 2.0], [7.0, -2.5]];
        let other = [[9.0, 1.3], [3.0, -0.4], [11.0, -2.0], [2.0, 2.9]];
        let mut scan = |indices: [[f64; 2]; 4]| {
            slam.predict(&UnicycleControl { speed_mps: 0.0, rate_radps: 0.0 }, 0.1).unwrap();
            let noisy = indices
                .map(|[range, bearing]| [range + 0.1 * draws.normal::<f64>(), bearing + 0.01 * draws.normal::<f64>()]);
            slam.scan(&lidar(), &noisy.map(Vector2::from)).unwrap().health
        };
        let before = (0..known_scans).map(|_| scan(known)).all(|health| !health.contains(Health::LOST));
        before && (0..20).any(|_| scan(other).contains(Health::LOST))
    };
    assert!([70, 80, 100, 400].into_iter().all(carried));
}
