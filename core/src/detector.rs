//! A sensor on the vehicle: its models, where it sits, what it gives birth to, and the scratch of its scans.

use crate::config::ADAPTIVE;
use crate::digest::Fnv;
use crate::models::require;
use crate::online::Learnt;
use crate::scan::Measurement;
use crate::{
    Clutter, ConfigError, Dim, FieldOfView, Flaw, LnSum, ModelError, Mounting, Online, Packed, Pose, Real, Sensor,
    SetupError,
};

/// The models of one sensor.
///
/// Models that come with the crate are checked where they are made. Those of a user are asked by [`Detector::new`] and
/// [`Detector::retune`] whether they can be worked with (`check` of each trait). Whatever they return later, no weight and no stored
/// feature becomes NaN of it, and no loop goes on for ever:
///
/// | returned | taken for |
/// |---|---|
/// | p_D of 1 or more | 1 less a rounding error |
/// | p_D not above zero, NaN | out of view |
/// | ln κ that is NaN or +∞ | no clutter |
/// | an expected measurement, a Jacobian, an innovation that is not finite | a feature that meets no measurement |
/// | an inverse that is not finite | a measurement without birth |
/// | a component of the birth intensity that is not finite or not positive definite | none |
/// | more of those than `VIEW` of the static maps | none, and counted as lost |
/// | a covariance of the measurement noise that is not positive definite | [`ScanError::SensorNoise`](crate::ScanError::SensorNoise) |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensing<S, V, C> {
    /// What is measured: h, its inverse and their noise.
    pub sensor: S,
    /// Where the sensor sees: p_D(m | x).
    pub field_of_view: V,
    /// What it measures though nothing is there: κ(z).
    pub clutter: C,
}

impl<S, V, C> Sensing<S, V, C> {
    /// Whether a filter can work with these models.
    fn check<T: Real, const D: usize, const Z: usize>(&self) -> Result<(), ModelError>
    where
        S: Sensor<T, D, Z>,
        V: FieldOfView<T, S::Frame, D, Z>,
        C: Clutter<T, Z>,
        Dim<D>: Packed,
        Dim<Z>: Packed,
    {
        Sensor::check(&self.sensor)?;
        FieldOfView::check(&self.field_of_view)?;
        Clutter::check(&self.clutter)?;
        require(self.sensor.noise().factor().is_some(), "noise", "positive definite")
    }
}

/// What every measurement of a sensor may be the first one of: intensities in measurement space, in the same unit as the clutter's κ,
/// 1/(m·rad) for range and bearing. κ = w_b means that a measurement which nothing explains is a new feature with probability ½.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Births<T> {
    /// w_b of features that stand still (5.9).
    pub still: T,
    /// w_b of features that move (5.19).
    pub moving: T,
}

impl<T: Real> Births<T> {
    /// None: the sensor sees what is known, and learns of nothing new.
    pub const NONE: Self = Self { still: T::ZERO, moving: T::ZERO };

    /// Features that stand still, with this intensity, and none that move.
    #[must_use]
    pub const fn still(intensity: T) -> Self {
        Self { still: intensity, moving: T::ZERO }
    }

    fn check(&self) -> Result<(), ModelError> {
        let usable = |intensity: T| intensity >= T::ZERO && intensity.is_finite();
        require(usable(self.still), "births.still", "finite and not negative")?;
        require(usable(self.moving), "births.moving", "finite and not negative")
    }

    /// Of both kinds.
    pub(crate) fn total(&self) -> T {
        self.still + self.moving
    }
}

/// A sensor on the vehicle, as the filters ask for it with every scan: any number of them, of any kind, may serve one filter.
///
/// [`JointSlam`](crate::JointSlam) works with the detector alone; [`ScPhd`](crate::ScPhd) needs one
/// [over](Self::over) a [`DetectorMemory`], the scratch of its scans.
///
/// ```
/// use scphd::{Births, Detector, DetectorMemory, Mounting, RangeBearing, RangeBearingWindow, Sensing, UniformClutter};
///
/// // On a vehicle a static: room for 64 measurements of dimension 2.
/// let mut memory = DetectorMemory::<f32, 2, 64>::new();
/// let window = RangeBearingWindow::full_circle(15.0, 0.9)?;
/// let sensing = Sensing {
///     sensor: RangeBearing::new(0.2, 0.02)?,
///     field_of_view: window,
///     clutter: UniformClutter::of_scan(2.0, window.measure())?,
/// };
/// // 3.8 m ahead of the axle, half a metre to the left.
/// let mounting = Mounting::in_plane(3.8, 0.5, 0.0)?;
/// let front = Detector::new(sensing, Births::still(0.01))?.mounted(mounting)?.over(&mut memory)?;
/// assert_eq!(front.capacity(), 64);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Detector<T: Real, S, V, C, R = ()> {
    pub(crate) sensing: Sensing<S, V, C>,
    pub(crate) mounting: Option<Mounting<T>>,
    pub(crate) births: Births<T>,
    pub(crate) online: Online<T>,
    pub(crate) room: R,
}

impl<T: Real, S, V, C> Detector<T, S, V, C> {
    /// A sensor whose pose is the vehicle's.
    ///
    /// # Errors
    /// A model or an intensity is out of range.
    pub fn new<const D: usize, const Z: usize>(sensing: Sensing<S, V, C>, births: Births<T>) -> Result<Self, ModelError>
    where
        S: Sensor<T, D, Z>,
        V: FieldOfView<T, S::Frame, D, Z>,
        C: Clutter<T, Z>,
        Dim<D>: Packed,
        Dim<Z>: Packed,
    {
        sensing.check()?;
        births.check()?;
        Ok(Self { sensing, mounting: None, births, online: Online::NONE, room: () })
    }

    /// The same with scratch for scans of so many measurements, where what was learnt is kept.
    ///
    /// # Errors
    /// What an earlier detector has left there is out of range: its memory was damaged.
    pub fn over<const Z: usize, const MEASUREMENTS: usize, const WORKERS: usize>(
        self,
        memory: &mut DetectorMemory<T, Z, MEASUREMENTS, WORKERS>,
    ) -> Result<Detector<T, S, V, C, ScanRoom<'_, T, Z>>, SetupError> {
        if !memory.learnt.is_in_range() {
            return Err(SetupError::HeldDamaged(Flaw::Cursor));
        }
        let Self { sensing, mounting, births, online, .. } = self;
        Ok(Detector { sensing, mounting, births, online, room: memory.room() })
    }
}

impl<T: Real, S, V, C, R> Detector<T, S, V, C, R> {
    /// The same sensor, mounted there.
    ///
    /// # Errors
    /// Such a vehicle has no such places.
    pub fn mounted<const K: usize, const D: usize, const Z: usize>(
        self,
        mounting: Mounting<T>,
    ) -> Result<Self, ModelError>
    where
        S: Sensor<T, D, Z>,
        S::Pose: Pose<T, K>,
        Dim<D>: Packed,
        Dim<Z>: Packed,
    {
        S::Pose::check_mounting(&mounting)?;
        Ok(Self { mounting: Some(mounting), ..self })
    }

    /// The same sensor, of which p_D or κ are learnt while running.
    ///
    /// # Errors
    /// A field is out of range, or the crate was built without the feature `adaptive`.
    pub fn learning(self, online: Online<T>) -> Result<Self, ConfigError> {
        if !ADAPTIVE && online.learns() {
            return Err(ConfigError { field: "online", range: "left alone without the feature `adaptive`" });
        }
        online.check()?;
        Ok(Self { online, ..self })
    }

    /// Goes on with other models, between any two scans: noise may be retuned in flight.
    ///
    /// # Errors
    /// A model is out of range; the detector keeps those that it had.
    pub fn retune<const D: usize, const Z: usize>(&mut self, sensing: Sensing<S, V, C>) -> Result<(), ModelError>
    where
        S: Sensor<T, D, Z>,
        V: FieldOfView<T, S::Frame, D, Z>,
        C: Clutter<T, Z>,
        Dim<D>: Packed,
        Dim<Z>: Packed,
    {
        sensing.check()?;
        self.sensing = sensing;
        Ok(())
    }

    /// The models.
    #[must_use]
    pub fn sensing(&self) -> &Sensing<S, V, C> {
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
}

impl<T: Real, S, V, C, const Z: usize> Detector<T, S, V, C, ScanRoom<'_, T, Z>> {
    /// The most measurements that a scan may have.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.room.measurements.len()
    }

    /// Forgets what was learnt.
    pub fn forget(&mut self) {
        *self.room.learnt = Learnt::ZERO;
    }

    /// A hash of what was learnt, which goes on with the digest of the filter: `filter.digest()` for a single detector that learns
    /// nothing.
    #[must_use]
    pub fn digest(&self, of_filter: u64) -> u64 {
        if !self.online.learns() {
            return of_filter;
        }
        let mut digest = Fnv::after(of_filter);
        for ratio in [&self.room.learnt.detections, &self.room.learnt.clutter] {
            digest.take_scalar(ratio.happened);
            digest.take_scalar(ratio.expected);
        }
        digest.value()
    }
}

/// The memory of one detector: the scratch of its scans, and what is learnt of it.
///
/// `MEASUREMENTS` of dimension `Z` in a scan; the weighing is divided into `WORKERS` jobs, each with scratch of its own, for an
/// [`Executor`](crate::Executor). All zero, and meant to be a `static`, like [`State`](crate::State).
#[derive(Debug)]
pub struct DetectorMemory<T: Real, const Z: usize, const MEASUREMENTS: usize, const WORKERS: usize = 1> {
    learnt: Learnt<T>,
    measurements: [Measurement<T, Z>; MEASUREMENTS],
    eta: [[LnSum<T>; MEASUREMENTS]; WORKERS],
    most_in_view: [u16; WORKERS],
}

impl<T: Real, const Z: usize, const MEASUREMENTS: usize, const WORKERS: usize>
    DetectorMemory<T, Z, MEASUREMENTS, WORKERS>
{
    /// Empty. Capacities that cannot work do not compile.
    #[must_use]
    pub const fn new() -> Self {
        const {
            assert!(MEASUREMENTS >= 1, "a scan needs room for a measurement");
            assert!(MEASUREMENTS <= u16::MAX as usize, "measurements are counted in 16 bits");
            assert!(WORKERS >= 1, "weighing needs a worker");
        }
        Self {
            learnt: Learnt::ZERO,
            measurements: [Measurement::ZERO; MEASUREMENTS],
            eta: [[LnSum::ZERO; MEASUREMENTS]; WORKERS],
            most_in_view: [0; WORKERS],
        }
    }

    fn room(&mut self) -> ScanRoom<'_, T, Z> {
        ScanRoom {
            learnt: &mut self.learnt,
            measurements: &mut self.measurements,
            eta: self.eta.as_flattened_mut(),
            most_in_view: &mut self.most_in_view,
        }
    }
}

impl<T: Real, const Z: usize, const MEASUREMENTS: usize, const WORKERS: usize> Default
    for DetectorMemory<T, Z, MEASUREMENTS, WORKERS>
{
    fn default() -> Self {
        Self::new()
    }
}

/// A [`DetectorMemory`] of whatever capacity, borrowed.
#[derive(Debug)]
pub struct ScanRoom<'m, T: Real, const Z: usize> {
    pub(crate) learnt: &'m mut Learnt<T>,
    pub(crate) measurements: &'m mut [Measurement<T, Z>],
    /// Scratch of all workers, one after the other.
    pub(crate) eta: &'m mut [LnSum<T>],
    /// For every worker |V|, the most components in view of the candidates it has weighed.
    pub(crate) most_in_view: &'m mut [u16],
}
