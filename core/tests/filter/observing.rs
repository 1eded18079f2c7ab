//! Fixes and several detectors, against closed forms.

use crate::alone::Lidar;
use crate::linear::{Drift, linear_sensing};
use crate::*;
use nalgebra::{Matrix3, SMatrix, Vector1, Vector2, Vector3};

type Memory<const N: usize> = State<PlanarPose<f64>, N, N, MapMemory<Static<Vector2<f64>>, N, 256, 32, 256>>;

/// Odometry, positions and headings by turns, from `position` and `heading`, and the same by a Kalman filter.
struct Kalman {
    mean: Vector3<f64>,
    covariance: Matrix3<f64>,
    ln_evidence: f64,
}

impl Kalman {
    fn update<const Z: usize>(
        &mut self,
        h: &SMatrix<f64, Z, 3>,
        r: &SMatrix<f64, Z, Z>,
        innovation: &SMatrix<f64, Z, 1>,
    ) {
        let s = h * self.covariance * h.transpose() + r;
        let inverse = s.try_inverse().unwrap();
        let gain = self.covariance * h.transpose() * inverse;
        self.mean += gain * innovation;
        self.covariance -= gain * s * gain.transpose();
        let distance = innovation.dot(&(inverse * innovation));
        let turns = core::f64::consts::TAU.powi(Z as i32) * determinant(&s);
        self.ln_evidence = -0.5 * (distance + turns.ln());
    }
}

fn determinant<const Z: usize>(s: &SMatrix<f64, Z, Z>) -> f64 {
    if Z == 1 { s[(0, 0)] } else { s[(0, 0)] * s[(1, 1)] - s[(0, 1)] * s[(1, 0)] }
}

const START: PlanarPose<f64> = PlanarPose::new(1.0, -2.0, 0.3);

#[test]
fn one_undrawn_particle_takes_fixes_as_a_kalman_filter_does() {
    let proposal = Proposal::Informed(Informed { sampled_fraction: 0.0, ..Informed::default() });
    let mut state = Box::new(Memory::<1>::new());
    let config = Config { particles: 1, proposal, ..Config::default() };
    let mut slam = ScPhd::new(Drift { sigmas: [0.5, 0.2] }, config, &mut *state).unwrap();
    let gps = PositionFix::new(0.4).unwrap();
    assert_eq!(slam.observe(&gps, &Vector2::zeros()), Err(ObserveError::NotStarted));
    slam.reset(START, 1).unwrap();
    let mut joint_state =
        Box::new(JointState::<PlanarPose<f64>, Vector2<f64>, 4, { joint_numbers(3, 2, 4) }, 8>::new());
    let mut joint = JointSlam::new(Drift { sigmas: [0.5, 0.2] }, JointConfig::default(), &mut *joint_state).unwrap();
    joint.reset(START).unwrap();
    let mut exact = Kalman { mean: START.coordinates(), covariance: Matrix3::zeros(), ln_evidence: 0.0 };
    let mut draws = Noise::seeded(3);
    for step in 0..60 {
        let moved = Vector2::new(0.7, if step % 8 < 4 { 0.3 } else { -0.5 });
        slam.predict(&moved, 0.5).unwrap();
        joint.predict(&moved, 0.5).unwrap();
        exact.mean += Vector3::new(moved.x, moved.y, 0.0) * 0.5;
        exact.covariance += Matrix3::from_diagonal(&Vector3::new(0.125, 0.02, 0.0));
        if step % 3 == 0 {
            let seen = Vector2::new(exact.mean.x + draws.normal::<f64>(), exact.mean.y + draws.normal::<f64>());
            let h = SMatrix::<f64, 2, 3>::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
            let innovation = seen - Vector2::new(exact.mean.x, exact.mean.y);
            exact.update(&h, &(SMatrix::<f64, 2, 2>::identity() * 0.16), &innovation);
            for report in [slam.observe(&gps, &seen).unwrap(), joint.observe(&gps, &seen).unwrap()] {
                assert!(report.accepted && (report.ln_evidence - exact.ln_evidence).abs() < 1e-9, "{report:?}");
            }
        }
        for estimate in [slam.estimate_pose().unwrap(), joint.estimate_pose().unwrap()] {
            let off = estimate.mean.coordinates() - exact.mean;
            assert!(off.norm() < 1e-9, "{step}: {off}");
            assert!((estimate.covariance.to_matrix() - exact.covariance).norm() < 1e-9, "{step}");
        }
    }
    // A fix that no vehicle is at is an outlier to one with a gate, and leaves all as it was.
    let digests = (slam.digest(), joint.digest());
    let far = Vector2::new(1e3, 0.0);
    let gated = gps.gated(25.0).unwrap();
    let reports = [slam.observe(&gated, &far).unwrap(), joint.observe(&gated, &far).unwrap()];
    assert!(reports.iter().all(|report| !report.accepted && report.distance > 1e5), "{reports:?}");
    assert_eq!(slam.observe(&gps, &Vector2::new(f64::NAN, 0.0)), Err(ObserveError::NonFinite));
    assert_eq!((slam.digest(), joint.digest()), digests);
}

/// Σ ζ N(z; x, R) x over many blind particles is the posterior mean.
#[test]
fn many_blind_particles_stand_for_the_posterior() {
    let mut state = Box::new(Memory::<2000>::new());
    let config = Config { particles: 2000, ..Config::default() };
    let mut slam = ScPhd::new(Drift { sigmas: [0.5, 0.2] }, config, &mut *state).unwrap();
    slam.reset(START, 5).unwrap();
    slam.predict(&Vector2::new(2.0, 0.0), 1.0).unwrap();
    let mut exact = Kalman {
        mean: Vector3::new(3.0, -2.0, 0.3),
        covariance: Matrix3::from_diagonal(&Vector3::new(0.25, 0.04, 0.0)),
        ln_evidence: 0.0,
    };
    let seen = Vector2::new(3.6, -2.3);
    let h = SMatrix::<f64, 2, 3>::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
    exact.update(&h, &(SMatrix::<f64, 2, 2>::identity() * 0.16), &Vector2::new(0.6, -0.3));
    let report = slam.observe(&PositionFix::new(0.4).unwrap(), &seen).unwrap();
    let estimate = slam.estimate_pose().unwrap();
    // Standard errors of 2000 samples, some three quarters of which count.
    assert!((estimate.mean.x_m - exact.mean.x).abs() < 0.04, "{estimate:?} {}", exact.mean);
    assert!((estimate.mean.y_m - exact.mean.y).abs() < 0.02, "{estimate:?} {}", exact.mean);
    assert!((report.ln_evidence - exact.ln_evidence).abs() < 0.1, "{report:?} {}", exact.ln_evidence);
    assert!(report.n_eff < 2000.0 && report.n_eff > 500.0);
    assert_eq!(slam.audit(), Ok(()));
    // The next scan goes on from there.
    let mut scratch = DetectorMemory::<Vector2<f64>, 8>::new();
    let sensing = linear_sensing([0.1, 0.1], 0.9, 0.01);
    let mut detector = Detector::new(sensing, Births::of_static(0.01)).unwrap().over(&mut scratch).unwrap();
    slam.scan(&mut detector, &[Vector2::new(4.0, 1.0)]).unwrap();
    assert_eq!(slam.audit(), Ok(()));
}

/// What is fixed is what the joint map's features have in common with the pose: they move along.
#[test]
fn a_joint_map_learns_of_a_fix() {
    let mut state = Box::new(JointState::<PlanarPose<f64>, Vector2<f64>, 4, { joint_numbers(3, 2, 4) }, 8>::new());
    let mut slam = JointSlam::new(Drift { sigmas: [1.0, 1.0] }, JointConfig::default(), &mut *state).unwrap();
    let sensing = linear_sensing([1e-4, 1e-4], 0.9, 1e-9);
    let detector = Detector::new(sensing, Births::of_static(1e-3)).unwrap();
    slam.reset(PlanarPose::ZERO).unwrap();
    slam.predict(&Vector2::zeros(), 1.0).unwrap();
    for _ in 0..3 {
        slam.scan(&detector, &[Vector2::new(5.0, 5.0)]).unwrap();
    }
    slam.observe(&PositionFix::new(0.01).unwrap(), &Vector2::new(1.0, -0.5)).unwrap();
    let (pose, feature) = (slam.estimate_pose().unwrap().mean, slam.features().next().unwrap());
    assert!((pose.x_m - 1.0).abs() < 1e-3 && (pose.y_m + 0.5).abs() < 1e-3);
    assert!((feature.mean - Vector2::new(6.0, 4.5)).norm() < 1e-3, "{feature:?}");
    slam.observe(&HeadingFix::new(0.1).unwrap(), &Vector1::new(0.0)).unwrap();
}

type Radar = Detector<Lidar<f64>>;

/// A radar that looks to where `bearing` is, and as far around as `half_width`.
fn radar(bearing: f64, half_width: f64) -> Radar {
    let limits = RangeBearingLimits {
        bearing_center_rad: bearing,
        bearing_half_width_rad: half_width,
        ..RangeBearingLimits::full_circle(20.0, 0.9)
    };
    let window = RangeBearingWindow::new(limits).unwrap();
    let sensing = Sensing {
        sensor: RangeBearing::new(0.1, 0.01).unwrap(),
        field_of_view: window,
        // The same density of clutter.
        clutter: UniformClutter::of_scan(1.0 * half_width, window.measure()).unwrap(),
    };
    Detector::new(sensing, Births::of_static(0.002)).unwrap()
}

/// Two halves of a scan, each by a sensor that sees a half, are the whole scan by a sensor that sees all.
#[test]
fn two_halves_of_a_view_are_the_whole() {
    let pi = core::f64::consts::PI;
    let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.05, 0.002)).unwrap();
    // Maps are compared with all births, which the second half would not leave to wait for the next scan.
    let config = Config { particles: 8, resample_threshold: 0.0, births_wait: false, ..Config::default() };
    let (mut one, mut two) = (Box::new(Memory::<8>::new()), Box::new(Memory::<8>::new()));
    let mut whole = ScPhd::new(motion, config, &mut *one).unwrap();
    let mut halves = ScPhd::new(motion, config, &mut *two).unwrap();
    let mut rooms = [(); 3].map(|()| DetectorMemory::<Vector2<f64>, 32>::new());
    let [a, b, c] = &mut rooms;
    let mut all = radar(0.0, pi).over(a).unwrap();
    let mut left = radar(0.5 * pi, 0.5 * pi).over(b).unwrap();
    let mut right = radar(-0.5 * pi, 0.5 * pi).over(c).unwrap();
    whole.reset(PlanarPose::ZERO, 3).unwrap();
    halves.reset(PlanarPose::ZERO, 3).unwrap();
    // None is near the border of the halves, straight ahead or behind.
    let landmarks = [[5.0, 6.0], [9.0, 8.0], [-2.0, 7.0], [4.0, -6.0], [8.0, -9.0], [0.0, -5.0]];
    let mut draws = Noise::seeded(8);
    let (ahead, dt) = (UnicycleControl { speed_mps: 1.0, rate_radps: 0.0 }, 0.1);
    let mut x = 0.0;
    for _ in 0..40 {
        whole.predict(&ahead, dt).unwrap();
        halves.predict(&ahead, dt).unwrap();
        x += 0.1;
        let mut scan: Vec<Vector2<f64>> = Vec::new();
        for [east, north] in landmarks {
            let (dx, dy): (f64, f64) = (east - x, north);
            if draws.uniform::<f64>() < 0.9 {
                let noise = Vector2::new(0.1 * draws.normal::<f64>(), 0.01 * draws.normal::<f64>());
                scan.push(Vector2::new(dx.hypot(dy), dy.atan2(dx)) + noise);
            }
        }
        // False ones beside, far from the border too.
        for side in [-1.0, 1.0] {
            if draws.uniform::<f64>() < 0.7 {
                scan.push(Vector2::new(
                    2.0 + 15.0 * draws.uniform::<f64>(),
                    side * (0.6 + 1.9 * draws.uniform::<f64>()),
                ));
            }
        }
        let (to_left, to_right): (Vec<_>, Vec<_>) = scan.iter().partition(|z| z.y > 0.0);
        whole.scan(&mut all, &scan).unwrap();
        halves.scan(&mut left, &to_left).unwrap();
        halves.scan(&mut right, &to_right).unwrap();
        let (ours, theirs) = (halves.estimate_pose().unwrap(), whole.estimate_pose().unwrap());
        assert!(ours.mean.difference(&theirs.mean).norm() < 1e-9, "{ours:?} {theirs:?}");
        assert!((ours.covariance.to_matrix() - theirs.covariance.to_matrix()).norm() < 1e-9);
        for particle in 0..8 {
            let sorted = |slam: &ScPhd<'_, Unicycle<f64>>| {
                let mut map: Vec<_> = slam.map(particle).map(|c| (c.mean.x, c.mean.y, c.ln_weight)).collect();
                map.sort_by(|a, b| a.0.total_cmp(&b.0));
                map
            };
            let (ours, theirs) = (sorted(&halves), sorted(&whole));
            assert_eq!(ours.len(), theirs.len());
            for (a, b) in ours.iter().zip(&theirs) {
                let off = (a.0 - b.0).abs() + (a.1 - b.1).abs() + (a.2 - b.2).abs();
                assert!(off < 1e-9, "{a:?} {b:?}");
            }
        }
    }
    let mut features = [Component::ZERO; 16];
    let found = halves.estimate_map(&left, &mut features).features;
    assert_eq!(found, whole.estimate_map(&all, &mut features).features);
    assert!(found + 1 >= landmarks.len(), "{found}");
}
