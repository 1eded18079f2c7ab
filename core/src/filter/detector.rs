//! A sensor on the vehicle: its models, where it sits, what it gives birth to, and the scratch of its scans.

use crate::detection::scan::Measurement;
use crate::models::{OnVehicle, require};
use crate::{LnSum, MeasurementModel, ModelError, Mounting, Pose, Real, ScalarOf, SetupError, Vector};

/// What every measurement of a sensor may be the first one of: intensities in measurement space, in the same unit as the clutter's κ,
/// 1/(m·rad) for range and bearing. κ = w_b means that a measurement which nothing explains is a new feature with probability ½.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Births<T> {
    /// w_b of static features (5.9).
    pub of_static: T,
    /// w_b of features that move (5.19).
    pub of_moving: T,
}

impl<T: Real> Births<T> {
    /// None: the sensor sees what is known, and nothing new.
    pub const NONE: Self = Self { of_static: T::ZERO, of_moving: T::ZERO };

    /// Static features, with this intensity, and none that move.
    #[must_use]
    pub const fn of_static(intensity: T) -> Self {
        Self { of_static: intensity, of_moving: T::ZERO }
    }

    fn check(&self) -> Result<(), ModelError> {
        let usable = |intensity: T| intensity >= T::ZERO && intensity.is_finite();
        require(usable(self.of_static), "births.of_static", "finite and not negative")?;
        require(usable(self.of_moving), "births.of_moving", "finite and not negative")
    }

    /// Of both kinds.
    pub(crate) fn total(&self) -> T {
        self.of_static + self.of_moving
    }
}

/// A sensor on the vehicle, as the filters ask for it with every scan: any number of them, of any kind, may serve one filter.
///
/// [`JointSlam`](crate::JointSlam) works with the detector alone; [`ScPhd`](crate::ScPhd) needs one
/// [over](Self::over) a [`DetectorMemory`], the scratch of its scans.
///
/// ```
/// use nalgebra::Vector2;
/// use scphd::models::{Mounting, RangeBearing, RangeBearingWindow, Sensing, UniformClutter};
/// use scphd::{Births, Detector, DetectorMemory};
///
/// // On a vehicle a static: room for 64 measurements of dimension 2.
/// let mut memory = DetectorMemory::<Vector2<f32>, 64>::new();
/// let window = RangeBearingWindow::full_circle(15.0, 0.9)?;
/// let sensing = Sensing {
///     sensor: RangeBearing::new(0.2, 0.02)?,
///     field_of_view: window,
///     clutter: UniformClutter::of_scan(2.0, window.measure())?,
/// };
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
    /// A sensor whose pose is the vehicle's.
    ///
    /// # Errors
    /// A model or an intensity is out of range.
    pub fn new(sensing: X, births: Births<T>) -> Result<Self, ModelError> {
        sensing.check()?;
        births.check()?;
        Ok(Self { sensing, mounting: None, births, room: () })
    }

    /// The same with scratch for scans of so many measurements.
    pub fn over<const MEASUREMENTS: usize, const WORKERS: usize>(
        self,
        memory: &mut DetectorMemory<X::Measurement, MEASUREMENTS, WORKERS>,
    ) -> Result<Detector<X, ScanRoom<'_, X::Measurement>>, SetupError> {
        let Self { sensing, mounting, births, .. } = self;
        Ok(Detector { sensing, mounting, births, room: memory.room() })
    }
}

impl<T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>, R> Detector<X, R> {
    /// The same sensor, mounted there.
    ///
    /// # Errors
    /// Such a vehicle has no such places.
    pub fn mounted(self, mounting: Mounting<T>) -> Result<Self, ModelError> {
        P::check_mounting(&mounting)?;
        Ok(Self { mounting: Some(mounting), ..self })
    }

    /// Goes on with other models, between any two scans: noise may be retuned in flight.
    ///
    /// # Errors
    /// A model is out of range; the detector keeps those that it had.
    pub fn retune(&mut self, sensing: X) -> Result<(), ModelError> {
        sensing.check()?;
        self.sensing = sensing;
        Ok(())
    }

    /// Goes on as another detector, between any two scans: with its models, where it sits and what it gives birth to.
    /// The room stays.
    pub fn adopt(&mut self, other: Detector<X>) {
        let Detector { sensing, mounting, births, room: () } = other;
        (self.sensing, self.mounting, self.births) = (sensing, mounting, births);
    }

    /// The models.
    #[must_use]
    pub fn sensing(&self) -> &X {
        &self.sensing
    }

    /// Where the sensor sits; `None` where its pose is the vehicle's.
    #[must_use]
    pub fn mounting(&self) -> Option<&Mounting<T>> {
        self.mounting.as_ref()
    }

    /// The birth intensities.
    #[must_use]
    pub fn births(&self) -> &Births<T> {
        &self.births
    }

    /// Its models, speaking of the vehicle's pose.
    pub(crate) fn on_vehicle(&self) -> OnVehicle<'_, X> {
        OnVehicle::of(&self.sensing, self.mounting)
    }
}

impl<X: MeasurementModel> Detector<X, ScanRoom<'_, X::Measurement>> {
    /// The most measurements that a scan may have.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.room.measurements.len()
    }
}

/// The memory of one detector: the scratch of its scans.
///
/// `MEASUREMENTS` of dimension `Z` in a scan; weighing and updates are divided into `WORKERS` jobs, each with scratch of its own, for an
/// [`Executor`](crate::Executor). All zero, and meant to be a `static`, like [`State`](crate::State).
#[derive(Debug)]
pub struct DetectorMemory<Z: Vector, const MEASUREMENTS: usize, const WORKERS: usize = 1> {
    measurements: [Measurement<Z>; MEASUREMENTS],
    eta: [[LnSum<Z::Scalar>; MEASUREMENTS]; WORKERS],
    most_in_view: [u16; WORKERS],
}

impl<Z: Vector, const MEASUREMENTS: usize, const WORKERS: usize> DetectorMemory<Z, MEASUREMENTS, WORKERS> {
    /// Empty. Capacities that cannot work do not compile.
    #[must_use]
    pub const fn new() -> Self {
        const {
            assert!(MEASUREMENTS >= 1, "a scan needs room for a measurement");
            assert!(MEASUREMENTS <= u16::MAX as usize, "measurements are counted in 16 bits");
            assert!(WORKERS >= 1, "weighing needs a worker");
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

impl<Z: Vector, const MEASUREMENTS: usize, const WORKERS: usize> Default for DetectorMemory<Z, MEASUREMENTS, WORKERS> {
    fn default() -> Self {
        Self::new()
    }
}

/// A [`DetectorMemory`] of whatever capacity, borrowed.
#[derive(Debug)]
pub struct ScanRoom<'m, Z: Vector> {
    pub(crate) measurements: &'m mut [Measurement<Z>],
    /// Scratch of all workers, one after the other.
    pub(crate) eta: &'m mut [LnSum<Z::Scalar>],
    /// For every worker |V|, the most components in view of the candidates it has weighed.
    pub(crate) most_in_view: &'m mut [u16],
}
