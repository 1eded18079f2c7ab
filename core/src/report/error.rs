//! Errors of the operations. An operation that returns an error leaves the state unchanged, with one exception: the time of a
//! refused prediction counts as elapsed, and the reports show the refusal.

use crate::numerics::range::{is_within_range, is_within_square};
use crate::{ConfigError, Fix, ModelError, Pose, Real, Symmetric, Vector};

/// Errors of the construction of a filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SetupError {
    /// A field of the configuration is out of range.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// More particles are configured than the state has memory for.
    #[error("{particles} particles do not fit a state for {capacity}")]
    TooManyParticles {
        /// Configured number of particles.
        particles: usize,
        /// Capacity of the state.
        capacity: usize,
    },
    /// More candidates (particles × samples) are configured than the state has memory for.
    #[error("{candidates} candidates (particles × samples) do not fit a state for {capacity}")]
    TooManyCandidates {
        /// Configured number of candidates.
        candidates: usize,
        /// Capacity of the state.
        capacity: usize,
    },
    /// A detector has moving births, and the state has no memory for moving features.
    #[error("births.of_moving is above 0, but the state has no moving maps")]
    NoRoomForMoving,
    /// A parameter of a model is out of range.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The sensor's birth intensity has more components than an update has memory for (`VIEW` of the static maps).
    #[error("the sensor's birth intensity has more than {capacity} components, the capacity of an update")]
    TooManyBirths {
        /// Capacity of an update, in components.
        capacity: usize,
    },
    /// The state has particles of an earlier filter, and their number is not the configured one.
    #[error("the state has {held} particles, but {configured} are configured; clear it first")]
    HeldParticles {
        /// Particles in the state.
        held: usize,
        /// Configured number of particles.
        configured: usize,
    },
    /// The state has samples of a prediction whose scan has not come yet, and their number is not the configured one.
    #[error("the state has {held} samples per particle, but {configured} are configured; clear it first")]
    HeldSamples {
        /// Samples per particle in the state.
        held: usize,
        /// Configured number of samples per particle.
        configured: usize,
    },
    /// The particles in the state have covariances, which only the informed proposal supports.
    #[error("the poses in the state have covariances, which only the informed proposal supports; clear it first")]
    HeldCovariance,
    /// The content of the state, left by an earlier filter, is inconsistent: its memory was damaged.
    #[error("the state is damaged: {0}; clear it first")]
    HeldDamaged(Flaw),
}

/// Errors of setting the pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ResetError {
    /// The pose is not finite, or a coordinate is above 1e8.
    #[error("the pose is not finite, or a coordinate is above 1e8")]
    NonFinitePose,
    /// The covariance is not finite, a variance is negative, or the covariance of two coordinates is greater than their variances
    /// allow.
    #[error("the covariance is not finite, a variance is negative, or a correlation is beyond ±1")]
    Covariance,
    /// The filter has not been reset yet.
    #[error("the filter has not been reset yet")]
    NotStarted,
}

impl ResetError {
    /// Checks a pose that a filter is set to.
    pub(crate) fn check_pose<P: Pose>(pose: &P) -> Result<(), Self> {
        let usable = pose.is_finite() && is_within_range(&pose.coordinates());
        if usable { Ok(()) } else { Err(Self::NonFinitePose) }
    }

    /// Checks a covariance: finite, no negative variance, and covariances within the limits of the variances, except for rounding
    /// errors.
    pub(crate) fn check_covariance<T: Real, K: Vector<Scalar = T>>(covariance: &Symmetric<K>) -> Result<(), Self> {
        let rounding = T::from_f64(1.05);
        let variance = |k: usize| covariance.get(k, k);
        let may_share = |row: usize, column: usize| {
            let common = covariance.get(row, column);
            common * common <= variance(row) * variance(column) * rounding
        };
        let usable = is_within_square(covariance)
            && (0..K::DIMENSION).all(|k| variance(k) >= T::ZERO && (0..k).all(|column| may_share(k, column)));
        if usable { Ok(()) } else { Err(Self::Covariance) }
    }
}

/// Errors of loading a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LoadMapError {
    /// The filter has not been reset yet.
    #[error("the filter has not been reset yet")]
    NotStarted,
    /// A component is not finite, is farther from the origin than 1e8 m or heavier than a million features, or its covariance is
    /// not positive definite.
    #[error("component {index} is not finite, too far away or too heavy, or its covariance is not positive definite")]
    Component {
        /// Its index in the map.
        index: usize,
    },
    /// A component's label is above [`ScPhd::GREATEST_LOADED_LABEL`](crate::ScPhd::GREATEST_LOADED_LABEL).
    #[error("component {index} has a label that is too great")]
    Tag {
        /// Its index in the map.
        index: usize,
    },
    /// The map has more components than the state has memory for.
    #[error("{components} components do not fit a state for {capacity}")]
    TooManyComponents {
        /// Components in the map.
        components: usize,
        /// Capacity of the state.
        capacity: usize,
    },
}

/// Errors of a prediction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PredictError {
    /// The filter has not been reset yet.
    #[error("the filter has not been reset yet")]
    NotStarted,
    /// The time step is negative or not finite.
    #[error("the time step is negative or not finite")]
    TimeStep,
    /// The control is not finite or outside the domain of the motion model.
    #[error("the control is not finite or outside the motion model's domain")]
    Control,
    /// The motion is beyond the limits of [`Plausible`](crate::Plausible).
    #[error(transparent)]
    Implausible(Implausible),
}

/// Errors of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ScanError {
    /// The filter has not been reset yet.
    #[error("the filter has not been reset yet")]
    NotStarted,
    /// The scan has more measurements than the memory of the detector, or of the joint map, has room for. The caller decides which
    /// to leave out.
    #[error("{measurements} measurements do not fit a state for {capacity}")]
    TooManyMeasurements {
        /// Measurements in the scan.
        measurements: usize,
        /// Capacity of the memory.
        capacity: usize,
    },
    /// A measurement is not finite.
    #[error("measurement {index} is not finite")]
    NonFinite {
        /// Its index in the scan.
        index: usize,
    },
    /// The covariance of the sensor's noise is not positive definite.
    #[error("the covariance of the sensor's noise is not positive definite")]
    SensorNoise,
    /// The detector has moving births, and the state has no memory for moving features.
    #[error("births.of_moving is above 0, but the state has no moving maps")]
    NoRoomForMoving,
}

impl ScanError {
    /// Checks the number of measurements against the capacity, and that they are finite.
    pub(crate) fn check<Z: Vector>(measurements: &[Z], capacity: usize) -> Result<(), Self> {
        if measurements.len() > capacity {
            return Err(Self::TooManyMeasurements { measurements: measurements.len(), capacity });
        }
        let finite = |z: &Z| z.as_slice().iter().all(|coordinate| coordinate.is_finite());
        let strange = measurements.iter().position(|z| !finite(z));
        strange.map_or(Ok(()), |index| Err(Self::NonFinite { index }))
    }
}

/// Errors of a fix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ObserveError {
    /// The filter has not been reset yet.
    #[error("the filter has not been reset yet")]
    NotStarted,
    /// The measurement is not finite.
    #[error("the measurement is not finite")]
    NonFinite,
    /// The covariance of its noise is not positive definite.
    #[error("the covariance of the noise is not positive definite")]
    Noise,
}

impl ObserveError {
    /// Checks a fix.
    pub(crate) fn check<F: Fix>(fix: &F, measured: &F::Measurement) -> Result<(), Self> {
        if !measured.as_slice().iter().all(|coordinate| coordinate.is_finite()) {
            return Err(Self::NonFinite);
        }
        fix.noise().factor().map(|_| ()).ok_or(Self::Noise)
    }
}

/// Which limit of [`Plausible`](crate::Plausible) a prediction exceeds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Implausible {
    /// The time step is longer than [`Plausible::step_max_s`](crate::Plausible::step_max_s).
    #[error("the time step is longer than step_max_s")]
    Step,
    /// The vehicle would be faster than [`Plausible::speed_max_mps`](crate::Plausible::speed_max_mps).
    #[error("the vehicle would be faster than speed_max_mps")]
    Speed,
    /// The vehicle would turn faster than [`Plausible::turn_rate_max_radps`](crate::Plausible::turn_rate_max_radps).
    #[error("the vehicle would turn faster than turn_rate_max_radps")]
    TurnRate,
    /// The vehicle would move farther than [`Plausible::jump_max_m`](crate::Plausible::jump_max_m) in one step.
    #[error("the vehicle would move farther than jump_max_m in one step")]
    Jump,
}

/// Inconsistencies of a state. The filter itself produces none of them; damaged memory can.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Flaw {
    /// A count, a time or a value of the divergence monitor is out of range.
    #[error("a count, a time or a value of the divergence monitor is out of range")]
    Cursor,
    /// A pose is out of range, or its covariance is not finite.
    #[error("a pose is out of range")]
    Pose,
    /// The weights do not sum to one.
    #[error("the weights do not sum to one")]
    Weights,
    /// The data of the delayed births is invalid.
    #[error("the delayed births are invalid")]
    Waiting,
    /// The page lists and the reference counts of the pages do not agree.
    #[error("the page lists and the reference counts do not agree")]
    Pages,
    /// A component is not finite, not positive definite, or outside the bounding box of its page.
    #[error("a component is not finite, not positive definite or outside the box of its page")]
    Component,
}
