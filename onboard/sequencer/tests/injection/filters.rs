//! Both filters, with sufficient memory or a quarter of it.

use crate::MEASUREMENTS;
use crate::world::Setting;
use scphd::models::*;
use scphd::numerics::nalgebra::{Vector2, Vector3};
use scphd::numerics::*;
use scphd::snapshot::*;
use scphd::storage::*;
use scphd::*;

pub type Control = UnicycleControl<f32>;
pub type Lidar = Sensing<RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>>;

joint_memory! { type Joint: Unicycle<f32> { measurement: Vector2<f32>, features: 90, measurements: MEASUREMENTS } }
joint_memory! { type ShortJoint: Unicycle<f32> { measurement: Vector2<f32>, features: 12, measurements: MEASUREMENTS } }
memory! {
    type Mixture: Unicycle<f32> { particles: 4, samples: 1, features { pages: 256, pages_per_map: 64, in_view: 512 } }
}
memory! {
    type ShortMixture: Unicycle<f32> { particles: 4, samples: 1, features { pages: 12, pages_per_map: 3, in_view: 512 } }
}

/// The interface of a filter for a vehicle.
pub trait Slam {
    fn predict(&mut self, control: &Control, dt: f32) -> Health;
    /// Returns the warnings, and the share of the expected detections that were made; 0 if few were expected, because little is
    /// known there.
    fn scan(&mut self, measurements: &[Vector2<f32>]) -> (Health, f32);
    /// As `scan`, for a trial that is undone afterwards: without a change of the map, if the filter supports this.
    fn try_scan(&mut self, measurements: &[Vector2<f32>]) -> (Health, f32);
    fn save(&mut self) -> Vec<u8>;
    fn restore(&mut self, bytes: &[u8]);
    fn scatter(&mut self, covariance: &Symmetric<Vector3<f32>>);
    /// Sets the pose of the vehicle in its map.
    fn relocate(&mut self, pose: PlanarPose<f32>, covariance: &Symmetric<Vector3<f32>>);
    /// The known features.
    fn map(&self) -> Vec<Component<Vector2<f32>>>;
    fn pose(&self) -> PlanarPose<f32>;
}

/// Standard deviations of the odometry, m/√s and rad/√s.
pub const ODOMETRY: [f32; 2] = [0.15, 0.05];
const FEATURES: usize = 128;
/// Maximum number of bytes of a snapshot.
const ROOM: usize = 200_000;

fn share(made: f32, expected: f32) -> f32 {
    if expected < 2.0 { 0.0 } else { made / expected }
}

pub fn motion() -> Unicycle<f32> {
    let [forward, turn] = ODOMETRY;
    Unicycle::new(Step::Arc, ControlNoise::white(forward, turn)).unwrap()
}

pub fn lidar(setting: Setting) -> Detector<Lidar> {
    let window = setting.stated_window();
    let sensing = Sensing::range_bearing([0.1, 0.015], window, setting.clutter as f32).unwrap();
    Detector::new(sensing, Births::of_static(sensing.clutter.intensity())).unwrap()
}

struct OfJoint {
    slam: JointSlam<'static, Unicycle<f32>, Vector2<f32>>,
    detector: Detector<Lidar>,
}

struct OfMixture {
    slam: ScPhd<'static, Unicycle<f32>>,
    detector: Detector<Lidar, ScanRoom<'static, Vector2<f32>>>,
}

/// A joint map. The memory is leaked: it lives until the test ends.
pub fn joint(setting: Setting, short: bool) -> Box<dyn Slam> {
    let config = JointConfig::default();
    let mut slam = if short {
        JointSlam::new(motion(), config, Box::leak(Box::new(ShortJoint::new()))).unwrap()
    } else {
        JointSlam::new(motion(), config, Box::leak(Box::new(Joint::new()))).unwrap()
    };
    slam.reset(PlanarPose::ZERO).unwrap();
    Box::new(OfJoint { slam, detector: lidar(setting) })
}

/// Four informed particles.
pub fn mixture(setting: Setting, short: bool) -> Box<dyn Slam> {
    // Features that were detected three times are kept in spite of misses; others are removed when they leave the view.
    let config =
        Config { confirming_detections: 3.0, confirmed_weight: 0.2, unconfirmed_weight: 1.0, ..Config::informed(4) };
    let mut slam = if short {
        ScPhd::new(motion(), config, Box::leak(Box::new(ShortMixture::new()))).unwrap()
    } else {
        ScPhd::new(motion(), config, Box::leak(Box::new(Mixture::new()))).unwrap()
    };
    slam.reset(PlanarPose::ZERO, 1).unwrap();
    let scratch = Box::leak(Box::new(DetectorMemory::<Vector2<f32>, MEASUREMENTS>::new()));
    let of_joint = lidar(setting);
    let births = Births::of_static(0.1 * of_joint.births().of_static);
    let detector = Detector::new(*of_joint.sensing(), births).unwrap().over(scratch).unwrap();
    Box::new(OfMixture { slam, detector })
}

/// The methods that are the same for both filters.
macro_rules! in_the_same_words {
    () => {
        fn predict(&mut self, control: &Control, dt: f32) -> Health {
            self.slam.predict(control, dt).map_or(Health::PREDICTION_REFUSED, |report| report.health)
        }

        fn scan(&mut self, measurements: &[Vector2<f32>]) -> (Health, f32) {
            let report = self.slam.scan(&mut self.detector, measurements).unwrap();
            (report.health, share(report.detections, report.expected_detections))
        }

        fn save(&mut self) -> Vec<u8> {
            let mut bytes = vec![0; ROOM];
            let len = self.slam.save(1, into_slice(&mut bytes)).unwrap();
            bytes.truncate(len);
            bytes
        }

        fn restore(&mut self, bytes: &[u8]) {
            self.slam.restore(1, from_slice(bytes)).unwrap();
        }

        fn scatter(&mut self, covariance: &Symmetric<Vector3<f32>>) {
            self.slam.scatter(covariance).unwrap();
        }

        fn relocate(&mut self, pose: PlanarPose<f32>, covariance: &Symmetric<Vector3<f32>>) {
            self.slam.relocate(pose, covariance).unwrap();
        }

        fn pose(&self) -> PlanarPose<f32> {
            self.slam.estimate_pose().unwrap().mean
        }
    };
}

impl Slam for OfJoint {
    in_the_same_words!();

    fn try_scan(&mut self, measurements: &[Vector2<f32>]) -> (Health, f32) {
        let report = self.slam.localise(&self.detector, measurements).unwrap();
        (report.health, share(report.detections, report.expected_detections))
    }

    fn map(&self) -> Vec<Component<Vector2<f32>>> {
        self.slam.features().collect()
    }
}

impl Slam for OfMixture {
    in_the_same_words!();

    fn try_scan(&mut self, measurements: &[Vector2<f32>]) -> (Health, f32) {
        self.scan(measurements)
    }

    fn map(&self) -> Vec<Component<Vector2<f32>>> {
        let mut features = vec![Component::ZERO; FEATURES];
        let known = self.slam.estimate_map(&self.detector, &mut features).features;
        features.truncate(known);
        features
    }
}
