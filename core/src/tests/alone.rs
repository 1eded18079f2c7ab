//! A filter with its only sensor, for tests.

use crate::*;
use core::ops::{Deref, DerefMut};
use std::boxed::Box;

/// Capacity for measurements of a scan.
const MEASUREMENTS: usize = 64;

/// A range and bearing sensor.
pub(crate) type Lidar<T> = Sensing<RangeBearing<T>, RangeBearingWindow<T>, UniformClutter<T>>;

/// Models that a test combines.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Models<M, X> {
    pub(crate) motion: M,
    pub(crate) sensing: X,
}

/// A filter with the detector of all its scans.
pub(crate) struct Alone<'s, M: Motion, X: MeasurementModel> {
    pub(crate) slam: ScPhd<'s, M>,
    pub(crate) detector: Detector<X, ScanRoom<'s, X::Measurement>>,
}

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>, X: MeasurementModel<Pose = M::Pose>> Alone<'s, M, X> {
    pub(crate) fn new<const PARTICLES: usize, const CANDIDATES: usize, SM, VM>(
        Models { motion, sensing }: Models<M, X>,
        births: Births<T>,
        config: Config<T>,
        state: &'s mut State<M::Pose, PARTICLES, CANDIDATES, SM, VM>,
    ) -> Result<Self, SetupError>
    where
        SM: MapStorage<Static<PositionOf<M::Pose>>>,
        VM: MapStorage<Dynamic<PositionOf<M::Pose>>>,
    {
        let slam = ScPhd::new(motion, config, state)?;
        // Leaked: the memory lives until the test ends.
        let memory = Box::leak(Box::new(DetectorMemory::<X::Measurement, MEASUREMENTS>::new()));
        let detector = Detector::new(sensing, births)?.over(memory)?;
        slam.check(&detector)?;
        Ok(Self { slam, detector })
    }

    pub(crate) fn scan(&mut self, measurements: &[X::Measurement]) -> Result<ScanReport<T>, ScanError> {
        self.slam.scan(&mut self.detector, measurements)
    }

    pub(crate) fn estimate_map(&self, features: &mut [Component<PositionOf<M::Pose>>]) -> MapEstimate<T> {
        self.slam.estimate_map(&self.detector, features)
    }
}

impl<'s, M: Motion, X: MeasurementModel> Deref for Alone<'s, M, X> {
    type Target = ScPhd<'s, M>;

    fn deref(&self) -> &Self::Target {
        &self.slam
    }
}

impl<M: Motion, X: MeasurementModel> DerefMut for Alone<'_, M, X> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.slam
    }
}
