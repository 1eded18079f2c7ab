//! Map files: saving, loading, and global localisation. The format is that of the simulator's maps.

use nalgebra::Vector2;
use scphd::locate::{Locator, LocatorConfig, LocatorReport, LocatorState};
use scphd::models::PlanarPose;
use scphd::snapshot::{from_slice, into_slice, restore_map, save_map};
use scphd::{Component, JointConfig, PoseEstimate};
use scphd_vehicle::{Description, Filter, Sensor, Services};

/// Capacities: landmarks of a map, as many as in a filter, and hypotheses.
const FEATURES: usize = 1024;
const HYPOTHESES: usize = 32;
/// Greatest size of a file: all features and the frame.
const BYTES: usize = 64 * FEATURES + 64;
/// All maps of the simulator have this vehicle type.
const KIND: u32 = 0;

type Feature = Component<Vector2<f32>>;

/// The reason why a map cannot be used.
pub type Refused = String;

/// The features of the filter.
pub fn known(slam: &mut dyn Services<f32>) -> Vec<Feature> {
    let mut room = vec![Feature::ZERO; FEATURES];
    let count = slam.features(&mut room).features;
    room.truncate(count);
    room
}

/// The bytes of a file with these features.
pub fn bytes(features: &[Feature]) -> Result<Vec<u8>, Refused> {
    let mut bytes = vec![0; BYTES];
    let length = save_map(KIND, features.iter().copied(), into_slice(&mut bytes));
    bytes.truncate(length.map_err(|error| error.to_string())?);
    Ok(bytes)
}

/// The features of a file.
pub fn features(bytes: &[u8]) -> Result<Vec<Feature>, Refused> {
    let mut room = vec![Feature::ZERO; FEATURES];
    let count = restore_map(KIND, &mut room, from_slice(bytes)).map_err(|error| error.to_string())?;
    room.truncate(count);
    Ok(room)
}

/// Global localisation in a map.
#[derive(Debug)]
pub struct Search {
    map: Vec<Feature>,
    memory: Box<LocatorState<f32, FEATURES, HYPOTHESES>>,
}

impl Search {
    /// Starts in a map.
    pub fn new(map: Vec<Feature>) -> Result<Self, Refused> {
        let mut memory = Box::new(LocatorState::new());
        let locator = Locator::new(LocatorConfig::default(), &mut memory);
        locator.map_err(|error| error.to_string())?.load_map(&map).map_err(|error| error.to_string())?;
        Ok(Self { map, memory })
    }

    /// Updates the search after a scan. Returns the pose in the map, once it is found.
    pub fn look(
        &mut self,
        sensor: &Sensor<f32>,
        slam: &mut dyn Services<f32>,
    ) -> Option<PoseEstimate<PlanarPose<f32>>> {
        let (pose, landmarks) = (slam.pose()?, known(slam));
        let detector = sensor.polar::<PlanarPose<f32>>().ok()?;
        let mut locator = Locator::new(LocatorConfig::default(), &mut *self.memory).ok()?;
        let LocatorReport { found, .. } = locator.update(&detector, &pose, landmarks);
        found.map(|place| place.pose)
    }

    pub fn into_map(self) -> Vec<Feature> {
        self.map
    }
}

/// The description with stricter thresholds for removing landmarks, which global localisation needs.
pub fn careful(description: &Description<f32>) -> Description<f32> {
    let mut careful = *description;
    if let Filter::Joint(joint) = &mut careful.filter {
        let JointConfig { least_existence, least_tentative, .. } = JointConfig::strict();
        (joint.config.least_existence, joint.config.least_tentative) = (least_existence, least_tentative);
    }
    careful
}
