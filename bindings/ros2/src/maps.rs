//! Maps of earlier drives: saved, loaded, and the place in one found. The files are those of the simulator's maps.

use nalgebra::Vector2;
use scphd::locate::{Locator, LocatorConfig, LocatorReport, LocatorState};
use scphd::models::PlanarPose;
use scphd::snapshot::{from_slice, into_slice, restore_map, save_map};
use scphd::{Component, JointConfig, PoseEstimate};
use scphd_vehicle::{Description, Filter, Sensor, Services};

/// Landmarks of a map, as many as a filter has room for, and places that are weighed against each other.
const FEATURES: usize = 1024;
const HYPOTHESES: usize = 32;
/// Bytes of a file of so many, and some for the frame.
const BYTES: usize = 64 * FEATURES + 64;
/// The simulator's maps are all of one kind.
const KIND: u32 = 0;

type Feature = Component<Vector2<f32>>;

/// Why a map cannot be used.
pub type Refused = String;

/// What the filter knows.
pub fn known(slam: &mut dyn Services<f32>) -> Vec<Feature> {
    let mut room = vec![Feature::ZERO; FEATURES];
    let count = slam.features(&mut room).features;
    room.truncate(count);
    room
}

/// The bytes of a file with these features.
///
/// # Errors
/// A feature is none.
pub fn bytes(features: &[Feature]) -> Result<Vec<u8>, Refused> {
    let mut bytes = vec![0; BYTES];
    let length = save_map(KIND, features.iter().copied(), into_slice(&mut bytes));
    bytes.truncate(length.map_err(|error| error.to_string())?);
    Ok(bytes)
}

/// The features in a file.
///
/// # Errors
/// It is damaged, or none in single precision.
pub fn features(bytes: &[u8]) -> Result<Vec<Feature>, Refused> {
    let mut room = vec![Feature::ZERO; FEATURES];
    let count = restore_map(KIND, &mut room, from_slice(bytes)).map_err(|error| error.to_string())?;
    room.truncate(count);
    Ok(room)
}

/// The search for the place in a map.
#[derive(Debug)]
pub struct Search {
    map: Vec<Feature>,
    memory: Box<LocatorState<f32, FEATURES, HYPOTHESES>>,
}

impl Search {
    /// A search in a map.
    ///
    /// # Errors
    /// There are too few landmarks in it.
    pub fn new(map: Vec<Feature>) -> Result<Self, Refused> {
        let mut memory = Box::new(LocatorState::new());
        let locator = Locator::new(LocatorConfig::default(), &mut memory);
        locator.map_err(|error| error.to_string())?.load_map(&map).map_err(|error| error.to_string())?;
        Ok(Self { map, memory })
    }

    /// After every scan: where the vehicle is in the map, once that is known.
    pub fn look(
        &mut self,
        sensor: &Sensor<f32>,
        slam: &mut dyn Services<f32>,
    ) -> Option<PoseEstimate<PlanarPose<f32>>> {
        let (pose, landmarks) = (slam.pose()?, known(slam));
        let detector = sensor.polar::<PlanarPose<f32>>().ok()?;
        let mut locator = Locator::new(LocatorConfig::default(), &mut *self.memory).ok()?;
        let LocatorReport { found, .. } = locator.look(&detector, &pose, landmarks);
        found.map(|place| place.pose)
    }

    /// The map.
    #[must_use]
    pub fn into_map(self) -> Vec<Feature> {
        self.map
    }
}

/// The description of a filter that is more careful to forget, as one that looks for its place has to be.
#[must_use]
pub fn careful(description: &Description<f32>) -> Description<f32> {
    let mut careful = *description;
    if let Filter::Joint(joint) = &mut careful.filter {
        let JointConfig { least_existence, least_tentative, .. } = JointConfig::strict();
        (joint.config.least_existence, joint.config.least_tentative) = (least_existence, least_tentative);
    }
    careful
}
