//! A filter built from a description gives the same bits as one that is constructed directly.

use nalgebra::{Vector1, Vector2};
use scphd::models::{
    Calibrated, CalibratedPose, ControlNoise, MeasurementModel, Motion, OdometryCorrection, OdometryPrior, PlanarPose,
    Pose, RangeBearing, RangeBearingWindow, RangeNoise, SelfCalibrating, Sensing, Step, Unicycle, UnicycleControl,
    UniformClutter, WithNoise,
};
use scphd::settings::{HypothesesConfig, MovingConfig};
use scphd::snapshot::{from_slice, into_slice};
use scphd::storage::{JointFilter, JointHypotheses, JointMovers, joint_numbers};
use scphd::{Births, Config, Detector, DetectorMemory, JointConfig, JointSlam, ScPhd, joint_memory, memory};
use scphd_vehicle::sets::{
    Joint24Hypotheses, Joint40, Joint40Archive, Joint60Learning, Joint60Movers, MixtureInformed4,
};
use scphd_vehicle::{
    Backing, Control, Description, Filter, FixSpec, Measurements, Refused, Sensor, SensorModel, Services, Setting,
    Slam, StartError, mixture_backing,
};

mixture_backing! {
    /// Also for bearing-only sensors.
    struct WithCamera: f32, measurements: 16 with bearings {
        particles: 4, samples: 1, features { pages: 128, pages_per_map: 32, in_view: 256 },
    }
}

const SCANS: usize = 60;

/// Landmarks around a circle, seen from a robot on it, with some false measurements.
fn scan(step: usize) -> Vec<Vector2<f32>> {
    let heading = 0.02 * step as f32;
    let (x, y) = (10.0 * heading.sin(), 10.0 - 10.0 * heading.cos());
    let landmarks = (0..12).map(|k| {
        let angle = core::f32::consts::FRAC_PI_6 * k as f32;
        (14.0 * angle.sin(), 10.0 - 14.0 * angle.cos())
    });
    let mut seen: Vec<Vector2<f32>> = landmarks
        .map(|(u, v)| Vector2::new((u - x).hypot(v - y), scphd::numerics::wrap((v - y).atan2(u - x) - heading)))
        .filter(|z| z.x < 12.0)
        .collect();
    if step.is_multiple_of(5) {
        seen.push(Vector2::new(3.0 + 0.1 * step as f32, -1.0));
    }
    seen
}

fn described() -> Description<f32> {
    let mut robot = Description::robot();
    let mut lidar = Sensor::range_bearing(12.0, 0.9, [0.2, 0.02]);
    lidar.births = Births { of_static: 1e-3, of_moving: 0.0 };
    lidar.seat_m = [0.3, 0.0];
    robot.sensors[1] = Some(lidar);
    robot
}

fn sensing<S>(sensor: S) -> Sensing<S, RangeBearingWindow<f32>, UniformClutter<f32>> {
    let field_of_view = RangeBearingWindow::full_circle(12.0, 0.9).unwrap();
    let clutter = UniformClutter::of_scan(1.0, field_of_view.measure()).unwrap();
    Sensing { sensor, field_of_view, clutter }
}

fn lidar() -> RangeBearing<f32> {
    RangeBearing::new(0.2, 0.02).unwrap()
}

fn seat() -> scphd::models::Mounting<f32> {
    scphd::models::Mounting::in_plane(0.3, 0.0, 0.0).unwrap()
}

fn births(of_moving: f32) -> Births<f32> {
    Births { of_static: 1e-3, of_moving }
}

fn unicycle() -> Unicycle<f32> {
    Unicycle::new(Step::Arc, ControlNoise::wheeled()).unwrap()
}

/// The digests after every scan.
fn digests(slam: &mut impl Services<f32>, description: &Description<f32>) -> Vec<u64> {
    slam.reset(&description.start).unwrap();
    (0..SCANS)
        .map(|step| {
            slam.predict(Control { speed_mps: 2.0, turn: 0.2, ..Control::STILL }, 0.1).unwrap();
            slam.scan(1, Measurements::RangeBearing(&scan(step))).unwrap();
            slam.digest()
        })
        .collect()
}

const BY_HAND: UnicycleControl<f32> = UnicycleControl { speed_mps: 2.0, rate_radps: 0.2 };

/// The digests of a joint map that was constructed directly, after every scan.
fn digests_by_hand<P, F, X>(slam: &mut F, detector: &Detector<X>) -> Vec<u64>
where
    P: Pose<Scalar = f32>,
    F: JointFilter<Motion: Motion<Pose = P, Control = UnicycleControl<f32>>>,
    X: MeasurementModel<Pose = P, Measurement = Vector2<f32>>,
{
    let step = |step| {
        slam.predict(&BY_HAND, 0.1).unwrap();
        slam.scan(detector, &scan(step)).unwrap();
        slam.digest()
    };
    (0..SCANS).map(step).collect()
}

#[test]
fn a_joint_map() {
    joint_memory! { type Memory: Unicycle<f32> { measurement: Vector2<f32>, features: 40, measurements: 32 } }
    let mut state = Box::new(Memory::new());
    let mut slam = JointSlam::new(unicycle(), JointConfig::default(), &mut state).unwrap();
    slam.reset(PlanarPose::new(0.0, 0.0, 0.0)).unwrap();
    let detector = Detector::new(sensing(lidar()), births(0.0)).unwrap().mounted(seat()).unwrap();
    let expected = digests_by_hand(&mut slam, &detector);
    let mut memory = Box::new(Joint40::new());
    assert_eq!(digests(&mut memory.start(&described()).unwrap(), &described()), expected);
}

/// The tests above and below compare descriptions with a ratio of 0 with the sensor alone.
#[test]
fn noise_that_grows_with_the_range() {
    joint_memory! { type Memory: Unicycle<f32> { measurement: Vector2<f32>, features: 40, measurements: 32 } }
    let mut state = Box::new(Memory::new());
    let mut slam = JointSlam::new(unicycle(), JointConfig::default(), &mut state).unwrap();
    slam.reset(PlanarPose::new(0.0, 0.0, 0.0)).unwrap();
    let sensor = WithNoise { sensor: lidar(), noise: RangeNoise::new(0.05).unwrap() };
    let detector = Detector::new(sensing(sensor), births(0.0)).unwrap().mounted(seat()).unwrap();
    let expected = digests_by_hand(&mut slam, &detector);
    let mut robot = described();
    robot.sensors[1].as_mut().unwrap().range_sigma_ratio = 0.05;
    let mut memory = Box::new(Joint40::new());
    let grown = digests(&mut memory.start(&robot).unwrap(), &robot);
    assert_eq!(grown, expected);
    let mut memory = Box::new(Joint40::new());
    assert_ne!(grown, digests(&mut memory.start(&described()).unwrap(), &described()));
}

#[test]
fn a_joint_map_with_movers() {
    joint_memory! { type Memory: Unicycle<f32> { measurement: Vector2<f32>, features: 60, measurements: 32 } }
    let (mut state, mut movers) = (Box::new(Memory::new()), JointMovers::<PlanarPose<f32>, 16>::new());
    let slam = JointSlam::new(unicycle(), JointConfig::strict(), &mut *state).unwrap();
    let mut slam = slam.with_movers(&mut movers, MovingConfig::walkers()).unwrap();
    slam.reset(PlanarPose::new(0.0, 0.0, 0.0)).unwrap();
    let detector = Detector::new(sensing(lidar()), births(1e-4)).unwrap().mounted(seat()).unwrap();
    let expected = digests_by_hand(&mut slam, &detector);
    let mut robot = described();
    let Filter::Joint(joint) = &mut robot.filter else { panic!() };
    (joint.config, joint.movers) = (JointConfig::strict(), Some(MovingConfig::walkers()));
    robot.sensors[1].as_mut().unwrap().births = births(1e-4);
    let mut memory = Box::new(Joint60Movers::new());
    assert_eq!(digests(&mut memory.start(&robot).unwrap(), &robot), expected);
}

#[test]
fn a_joint_map_that_learns_its_odometry() {
    let sigma = OdometryCorrection { speed_scale: 0.05, turn_scale: 0.05, turn_offset: 0.02 };
    let prior = OdometryPrior { sigma, lasts_s: 3600.0 };
    let motion = SelfCalibrating::new(unicycle(), prior).unwrap();
    joint_memory! {
        type Memory: SelfCalibrating<Unicycle<f32>, f32> { measurement: Vector2<f32>, features: 60, measurements: 32 }
    }
    let mut state = Box::new(Memory::new());
    let mut slam = JointSlam::new(motion, JointConfig::default(), &mut state).unwrap();
    slam.reset_within(CalibratedPose::at(PlanarPose::new(0.0, 0.0, 0.0)), &motion.prior()).unwrap();
    let detector = Detector::new(sensing(Calibrated(lidar())), births(0.0)).unwrap().mounted(seat()).unwrap();
    let expected = digests_by_hand(&mut slam, &detector);
    let mut robot = described();
    let Filter::Joint(joint) = &mut robot.filter else { panic!() };
    joint.odometry = Some(prior);
    let mut memory = Box::new(Joint60Learning::new());
    let mut slam = memory.start(&robot).unwrap();
    assert_eq!(digests(&mut slam, &robot), expected);
    assert!(slam.odometry().is_some());
}

#[test]
fn a_joint_map_with_several_hypotheses() {
    joint_memory! { type Memory: Unicycle<f32> { measurement: Vector2<f32>, features: 24, measurements: 16 } }
    let (mut state, mut movers) = (Box::new(Memory::new()), JointMovers::<PlanarPose<f32>, 8>::new());
    let mut others = Box::new(JointHypotheses::<PlanarPose<f32>, 7, 24, { joint_numbers(3, 2, 24) }, 8>::new());
    // Between two scans the vehicle may turn by the angle between two landmarks.
    let noise = ControlNoise::white(5.0, 5.0);
    let motion = Unicycle::new(Step::Arc, noise).unwrap();
    let slam = JointSlam::new(motion, JointConfig::default(), &mut *state).unwrap();
    let slam = slam.with_movers(&mut movers, MovingConfig::walkers()).unwrap();
    let config = HypothesesConfig { least_ratio: 1e-4, ..HypothesesConfig::default() };
    let mut slam = slam.with_hypotheses(&mut others, config).unwrap();
    slam.reset(PlanarPose::new(0.0, 0.0, 0.0)).unwrap();
    let detector = Detector::new(sensing(lidar()), births(1e-4)).unwrap().mounted(seat()).unwrap();
    let (mut expected, mut most) = (Vec::new(), 1);
    for step in 0..SCANS {
        slam.predict(&BY_HAND, 0.1).unwrap();
        most = most.max(slam.scan(&detector, &scan(step)).unwrap().hypotheses);
        expected.push(slam.digest());
    }
    assert!(most > 1);
    let mut robot = described();
    robot.vehicle.noise = noise;
    let Filter::Joint(joint) = &mut robot.filter else { panic!() };
    (joint.movers, joint.hypotheses) = (Some(MovingConfig::walkers()), Some(config));
    robot.sensors[1].as_mut().unwrap().births = births(1e-4);
    let mut memory = Box::new(Joint24Hypotheses::new());
    assert_eq!(digests(&mut memory.start(&robot).unwrap(), &robot), expected);
}

#[test]
fn a_mixture() {
    memory! {
        type Memory: Unicycle<f32> {
            particles: 4, samples: 1, features { pages: 128, pages_per_map: 32, in_view: 256 },
        }
    }
    let (mut state, mut room) = (Box::new(Memory::new()), DetectorMemory::<Vector2<f32>, 64>::new());
    let mut filter = ScPhd::new(unicycle(), Config::informed(4), &mut state).unwrap();
    filter.reset(PlanarPose::new(0.0, 0.0, 0.0), 1).unwrap();
    let detector = Detector::new(sensing(lidar()), births(0.0)).unwrap().mounted(seat()).unwrap();
    let mut detector = detector.over(&mut room).unwrap();
    let expected: Vec<u64> = (0..SCANS)
        .map(|step| {
            filter.predict(&BY_HAND, 0.1).unwrap();
            filter.scan(&mut detector, &scan(step)).unwrap();
            filter.digest()
        })
        .collect();
    let robot = Description { filter: Filter::Mixture(Config::informed(4)), ..described() };
    let mut memory = Box::new(MixtureInformed4::new());
    assert_eq!(digests(&mut memory.start(&robot).unwrap(), &robot), expected);
}

#[test]
fn a_snapshot_goes_on_to_the_bit_with_movers_and_an_archive() {
    let mut robot = described();
    let Filter::Joint(joint) = &mut robot.filter else { panic!() };
    (joint.movers, joint.archive_reach_m) = (Some(MovingConfig::walkers()), Some(12.0));
    let (mut memory, mut other) = (Box::new(Joint40Archive::new()), Box::new(Joint40Archive::new()));
    let (mut slam, mut restored) = (memory.start(&robot).unwrap(), other.start(&robot).unwrap());
    digests(&mut slam, &robot);
    let mut bytes = vec![0; 65_536];
    let len = slam.save(7, &mut into_slice(&mut bytes)).unwrap();
    assert_eq!(restored.restore(7, &mut from_slice(&bytes[..len])), Ok(len));
    for slam in [&mut slam, &mut restored] {
        slam.predict(Control { speed_mps: 2.0, turn: 0.2, ..Control::STILL }, 0.1).unwrap();
        slam.scan(1, Measurements::RangeBearing(&scan(SCANS))).unwrap();
    }
    assert_eq!(slam.digest(), restored.digest());
    assert_eq!(slam.load_map(&[]), Ok(()));
}

#[test]
fn a_watch_moves_a_vehicle_that_is_elsewhere() {
    let mut robot = described();
    robot.position = Some(FixSpec { gate: 25.0, watch: Some(Default::default()), ..FixSpec::of_sigma(0.5) });
    let mut memory = Box::new(Joint40::new());
    let mut slam = memory.start(&robot).unwrap();
    slam.reset(&robot.start).unwrap();
    let relocated = (1..12).any(|second| {
        for _ in 0..10 {
            slam.predict(Control { speed_mps: 2.0, ..Control::STILL }, 0.1).unwrap();
        }
        slam.watch_position(2.0 * second as f32, 30.0).unwrap().relocated
    });
    assert!(relocated && (slam.pose().unwrap().mean.y_m - 30.0).abs() < 1.0);
    assert_eq!(slam.observe_position(0.0, 30.0), Err(Refused::Watched));
    assert_eq!(slam.observe_heading(0.0), Err(Refused::NotDescribed));
    assert_eq!(slam.watch_heading(0.0), Err(Refused::NotDescribed));
}

#[test]
fn unsuitable_memories_and_filters_are_refused() {
    let part = |name| Setting::of_name(name).unwrap();
    let no_room = |error, name| assert_eq!(error, StartError::NoRoom { part: part(name) });
    let mut robot = described();
    let Filter::Joint(joint) = &mut robot.filter else { panic!() };
    joint.movers = Some(MovingConfig::walkers());
    no_room(Joint40::new().start(&robot).unwrap_err(), "joint.movers");
    let lacks = |error, name| assert_eq!(error, StartError::NotDescribed { part: part(name) });
    lacks(Joint60Movers::new().start(&described()).unwrap_err(), "joint.movers");
    lacks(Joint40Archive::new().start(&robot).unwrap_err(), "joint.archive");
    lacks(Joint24Hypotheses::new().start(&robot).unwrap_err(), "joint.hypotheses");
    lacks(Joint60Learning::new().start(&described()).unwrap_err(), "joint.odometry");
    no_room(MixtureInformed4::new().start(&described()).unwrap_err(), "filter");
    let mut memory = Joint60Movers::new();
    let mut slam = memory.start(&robot).unwrap();
    assert_eq!(slam.configure(&robot), Ok(()));
    let mut slower = robot;
    let Filter::Joint(joint) = &mut slower.filter else { panic!() };
    joint.movers.as_mut().unwrap().velocity_sigma_mps = 0.5;
    assert_eq!(slam.configure(&slower), Err(StartError::Fixed { part: part("joint.movers") }));
    let mut bearings = described();
    bearings.sensors[0] = Some(Sensor { model: SensorModel::Bearing, ..bearings.sensors[1].unwrap() });
    no_room(Joint40::new().start(&bearings).unwrap_err(), "sensor.model");
    bearings.filter = Filter::Mixture(Config::informed(4));
    no_room(MixtureInformed4::new().start(&bearings).unwrap_err(), "sensor.model");
    let mut memory = Box::new(WithCamera::new());
    let mut slam = memory.start(&bearings).unwrap();
    slam.reset(&bearings.start).unwrap();
    slam.predict(Control::STILL, 0.1).unwrap();
    slam.scan(0, Measurements::Bearing(&[Vector1::new(0.3)])).unwrap();
    assert_eq!(slam.scan(1, Measurements::Bearing(&[])).unwrap_err(), Refused::NotDescribed);
    assert_eq!(slam.scan(2, Measurements::Bearing(&[])).unwrap_err(), Refused::NotDescribed);
    assert!(slam.predict(Control { left_mps: 1.0, ..Control::STILL }, 0.1).is_err());
}
