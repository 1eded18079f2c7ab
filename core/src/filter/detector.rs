//! A sensor on the vehicle: its models, its mounting, its birth intensities, and the working memory of its scans.

use crate::detection::scan::Measurement;
use crate::models::{OnVehicle, require};
use crate::{LnSum, MeasurementModel, ModelError, Mounting, Pose, Real, ScalarOf, SetupError, Vector};

/// Birth intensities of a sensor in measurement space, in the unit of the clutter intensity κ: 1/(m·rad) for range and bearing.
/// With κ = w_b, a measurement that comes from no known feature is a new feature with probability ½.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Births<T> {
    /// Birth intensity w_b of static features (5.9).
    pub of_static: T,
    /// Birth intensity w_b of moving features (5.19).
    pub of_moving: T,
}

impl<T: Real> Births<T> {
    /// No births: the sensor detects only features that are already in the map.
    pub const NONE: Self = Self { of_static: T::ZERO, of_moving: T::ZERO };

    /// Births of static features only, with this intensity.
    pub const fn of_static(intensity: T) -> Self {
        Self { of_static: intensity, of_moving: T::ZERO }
    }

    fn check(&self) -> Result<(), ModelError> {
        require(self.of_static.is_amount(), "births.of_static", "finite and not negative")?;
        require(self.of_moving.is_amount(), "births.of_moving", "finite and not negative")
    }

    /// The sum of both intensities.
    pub(crate) fn total(&self) -> T {
        self.of_static + self.of_moving
    }
}

/// A sensor on the vehicle, which is passed to a filter with every scan. One filter can use any number of detectors, of any type.
///
/// [`JointSlam`](crate::JointSlam) needs only the detector; [`ScPhd`](crate::ScPhd) needs it [with](Self::over) a
/// [`DetectorMemory`], the working memory of its scans.
///
/// ```
/// use nalgebra::Vector2;
/// use scphd::models::{Mounting, RangeBearingWindow, Sensing};
/// use scphd::{Births, Detector, DetectorMemory};
///
/// // On a vehicle, a static: memory for 64 measurements of dimension 2.
/// let mut memory = DetectorMemory::<Vector2<f32>, 64>::new();
/// let window = RangeBearingWindow::full_circle(15.0, 0.9)?;
/// let sensing = Sensing::range_bearing([0.2, 0.02], window, 2.0)?;
/// // 3.8 m ahead of the axle, half a metre to the left.
/// let mounting = Mounting::in_plane(3.8, 0.5, 0.0)?;
/// let front = Detector::new(sensing, Births::of_static(0.01))?.mounted(mounting)?.over(&mut memory)?;
/// assert_eq!(front.capacity(), 64);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Detector<X: MeasurementModel, R = ()> {
    pub(crate) sensing: X,
    pub(crate) mounting: Option<Mounting<ScalarOf<X::Pose>>>,
    pub(crate) births: Births<ScalarOf<X::Pose>>,
    pub(crate) room: R,
}

impl<T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>> Detector<X> {
    /// A sensor without a mounting: its pose is that of the vehicle.
    ///
    /// # Errors
    /// A model or an intensity is out of range.
    pub fn new(sensing: X, births: Births<T>) -> Result<Self, ModelError> {
        sensing.check()?;
        births.check()?;
        Ok(Self { sensing, mounting: None, births, room: () })
    }

    /// This detector with working memory for scans of up to `MEASUREMENTS` measurements.
    pub fn over<const MEASUREMENTS: usize, const WORKERS: usize>(
        self,
        memory: &mut DetectorMemory<X::Measurement, MEASUREMENTS, WORKERS>,
    ) -> Result<Detector<X, ScanRoom<'_, X::Measurement>>, SetupError> {
        let Self { sensing, mounting, births, .. } = self;
        Ok(Detector { sensing, mounting, births, room: memory.room() })
    }
}

impl<T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>, R> Detector<X, R> {
    /// This detector with a mounting on the vehicle.
    ///
    /// # Errors
    /// The mounting does not fit the pose of the vehicle.
    pub fn mounted(self, mounting: Mounting<T>) -> Result<Self, ModelError> {
        P::check_mounting(&mounting)?;
        Ok(Self { mounting: Some(mounting), ..self })
    }

    /// Replaces the models, for example to tune the noise during operation. Allowed between any two scans.
    ///
    /// # Errors
    /// A model is out of range; the detector keeps the previous ones.
    pub fn retune(&mut self, sensing: X) -> Result<(), ModelError> {
        sensing.check()?;
        self.sensing = sensing;
        Ok(())
    }

    /// Takes over the models, the mounting and the birth intensities of another detector, and keeps the working memory. Allowed
    /// between any two scans.
    pub fn adopt(&mut self, other: Detector<X>) {
        let Detector { sensing, mounting, births, room: () } = other;
        (self.sensing, self.mounting, self.births) = (sensing, mounting, births);
    }

    /// The models.
    pub fn sensing(&self) -> &X {
        &self.sensing
    }

    /// The mounting of the sensor; `None` if its pose is that of the vehicle.
    pub fn mounting(&self) -> Option<&Mounting<T>> {
        self.mounting.as_ref()
    }

    /// The birth intensities.
    pub fn births(&self) -> &Births<T> {
        &self.births
    }

    /// The models with the mounting applied: they take the pose of the vehicle.
    pub(crate) fn on_vehicle(&self) -> OnVehicle<'_, X> {
        OnVehicle::of(&self.sensing, self.mounting)
    }
}

impl<X: MeasurementModel> Detector<X, ScanRoom<'_, X::Measurement>> {
    /// Maximum number of measurements of a scan.
    pub fn capacity(&self) -> usize {
        self.room.measurements.len()
    }
}

/// Working memory for the scans of one detector.
///
/// A scan has up to `MEASUREMENTS` measurements of dimension `Z`. Weighting and updates are divided into `WORKERS` jobs for an
/// [`Executor`](crate::Executor), each with working memory of its own. All zero, and meant to be a `static`, like
/// [`State`](crate::State).
#[derive(Debug)]
pub struct DetectorMemory<Z: Vector, const MEASUREMENTS: usize, const WORKERS: usize = 1> {
    measurements: [Measurement<Z>; MEASUREMENTS],
    eta: [[LnSum<Z::Scalar>; MEASUREMENTS]; WORKERS],
    most_in_view: [u16; WORKERS],
}

impl<Z: Vector, const MEASUREMENTS: usize, const WORKERS: usize> DetectorMemory<Z, MEASUREMENTS, WORKERS> {
    /// An empty memory. Invalid capacities do not compile.
    pub const fn new() -> Self {
        const {
            assert!(MEASUREMENTS >= 1, "a scan needs room for a measurement");
            assert!(MEASUREMENTS <= u16::MAX as usize, "measurements are counted in 16 bits");
            assert!(WORKERS >= 1, "weighting needs a worker");
        }
        Self {
            measurements: [Measurement::ZERO; MEASUREMENTS],
            eta: [[LnSum::ZERO; MEASUREMENTS]; WORKERS],
            most_in_view: [0; WORKERS],
        }
    }

    fn room(&mut self) -> ScanRoom<'_, Z> {
        ScanRoom {
            measurements: &mut self.measurements,
            eta: self.eta.as_flattened_mut(),
            most_in_view: &mut self.most_in_view,
        }
    }
}

/// A borrowed [`DetectorMemory`] of any capacity.
#[derive(Debug)]
pub struct ScanRoom<'m, Z: Vector> {
    pub(crate) measurements: &'m mut [Measurement<Z>],
    /// Scratch of all workers, one after the other.
    pub(crate) eta: &'m mut [LnSum<Z::Scalar>],
    /// For every worker |V|, the most components in view of the candidates it has weighed.
    pub(crate) most_in_view: &'m mut [u16],
}
