//! The interface of both filters for tests of memory faults.

use super::world::{CLUTTER, DETECTION, DT_S, Passage, RANGE_M};
use super::{JOINT_FEATURES, MEASUREMENTS};
use crate::tests::alone::Lidar;
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;
use std::vec;
use std::vec::Vec;

type Mixture = State<PlanarPose<f32>, 4, 4, MapMemory<Static<Vector2<f32>>, 4, 96, 20, 320>>;
type Joint =
    JointState<PlanarPose<f32>, Vector2<f32>, JOINT_FEATURES, { joint_numbers(3, 2, JOINT_FEATURES) }, MEASUREMENTS>;

const KIND: u32 = 1;

/// A step was refused, which reports the fault to the vehicle.
#[derive(Debug)]
pub(crate) struct Refused;

pub(crate) trait Slam {
    fn predict(&mut self, passage: &Passage) -> Result<Health, Refused>;
    fn scan(&mut self, passage: &Passage) -> Result<Health, Refused>;
    fn scrub(&mut self, scrubber: &mut Scrubber, parts: usize) -> Result<Scrubbed, Flaw>;
    fn seal(&self) -> u64;
    fn save(&mut self) -> Vec<u8>;
    fn restore(&mut self, bytes: &[u8]);
    /// x, y, heading; NaN without a pose.
    fn pose(&self) -> [f64; 3];
    fn map(&mut self) -> Vec<[f64; 2]>;
    fn flip(&mut self, draws: &mut Noise) -> (&'static str, usize);
}

fn motion() -> Unicycle<f32> {
    Unicycle::new(Step::Arc, ControlNoise::white(0.15, 0.05)).unwrap()
}

fn lidar() -> Detector<Lidar<f32>> {
    let window = RangeBearingWindow::full_circle(RANGE_M, DETECTION).unwrap();
    let sensing = Sensing::range_bearing([0.1, 0.015], window, CLUTTER).unwrap();
    Detector::new(sensing, Births::of_static(sensing.clutter.intensity())).unwrap()
}

fn control(passage: &Passage) -> UnicycleControl<f32> {
    UnicycleControl { speed_mps: passage.control[0], rate_radps: passage.control[1] }
}

fn coordinates(estimate: Option<PoseEstimate<PlanarPose<f32>>>) -> [f64; 3] {
    let of = |pose: PlanarPose<f32>| [pose.x_m, pose.y_m, pose.heading_rad].map(f64::from);
    estimate.map_or([f64::NAN; 3], |estimate| of(estimate.mean))
}

/// The methods that are the same for both filters.
macro_rules! in_the_same_words {
    () => {
        fn predict(&mut self, passage: &Passage) -> Result<Health, Refused> {
            self.slam.predict(&control(passage), DT_S).map(|report| report.health).map_err(|_| Refused)
        }

        fn scan(&mut self, passage: &Passage) -> Result<Health, Refused> {
            self.slam.scan(&mut self.eyes, &passage.scan).map(|report| report.health).map_err(|_| Refused)
        }

        fn scrub(&mut self, scrubber: &mut Scrubber, parts: usize) -> Result<Scrubbed, Flaw> {
            self.slam.scrub(scrubber, parts)
        }

        fn seal(&self) -> u64 {
            self.slam.seal()
        }

        fn save(&mut self) -> Vec<u8> {
            let mut bytes = vec![0; 100_000];
            let len = self.slam.save(KIND, into_slice(&mut bytes)).unwrap();
            bytes.truncate(len);
            bytes
        }

        fn restore(&mut self, bytes: &[u8]) {
            self.slam.restore(KIND, from_slice(bytes)).unwrap();
        }

        fn pose(&self) -> [f64; 3] {
            coordinates(self.slam.estimate_pose())
        }

        fn flip(&mut self, draws: &mut Noise) -> (&'static str, usize) {
            self.slam.flip_bit(draws)
        }
    };
}

/// A joint map.
pub(crate) struct OfJoint<'s> {
    slam: JointSlam<'s, Unicycle<f32>, Vector2<f32>>,
    eyes: Detector<Lidar<f32>>,
}

pub(crate) fn joint() -> OfJoint<'static> {
    // Leaked: the memory lives until the test ends.
    let state = Box::leak(Box::new(Joint::new()));
    let mut slam = JointSlam::new(motion(), JointConfig::default(), state).unwrap();
    slam.reset(PlanarPose::ZERO).unwrap();
    OfJoint { slam, eyes: lidar() }
}

impl Slam for OfJoint<'_> {
    in_the_same_words!();

    fn map(&mut self) -> Vec<[f64; 2]> {
        self.slam.features().map(|feature| [feature.mean.x, feature.mean.y].map(f64::from)).collect()
    }
}

/// Four informed particles.
pub(crate) struct OfMixture<'s> {
    slam: ScPhd<'s, Unicycle<f32>>,
    eyes: Detector<Lidar<f32>, ScanRoom<'s, Vector2<f32>>>,
}

pub(crate) fn mixture() -> OfMixture<'static> {
    let state = Box::leak(Box::new(Mixture::new()));
    let scratch = Box::leak(Box::new(DetectorMemory::<Vector2<f32>, MEASUREMENTS>::new()));
    let mut slam = ScPhd::new(motion(), Config::informed(4), state).unwrap();
    slam.reset(PlanarPose::ZERO, 1).unwrap();
    OfMixture { slam, eyes: lidar().over(scratch).unwrap() }
}

impl Slam for OfMixture<'_> {
    in_the_same_words!();

    fn map(&mut self) -> Vec<[f64; 2]> {
        let mut features = vec![Component::ZERO; 200];
        let count = self.slam.estimate_map(&self.eyes, &mut features).features;
        features.iter().take(count).map(|feature| [feature.mean.x, feature.mean.y].map(f64::from)).collect()
    }
}
