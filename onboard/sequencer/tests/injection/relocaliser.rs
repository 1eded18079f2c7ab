//! Relocalisation in the previous map, with a second, new map.

use crate::MEASUREMENTS;
use crate::filters::{Control, lidar, motion};
use crate::vehicle::by;
use crate::world::Setting;
use scphd::locate::*;
use scphd::models::*;
use scphd::numerics::nalgebra::Vector2;
use scphd::*;

type Feature = Component<Vector2<f32>>;

joint_memory! { type NewMap: Unicycle<f32> { measurement: Vector2<f32>, features: 64, measurements: MEASUREMENTS } }

/// Number of scans after which the new map is discarded: a fault during its construction may be over.
const LASTS: usize = 20;

pub struct Relocaliser {
    slam: JointSlam<'static, Unicycle<f32>, Vector2<f32>>,
    detector: Detector<crate::filters::Lidar>,
    locator: Locator<'static, f32>,
    scans: usize,
}

impl Relocaliser {
    /// Nothing to locate yet. The memory is leaked: it lives until the test ends.
    pub fn new(setting: Setting) -> Self {
        let locator = Locator::new(LocatorConfig::default(), Box::leak(Box::new(LocatorState::<f32, 128, 16>::new())));
        let slam = JointSlam::new(motion(), JointConfig::default(), Box::leak(Box::new(NewMap::new())));
        Self { slam: slam.unwrap(), detector: lidar(setting), locator: locator.unwrap(), scans: 0 }
    }

    /// Starts to locate the vehicle in this map.
    pub fn begin(&mut self, map: &[Feature]) {
        self.locator.load_map(map).unwrap();
        self.restart();
    }

    fn restart(&mut self) {
        self.slam.reset(PlanarPose::ZERO).unwrap();
        self.locator.restart();
        self.scans = 0;
    }

    pub fn predict(&mut self, control: &Control, dt: f32) {
        let _ = self.slam.predict(control, dt);
    }

    /// Adds a scan. Returns the pose if it is certain. Odometry may be faulty, so that only the scans are used.
    pub fn scan(&mut self, measurements: &[Vector2<f32>]) -> Option<Located<f32>> {
        if self.scans == LASTS {
            self.restart();
        }
        self.scans += 1;
        if self.scans > 1 {
            self.slam.scatter(&by(0.3, 0.1)).unwrap();
        }
        self.slam.scan(&self.detector, measurements).unwrap();
        self.locator.update(&self.detector, &self.slam.estimate_pose().unwrap(), self.slam.features()).found
    }
}
