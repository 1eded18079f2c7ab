//! Use of maps of earlier drives by the joint filter, in the plane.

use super::contract::{FoundPlace, Refusal, Search, refusal};
use super::joint_room::FEATURES;
use nalgebra::Vector2;
use scphd::locate::{Locator, LocatorConfig, LocatorReport, LocatorState};
use scphd::models::{MeasurementModel, Motion, PlanarPose, Pose, PositionOf, TangentOf};
use scphd::numerics::{Symmetric, Vector as _};
use scphd::snapshot::{from_slice, into_slice, restore_map, save_map};
use scphd::storage::JointFilter;
use scphd::{Component, Detector, PoseEstimate, Real};

/// Number of hypotheses of the global localisation.
const HYPOTHESES: usize = 32;
/// Greatest size of a map, bytes: features in double precision, and the header.
const MAP_BYTES: usize = 64 * FEATURES + 64;
/// The type of vehicle in map files: the same for all, because the file itself has its scalar.
const KIND: u32 = 0;

type Memory<T> = LocatorState<T, FEATURES, HYPOTHESES>;

/// The interface of a joint filter for maps of earlier drives.
pub(crate) trait Mapped<P: Pose> {
    /// Starts in this map at a pose, with a covariance or certain.
    fn start_at(
        &mut self,
        pose: P,
        covariance: Option<&Symmetric<TangentOf<P>>>,
        map: &[Component<PositionOf<P>>],
    ) -> Result<(), Refusal>;

    /// The estimated pose, if the filter has been started.
    fn here(&self) -> Option<PoseEstimate<P>>;

    fn map(&self) -> Vec<Component<PositionOf<P>>>;
}

impl<M: Motion, F: JointFilter<Motion = M>> Mapped<M::Pose> for F {
    fn start_at(
        &mut self,
        pose: M::Pose,
        covariance: Option<&Symmetric<TangentOf<M::Pose>>>,
        map: &[Component<PositionOf<M::Pose>>],
    ) -> Result<(), Refusal> {
        let started = match covariance {
            Some(covariance) => self.reset_within(pose, covariance),
            None => self.reset(pose),
        };
        started.map_err(refusal)?;
        self.load_map(map).map_err(refusal)
    }

    fn here(&self) -> Option<PoseEstimate<M::Pose>> {
        self.estimate_pose()
    }

    fn map(&self) -> Vec<Component<PositionOf<M::Pose>>> {
        self.features().collect()
    }
}

/// Operations of a joint filter with maps of earlier drives.
pub(crate) trait InMap<X: MeasurementModel> {
    /// Starts in a map: at a known pose, or with global localisation.
    fn start(&mut self, slam: &mut dyn Mapped<X::Pose>, file: &[u8], known: Option<X::Pose>) -> Result<(), Refusal>;

    /// Continues the localisation after a scan, and starts in the map when the place is found.
    fn look(&mut self, slam: &mut dyn Mapped<X::Pose>, detector: &Detector<X>) -> Result<(), Refusal>;

    fn search(&self) -> Option<Search>;

    /// The estimated map as bytes.
    fn file(&self, slam: &dyn Mapped<X::Pose>) -> Result<Vec<u8>, Refusal>;
}

/// Operations in the plane.
pub(crate) struct PlanarMap<T: Real> {
    map: Vec<Component<Vector2<T>>>,
    memory: Option<Box<Memory<T>>>,
    search: Option<Search>,
}

impl<T: Real> PlanarMap<T> {
    pub(crate) fn new() -> Self {
        Self { map: Vec::new(), memory: None, search: None }
    }
}

impl<T: Real, X: MeasurementModel<Pose = PlanarPose<T>>> InMap<X> for PlanarMap<T> {
    fn start(
        &mut self,
        slam: &mut dyn Mapped<PlanarPose<T>>,
        file: &[u8],
        known: Option<PlanarPose<T>>,
    ) -> Result<(), Refusal> {
        let mut map = vec![Component::ZERO; FEATURES];
        let features = restore_map(KIND, &mut map, from_slice(file)).map_err(refusal)?;
        map.truncate(features);
        self.map = map;
        if let Some(pose) = known {
            return slam.start_at(pose, None, &self.map);
        }
        let mut memory = Box::new(Memory::new());
        Locator::new(LocatorConfig::default(), &mut memory).map_err(refusal)?.load_map(&self.map).map_err(refusal)?;
        self.memory = Some(memory);
        self.search = Some(Search { scans: 0, found: None, elsewhere: 1.0 });
        // Until the place is found, the filter maps in a frame of its own.
        slam.start_at(PlanarPose::ZERO, None, &[])
    }

    fn look(&mut self, slam: &mut dyn Mapped<PlanarPose<T>>, detector: &Detector<X>) -> Result<(), Refusal> {
        let (Some(memory), Some(search)) = (&mut self.memory, &mut self.search) else { return Ok(()) };
        let estimate = slam.here().ok_or_else(|| refusal("not started"))?;
        let mut locator = Locator::new(LocatorConfig::default(), &mut **memory).map_err(refusal)?;
        let LocatorReport { found, elsewhere, .. } = locator.update(detector, &estimate, slam.map());
        search.scans += 1;
        search.elsewhere = elsewhere.to_f64();
        let Some(place) = found else { return Ok(()) };
        let coordinates = place.pose.mean.coordinates();
        search.found = Some(FoundPlace {
            pose: std::array::from_fn(|k| coordinates.at(k).to_f64()),
            probability: place.probability.to_f64(),
            matched: place.matched,
        });
        self.memory = None;
        slam.start_at(place.pose.mean, Some(&place.pose.covariance), &self.map)
    }

    fn search(&self) -> Option<Search> {
        self.search
    }

    fn file(&self, slam: &dyn Mapped<PlanarPose<T>>) -> Result<Vec<u8>, Refusal> {
        let mut bytes = vec![0; MAP_BYTES];
        let len = save_map(KIND, slam.map().into_iter(), into_slice(&mut bytes)).map_err(refusal)?;
        bytes.truncate(len);
        Ok(bytes)
    }
}
