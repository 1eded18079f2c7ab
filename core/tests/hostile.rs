//! Numbers that no instrument says, where filters and locators once took them: found by the fuzzer.

use nalgebra::Vector2;
use scphd::errors::ResetError;
use scphd::locate::{Locator, LocatorConfig, LocatorState};
use scphd::models::{
    ControlNoise, PlanarPose, Pose, PositionFix, RangeBearing, RangeBearingWindow, Sensing, Step, Unicycle,
    UniformClutter,
};
use scphd::numerics::Symmetric;
use scphd::{Births, Component, Detector, JointConfig, JointSlam, PoseEstimate, joint_memory};

joint_memory! { type Memory: Unicycle<f32> { measurement: Vector2<f32>, features: 4, measurements: 4 } }

type Lidar = Detector<Sensing<RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>>>;

fn lidar() -> Lidar {
    let window = RangeBearingWindow::full_circle(15.0, 0.9).unwrap();
    let sensing = Sensing::range_bearing([0.1, 0.02], window, 1.0).unwrap();
    Detector::new(sensing, Births::of_static(0.01)).unwrap()
}

/// A fix without a gate that says 10¹² m: taken in, it would leave a state that no snapshot takes and no step puts right.
#[test]
fn a_fix_that_leads_beyond_every_range_is_left_out_by_a_joint_map() {
    let mut state = Box::new(Memory::new());
    let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.02)).unwrap();
    let mut slam = JointSlam::new(motion, JointConfig::default(), &mut *state).unwrap();
    slam.reset_within(PlanarPose::ZERO, &Symmetric::from_diagonal([0.5, 0.5, 0.1])).unwrap();
    slam.scan(&lidar(), &[Vector2::new(4.0, 0.5)]).unwrap();
    let (before, fix) = (slam.digest(), PositionFix::new(0.5).unwrap());
    let report = slam.observe(&fix, &Vector2::new(1e12, 0.0)).unwrap();
    assert!(!report.accepted && report.distance > 1e20, "{report:?}");
    assert_eq!((slam.digest(), slam.audit()), (before, Ok(())));
    assert!(slam.observe(&fix, &Vector2::new(0.3, 0.0)).unwrap().accepted);
    assert_ne!(slam.digest(), before);
}

/// A covariance whose coordinates have more in common than their variances allow is none: informed particles that took it would leave every
/// range in the next scan.
#[test]
fn a_covariance_that_cannot_be_is_refused() {
    let mut state = Box::new(Memory::new());
    let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.02)).unwrap();
    let mut slam = JointSlam::new(motion, JointConfig::default(), &mut *state).unwrap();
    slam.reset(PlanarPose::ZERO).unwrap();
    let before = slam.digest();
    let with = |common: f32| {
        Symmetric::from_fn(|row, column| match (row, column) {
            (2, 1) | (1, 2) => common,
            _ if row == column => 1e-6,
            _ => 0.0,
        })
    };
    assert_eq!(slam.scatter(&with(3.9e7)), Err(ResetError::Covariance));
    assert_eq!(slam.relocate(PlanarPose::ZERO, &with(-2e-6)), Err(ResetError::Covariance));
    assert_eq!(slam.digest(), before);
    slam.scatter(&with(1e-6)).unwrap();
}

/// All landmarks of the map are seen where they are: found, but not by a vehicle whose own pose is no number.
#[test]
fn a_pose_that_is_no_number_is_found_nowhere() {
    let places = [[1.0, 2.0], [4.0, -3.0], [-5.0, 1.0], [2.0, 7.0], [-3.0, -6.0], [6.5, 4.0], [-7.0, 6.0]];
    let landmark = |(label, [x, y]): (usize, [f32; 2])| Component {
        label: label as u32,
        ln_weight: -0.05,
        mean: Vector2::new(x, y),
        covariance: Symmetric::from_diagonal([1e-3; 2]),
    };
    let map: Vec<Component<Vector2<f32>>> = places.into_iter().enumerate().map(landmark).collect();
    let mut state = Box::new(LocatorState::<f32, 8, 4>::new());
    let mut locator = Locator::new(LocatorConfig::default(), &mut state).unwrap();
    locator.load_map(&map).unwrap();
    let mut look = |x_m: f32, variance: f32| {
        let covariance = Symmetric::from_diagonal([variance, 1e-4, 1e-5]);
        let pose = PoseEstimate { mean: PlanarPose::new(x_m, 0.0, 0.0), covariance };
        locator.update(&lidar(), &pose, map.iter().copied())
    };
    let reports = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5].map(|x_m| look(x_m, 1e-4));
    let found = reports[5].found.expect("it is found");
    assert!((found.pose.mean.x_m - 0.5).abs() < 0.01 && found.matched == 7, "{found:?}");
    for (x_m, variance) in [(f32::NAN, 1e-4), (f32::INFINITY, 1e-4), (0.6, f32::NAN)] {
        let report = look(x_m, variance);
        assert_eq!(report.found, None, "{x_m} {variance}: {report:?}");
    }
    assert!(look(0.6, 1e-4).found.is_some());
}
