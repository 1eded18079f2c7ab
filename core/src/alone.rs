//! A filter with its only sensor, for tests.

use crate::*;
use core::ops::{Deref, DerefMut};
use nalgebra::SVector;
use std::boxed::Box;

/// Room for measurements in a scan.
const MEASUREMENTS: usize = 64;

/// What the tests choose together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Models<M, S, V, C> {
    pub(crate) motion: M,
    pub(crate) sensor: S,
    pub(crate) field_of_view: V,
    pub(crate) clutter: C,
}

/// A filter, and the detector that all its scans are of.
pub(crate) struct Alone<
    's,
    T: Real,
    M: Motion<T, K>,
    S,
    V,
    C,
    const K: usize,
    const D: usize,
    const E: usize,
    const Z: usize,
> where
    Dim<K>: Packed,
    Dim<D>: Packed,
    Dim<E>: Packed,
{
    pub(crate) slam: ScPhd<'s, T, M, K, D, E>,
    pub(crate) detector: Detector<T, S, V, C, ScanRoom<'s, T, Z>>,
}

impl<'s, T, M, S, V, C, const K: usize, const D: usize, const E: usize, const Z: usize>
    Alone<'s, T, M, S, V, C, K, D, E, Z>
where
    T: Real,
    M: Motion<T, K>,
    S: Locating<T, K, D, Z> + Sensor<T, D, Z, Pose = M::Pose>,
    V: FieldOfView<T, S::Frame, D, Z>,
    C: Clutter<T, Z>,
    Dim<K>: Packed,
    Dim<D>: Packed + Twice<E>,
    Dim<E>: Packed,
    Dim<Z>: Packed,
{
    pub(crate) fn new<const PARTICLES: usize, const CANDIDATES: usize, SM, VM>(
        models: Models<M, S, V, C>,
        births: Births<T>,
        config: Config<T>,
        state: &'s mut State<T, M::Pose, K, PARTICLES, CANDIDATES, SM, VM>,
    ) -> Result<Self, SetupError>
    where
        SM: MapStorage<T, D, D>,
        VM: MapStorage<T, E, D>,
    {
        let Models { motion, sensor, field_of_view, clutter } = models;
        let slam = ScPhd::new(motion, config, state)?;
        // A test ends before it matters.
        let memory = Box::leak(Box::new(DetectorMemory::<T, Z, MEASUREMENTS>::new()));
        let detector = Detector::new(Sensing { sensor, field_of_view, clutter }, births)?.over(memory)?;
        slam.check(&detector)?;
        Ok(Self { slam, detector })
    }

    pub(crate) fn scan(&mut self, measurements: &[SVector<T, Z>]) -> Result<ScanReport<T>, ScanError> {
        self.slam.scan(&mut self.detector, measurements)
    }

    pub(crate) fn scan_with(
        &mut self,
        measurements: &[SVector<T, Z>],
        probe: &mut impl Probe,
    ) -> Result<ScanReport<T>, ScanError> {
        self.slam.scan_with(&mut self.detector, measurements, probe)
    }

    pub(crate) fn estimate_map(&self, features: &mut [Component<T, D>]) -> MapEstimate<T> {
        self.slam.estimate_map(&self.detector, features)
    }

    pub(crate) fn estimate_expected_map(&mut self, features: &mut [Component<T, D>]) -> MapEstimate<T> {
        self.slam.estimate_expected_map(&self.detector, features)
    }
}

impl<'s, T, M, S, V, C, const K: usize, const D: usize, const E: usize, const Z: usize> Deref
    for Alone<'s, T, M, S, V, C, K, D, E, Z>
where
    T: Real,
    M: Motion<T, K>,
    Dim<K>: Packed,
    Dim<D>: Packed,
    Dim<E>: Packed,
{
    type Target = ScPhd<'s, T, M, K, D, E>;

    fn deref(&self) -> &Self::Target {
        &self.slam
    }
}

impl<T, M, S, V, C, const K: usize, const D: usize, const E: usize, const Z: usize> DerefMut
    for Alone<'_, T, M, S, V, C, K, D, E, Z>
where
    T: Real,
    M: Motion<T, K>,
    Dim<K>: Packed,
    Dim<D>: Packed,
    Dim<E>: Packed,
{
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.slam
    }
}
