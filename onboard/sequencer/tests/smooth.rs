//! The odometry pose never jumps, and all corrections are in its transformation to the map.

use scphd::Real;
use scphd::errors::{PredictError, ResetError};
use scphd::models::{
    Auv, AuvControl, AuvPose, ControlNoise, Motion, PlanarPose, Pose, Reading, Step, Unicycle, UnicycleControl,
    rotation,
};
use scphd::numerics::nalgebra::Vector3;
use scphd::numerics::{Noise, Symmetric, wrap};
use scphd_sequencer::{MapFromOdom, SmoothOdometry};

fn drawn<T: Real>(draws: &mut Noise, sigma: f64) -> T {
    T::from_f64(sigma * draws.normal::<f64>())
}

/// A hundred runs with a correction after every third step, some of them large. Returns the greatest correction of the position.
fn runs_in_the_plane<T: Real>() -> T {
    let motion = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
    let (dt, mut greatest) = (T::from_f64(0.05), T::ZERO);
    for seed in 0..100 {
        let mut draws = Noise::seeded(seed);
        let start = PlanarPose::new(drawn(&mut draws, 50.0), drawn(&mut draws, 50.0), drawn(&mut draws, 1.0));
        let mut odometry = SmoothOdometry::new(start);
        // Rounding error of the largest coordinates here.
        let rounding = T::from_f64(2000.0) * T::EPSILON;
        for step in 0..300 {
            let control = UnicycleControl { speed_mps: drawn(&mut draws, 2.0), rate_radps: drawn(&mut draws, 1.0) };
            let before = odometry.pose();
            odometry.predict(&motion, &control, dt).unwrap();
            let moved = odometry.pose().difference(&before);
            assert!(odometry.pose().distance_m(&before) <= control.speed_mps.abs() * dt + rounding);
            assert!((moved.z.abs() - control.rate_radps.abs() * dt).abs() <= rounding);
            if step % 3 == 0 {
                let sigma = if step % 30 == 0 { 20.0 } else { 0.1 };
                let by =
                    Vector3::new(drawn(&mut draws, sigma), drawn(&mut draws, sigma), drawn(&mut draws, 0.3 * sigma));
                let (pose, of_map) = (odometry.pose(), odometry.in_map());
                let corrected = PlanarPose { heading_rad: wrap(of_map.heading_rad), ..of_map }.displaced(&by);
                let correction = odometry.correct(&corrected).unwrap();
                assert_eq!(odometry.pose(), pose);
                assert!((correction.distance_m - (by.x * by.x + by.y * by.y).sqrt()).abs() <= rounding);
                assert!((correction.angle_rad - wrap(by.z).abs()).abs() <= rounding);
                let left = odometry.in_map().difference(&corrected);
                assert!(left.iter().all(|x| x.abs() <= rounding), "{left}");
            }
        }
        assert_eq!(odometry.corrections(), 100);
        greatest = greatest.at_least(odometry.greatest().distance_m);
    }
    greatest
}

#[test]
fn the_pose_moves_by_at_most_the_odometry_in_a_hundred_runs() {
    let (single, double) = (runs_in_the_plane::<f32>(), runs_in_the_plane::<f64>());
    assert!(single > 40.0 && double > 40.0, "there were corrections to hide: {single} {double}");
}

fn auv_control(draws: &mut Noise) -> AuvControl<f64> {
    AuvControl {
        velocity_mps: Vector3::from_fn(|_, _| 0.4 * draws.normal::<f64>()),
        velocity_covariance: Symmetric::ZERO,
        roll_rad: 0.2 * draws.normal::<f64>(),
        pitch_rad: 0.2 * draws.normal::<f64>(),
        yaw_rate_radps: Some(Reading { value: 0.3 * draws.normal::<f64>(), sigma: 0.01 }),
        z_m: None,
    }
}

/// Under water: the transformation rotates about the vertical only, because both poses have the roll and pitch of the instruments.
#[test]
fn an_underwater_vehicle_is_transformed_with_its_attitude() {
    let motion = Auv::new(0.5, 0.0).unwrap();
    for seed in 0..100 {
        let mut draws = Noise::seeded(seed);
        let mut odometry = SmoothOdometry::new(AuvPose::new(3.0, -20.0, -5.0, 1.0));
        for _ in 0..100 {
            let (before, control) = (odometry.pose(), auv_control(&mut draws));
            odometry.predict(&motion, &control, 0.1).unwrap();
            assert!(odometry.pose().distance_m(&before) <= 0.1 * control.velocity_mps.norm() + 1e-12);
            let pose = odometry.pose();
            let slam = AuvPose {
                x_m: pose.x_m + draws.normal::<f64>(),
                y_m: pose.y_m + draws.normal::<f64>(),
                z_m: pose.z_m + draws.normal::<f64>(),
                yaw_rad: wrap(pose.yaw_rad + draws.normal::<f64>()),
                ..pose
            };
            odometry.correct(&slam).unwrap();
            let (frame, in_map) = (odometry.map_from_odom(), odometry.in_map());
            assert_eq!((odometry.pose(), in_map.yaw_rate_radps), (pose, pose.yaw_rate_radps));
            assert!(in_map.difference(&slam).norm() < 1e-12);
            // The same with full rotations: map_T_odom = map_T_body ∘ odom_T_body⁻¹.
            let attitude = |pose: &AuvPose<f64>| rotation(pose.roll_rad, pose.pitch_rad, pose.yaw_rad);
            let turn = attitude(&slam) * attitude(&pose).transpose();
            assert!((turn - rotation(0.0, 0.0, frame.turn_rad())).norm() < 1e-12);
            assert!((slam.position() - turn * pose.position() - frame.shift_m()).norm() < 1e-11);
        }
    }
}

#[test]
fn frames_compose_as_rigid_motions() {
    let quarter = 0.5 * f64::PI;
    let frame = MapFromOdom::between(&PlanarPose::new(5.0, 1.0, quarter), &PlanarPose::new(2.0, 0.0, 0.0));
    assert!((frame.turn_rad() - quarter).abs() < 1e-15 && (frame.shift_m().x - 5.0).abs() < 1e-15);
    assert!((frame.shift_m().y + 1.0).abs() < 1e-15);
    let ahead = frame.apply(&PlanarPose::new(4.0, 0.0, 3.0));
    assert!(ahead.difference(&PlanarPose::new(5.0, 3.0, wrap(3.0 + quarter))).norm() < 1e-15, "{ahead:?}");
    let nothing = MapFromOdom::IDENTITY;
    assert_eq!(nothing.apply(&PlanarPose::new(4.0, -1.0, 3.0)), PlanarPose::new(4.0, -1.0, 3.0));
}

/// Between corrections the motion in the map is that of the odometry.
#[test]
fn between_corrections_the_map_pose_follows_the_odometry() {
    let motion = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
    let mut odometry = SmoothOdometry::new(PlanarPose::new(0.0, 0.0, 0.0));
    let mut in_map = PlanarPose::new(-3.0, 4.0, 2.5);
    odometry.correct(&in_map).unwrap();
    let control = UnicycleControl { speed_mps: 1.0, rate_radps: 0.4 };
    for _ in 0..200 {
        odometry.predict(&motion, &control, 0.1).unwrap();
        in_map = motion.propagate(&in_map, &control, 0.1);
    }
    assert!(odometry.in_map().difference(&in_map).norm() < 1e-12);
}

#[test]
fn non_finite_input_changes_nothing() {
    let motion = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
    let mut odometry = SmoothOdometry::new(PlanarPose::new(1.0_f32, 0.0, 0.0));
    let before = odometry;
    let control = UnicycleControl { speed_mps: 1.0, rate_radps: 0.0 };
    assert_eq!(odometry.predict(&motion, &control, -0.1), Err(PredictError::TimeStep));
    assert_eq!(odometry.predict(&motion, &control, f32::NAN), Err(PredictError::TimeStep));
    let wild = UnicycleControl { speed_mps: f32::INFINITY, ..control };
    assert_eq!(odometry.predict(&motion, &wild, 0.1), Err(PredictError::Control));
    let fast = UnicycleControl { speed_mps: f32::MAX, ..control };
    assert_eq!(odometry.predict(&motion, &fast, 1e9), Err(PredictError::Control));
    assert_eq!(odometry.correct(&PlanarPose::new(f32::NAN, 0.0, 0.0)), Err(ResetError::NonFinitePose));
    assert_eq!(odometry, before);
}
