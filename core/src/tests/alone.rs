//! A filter with its only sensor, for tests.

use crate::*;
use core::ops::{Deref, DerefMut};
use std::boxed::Box;

/// Capacity for measurements of a scan.
const MEASUREMENTS: usize = 64;

/// Models that a test combines.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Models<M, S, V, C> {
    pub(crate) motion: M,
    pub(crate) sensor: S,
    pub(crate) field_of_view: V,
    pub(crate) clutter: C,
}

/// A filter with the detector of all its scans.
pub(crate) struct Alone<'s, M: Motion, X: MeasurementModel> {
    pub(crate) slam: ScPhd<'s, M>,
    pub(crate) detector: Detector<X, ScanRoom<'s, X::Measurement>>,
}

impl<'s, T, M, S, V, C> Alone<'s, M, Sensing<S, V, C>>
where
    T: Real,
    M: Motion<Pose: Pose<Scalar = T>>,
    S: Sensor<Pose = M::Pose>,
    V: FieldOfView<S::Frame, PositionOf<M::Pose>, S::Measurement>,
    C: Clutter<S::Measurement>,
{
    pub(crate) fn new<const PARTICLES: usize, const CANDIDATES: usize, SM, VM>(
        models: Models<M, S, V, C>,
        births: Births<T>,
        config: Config<T>,
        state: &'s mut State<M::Pose, PARTICLES, CANDIDATES, SM, VM>,
    ) -> Result<Self, SetupError>
    where
        SM: MapStorage<Static<PositionOf<M::Pose>>>,
        VM: MapStorage<Dynamic<PositionOf<M::Pose>>>,
    {
        let Models { motion, sensor, field_of_view, clutter } = models;
        let slam = ScPhd::new(motion, config, state)?;
        // Leaked: the memory lives until the test ends.
        let memory = Box::leak(Box::new(DetectorMemory::<S::Measurement, MEASUREMENTS>::new()));
        let detector = Detector::new(Sensing { sensor, field_of_view, clutter }, births)?.over(memory)?;
        slam.check(&detector)?;
        Ok(Self { slam, detector })
    }
}

impl<T, M, X> Alone<'_, M, X>
where
    T: Real,
    M: Motion<Pose: Pose<Scalar = T>>,
    X: MeasurementModel<Pose = M::Pose>,
{
    pub(crate) fn scan(&mut self, measurements: &[X::Measurement]) -> Result<ScanReport<T>, ScanError> {
        self.slam.scan(&mut self.detector, measurements)
    }

    pub(crate) fn estimate_map(&self, features: &mut [Component<PositionOf<M::Pose>>]) -> MapEstimate<T> {
        self.slam.estimate_map(&self.detector, features)
    }

    pub(crate) fn estimate_expected_map(&mut self, features: &mut [Component<PositionOf<M::Pose>>]) -> MapEstimate<T> {
        self.slam.estimate_expected_map(&self.detector, features)
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
