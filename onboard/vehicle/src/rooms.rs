//! Working memory that the sensors of a mixture share, which determines the supported sensor models. The code for other models is
//! not linked.

use crate::{Direction, Measurements, Polar, Ranging, Refused, Sensor, SensorModel, StartError};
use core::fmt::Debug;
use core::marker::PhantomData;
use nalgebra::{Vector1, Vector2};
use scphd::diagnostics::Probe;
use scphd::errors::{ScanError, SetupError};
use scphd::models::{PlanarMotion, PlanarPose, RangeNoise};
use scphd::{Component, DetectorMemory, MapEstimate, Real, ScPhd, ScanReport};

type Filter<'m, T> = ScPhd<'m, PlanarMotion<T>>;

/// The working memory for the scans of a mixture: [`PolarRooms`] or [`BearingRooms`].
pub trait Rooms<T: Real>: Debug {
    /// The detector of one sensor.
    type Detector: Copy + Debug;

    /// Constructs the detector of a sensor.
    ///
    /// # Errors
    /// The sensor is out of range, or its model is not supported.
    fn detector(sensor: &Sensor<T>) -> Result<Self::Detector, StartError>;

    /// Checks that a filter can process its scans.
    ///
    /// # Errors
    /// It cannot.
    fn check(filter: &Filter<'_, T>, detector: &Self::Detector) -> Result<(), SetupError>;

    /// Updates the filter with a scan.
    ///
    /// # Errors
    /// The scan is refused, or is of another sensor model.
    fn scan_with(
        &mut self,
        filter: &mut Filter<'_, T>,
        detector: &Self::Detector,
        measurements: Measurements<'_, T>,
        probe: &mut impl Probe,
    ) -> Result<ScanReport<T>, Refused<ScanError>>;

    /// Writes the features; the detection model of this detector decides which are confirmed.
    fn features(
        filter: &mut Filter<'_, T>,
        detector: &Self::Detector,
        room: &mut [Component<Vector2<T>>],
    ) -> MapEstimate<T>;
}

/// For sensors of range and bearing, with this noise.
#[derive(Debug)]
pub struct PolarRooms<T: Real, const MEASUREMENTS: usize, N = RangeNoise<T>> {
    memory: DetectorMemory<Vector2<T>, MEASUREMENTS>,
    noise: PhantomData<N>,
}

impl<T: Real, const MEASUREMENTS: usize, N> PolarRooms<T, MEASUREMENTS, N> {
    /// An empty working memory.
    #[must_use]
    pub const fn new() -> Self {
        Self { memory: DetectorMemory::new(), noise: PhantomData }
    }
}

impl<T: Real, const MEASUREMENTS: usize, N> Default for PolarRooms<T, MEASUREMENTS, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, const MEASUREMENTS: usize, N: Ranging<T>> Rooms<T> for PolarRooms<T, MEASUREMENTS, N> {
    type Detector = Polar<PlanarPose<T>, T, N>;

    fn detector(sensor: &Sensor<T>) -> Result<Self::Detector, StartError> {
        sensor.seen::<PlanarPose<T>, N>()
    }

    fn check(filter: &Filter<'_, T>, detector: &Self::Detector) -> Result<(), SetupError> {
        filter.check(detector)
    }

    fn scan_with(
        &mut self,
        filter: &mut Filter<'_, T>,
        detector: &Self::Detector,
        measurements: Measurements<'_, T>,
        probe: &mut impl Probe,
    ) -> Result<ScanReport<T>, Refused<ScanError>> {
        let Measurements::RangeBearing(measurements) = measurements else { return Err(Refused::NotDescribed) };
        let mut detector = detector.over(&mut self.memory).map_err(|_| Refused::NotDescribed)?;
        Ok(filter.scan_with(&mut detector, measurements, probe)?)
    }

    fn features(
        filter: &mut Filter<'_, T>,
        detector: &Self::Detector,
        room: &mut [Component<Vector2<T>>],
    ) -> MapEstimate<T> {
        filter.estimate_map(detector, room)
    }
}

/// For sensors of range and bearing, and bearing-only sensors.
#[derive(Debug)]
pub struct BearingRooms<T: Real, const MEASUREMENTS: usize> {
    polar: PolarRooms<T, MEASUREMENTS>,
    direction: DetectorMemory<Vector1<T>, MEASUREMENTS>,
}

/// A detector of either sensor model.
#[derive(Debug, Clone, Copy)]
pub enum Either<T: Real> {
    /// Range and bearing.
    Polar(Polar<PlanarPose<T>, T>),
    /// Bearings only.
    Direction(Direction<PlanarPose<T>, T>),
}

impl<T: Real, const MEASUREMENTS: usize> BearingRooms<T, MEASUREMENTS> {
    /// An empty working memory.
    #[must_use]
    pub const fn new() -> Self {
        Self { polar: PolarRooms::new(), direction: DetectorMemory::new() }
    }
}

impl<T: Real, const MEASUREMENTS: usize> Default for BearingRooms<T, MEASUREMENTS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, const MEASUREMENTS: usize> Rooms<T> for BearingRooms<T, MEASUREMENTS> {
    type Detector = Either<T>;

    fn detector(sensor: &Sensor<T>) -> Result<Self::Detector, StartError> {
        Ok(match sensor.model {
            SensorModel::RangeBearing => Either::Polar(sensor.polar::<PlanarPose<T>>()?),
            SensorModel::Bearing => Either::Direction(sensor.direction::<PlanarPose<T>>()?),
        })
    }

    fn check(filter: &Filter<'_, T>, detector: &Self::Detector) -> Result<(), SetupError> {
        match detector {
            Either::Polar(detector) => filter.check(detector),
            Either::Direction(detector) => filter.check(detector),
        }
    }

    fn scan_with(
        &mut self,
        filter: &mut Filter<'_, T>,
        detector: &Self::Detector,
        measurements: Measurements<'_, T>,
        probe: &mut impl Probe,
    ) -> Result<ScanReport<T>, Refused<ScanError>> {
        match (detector, measurements) {
            (Either::Polar(detector), measurements) => self.polar.scan_with(filter, detector, measurements, probe),
            (Either::Direction(detector), Measurements::Bearing(measurements)) => {
                let mut detector = detector.over(&mut self.direction).map_err(|_| Refused::NotDescribed)?;
                Ok(filter.scan_with(&mut detector, measurements, probe)?)
            }
            _ => Err(Refused::NotDescribed),
        }
    }

    fn features(
        filter: &mut Filter<'_, T>,
        detector: &Self::Detector,
        room: &mut [Component<Vector2<T>>],
    ) -> MapEstimate<T> {
        match detector {
            Either::Polar(detector) => filter.estimate_map(detector, room),
            Either::Direction(detector) => filter.estimate_map(detector, room),
        }
    }
}
