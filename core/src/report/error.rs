//! Errors of the operations. An operation that returns an error leaves the state unchanged, with one exception: the time of a
//! refused prediction counts as elapsed, and the reports show the refusal.

use crate::numerics::range::{is_within_range, is_within_square};
use crate::{ConfigError, Fix, ModelError, Pose, Real, Symmetric, Vector};
use core::fmt;

/// Errors of the construction of a filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SetupError {
    /// A field of the configuration is out of range.
    Config(ConfigError),
    /// More particles are configured than the state has memory for.
    TooManyParticles {
        /// Configured number of particles.
        particles: usize,
        /// Capacity of the state.
        capacity: usize,
    },
    /// More candidates (particles × samples) are configured than the state has memory for.
    TooManyCandidates {
        /// Configured number of candidates.
        candidates: usize,
        /// Capacity of the state.
        capacity: usize,
    },
    /// A detector has moving births, and the state has no memory for moving features.
    NoRoomForMoving,
    /// A parameter of a model is out of range.
    Model(ModelError),
    /// The sensor's birth intensity has more components than an update has memory for (`VIEW` of the static maps).
    TooManyBirths {
        /// Capacity of an update, in components.
        capacity: usize,
    },
    /// The state has particles of an earlier filter, and their number is not the configured one.
    HeldParticles {
        /// Particles in the state.
        held: usize,
        /// Configured number of particles.
        configured: usize,
    },
    /// The state has samples of a prediction whose scan has not come yet, and their number is not the configured one.
    HeldSamples {
        /// Samples per particle in the state.
        held: usize,
        /// Configured number of samples per particle.
        configured: usize,
    },
    /// The particles in the state have covariances, which only the informed proposal supports.
    HeldCovariance,
    /// The content of the state, left by an earlier filter, is inconsistent: its memory was damaged.
    HeldDamaged(Flaw),
}

impl fmt::Display for SetupError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Config(error) => error.fmt(f),
            Self::TooManyParticles { particles, capacity } => {
                write!(f, "{particles} particles do not fit a state for {capacity}")
            }
            Self::TooManyCandidates { candidates, capacity } => {
                write!(f, "{candidates} candidates (particles × samples) do not fit a state for {capacity}")
            }
            Self::NoRoomForMoving => f.write_str("births.of_moving is above 0, but the state has no moving maps"),
            Self::Model(error) => error.fmt(f),
            Self::TooManyBirths { capacity } => {
                write!(f, "the sensor's birth intensity has more than {capacity} components, the capacity of an update")
            }
            Self::HeldParticles { held, configured } => {
                write!(f, "the state has {held} particles, but {configured} are configured; clear it first")
            }
            Self::HeldSamples { held, configured } => {
                write!(f, "the state has {held} samples per particle, but {configured} are configured; clear it first")
            }
            Self::HeldCovariance => f.write_str(
                "the poses in the state have covariances, which only the informed proposal supports; clear it first",
            ),
            Self::HeldDamaged(flaw) => write!(f, "the state is damaged: {flaw}; clear it first"),
        }
    }
}

impl core::error::Error for SetupError {}

impl From<ModelError> for SetupError {
    fn from(error: ModelError) -> Self {
        Self::Model(error)
    }
}

impl From<ConfigError> for SetupError {
    fn from(error: ConfigError) -> Self {
        Self::Config(error)
    }
}

/// Errors of setting the pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ResetError {
    /// The pose is not finite, or a coordinate is above 1e8.
    NonFinitePose,
    /// The covariance is not finite, a variance is negative, or the covariance of two coordinates is greater than their variances
    /// allow.
    Covariance,
    /// The filter has not been reset yet.
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

impl fmt::Display for ResetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NonFinitePose => "the pose is not finite, or a coordinate is above 1e8",
            Self::Covariance => "the covariance is not finite, a variance is negative, or a correlation is beyond ±1",
            Self::NotStarted => "the filter has not been reset yet",
        })
    }
}

impl core::error::Error for ResetError {}

/// Errors of loading a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LoadMapError {
    /// The filter has not been reset yet.
    NotStarted,
    /// A component is not finite, is farther from the origin than 1e8 m or heavier than a million features, or its covariance is
    /// not positive definite.
    Component {
        /// Its index in the map.
        index: usize,
    },
    /// A component's label is above [`ScPhd::GREATEST_LOADED_LABEL`](crate::ScPhd::GREATEST_LOADED_LABEL).
    Tag {
        /// Its index in the map.
        index: usize,
    },
    /// The map has more components than the state has memory for.
    TooManyComponents {
        /// Components in the map.
        components: usize,
        /// Capacity of the state.
        capacity: usize,
    },
}

impl fmt::Display for LoadMapError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotStarted => f.write_str("the filter has not been reset yet"),
            Self::Component { index } => {
                write!(
                    f,
                    "component {index} is not finite, too far away or too heavy, or its covariance is not positive definite"
                )
            }
            Self::Tag { index } => write!(f, "component {index} has a label that is too great"),
            Self::TooManyComponents { components, capacity } => {
                write!(f, "{components} components do not fit a state for {capacity}")
            }
        }
    }
}

impl core::error::Error for LoadMapError {}

/// Errors of a prediction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PredictError {
    /// The filter has not been reset yet.
    NotStarted,
    /// The time step is negative or not finite.
    TimeStep,
    /// The control is not finite or outside the domain of the motion model.
    Control,
    /// The motion is beyond the limits of [`Plausible`](crate::Plausible).
    Implausible(Implausible),
}

impl fmt::Display for PredictError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotStarted => "the filter has not been reset yet",
            Self::TimeStep => "the time step is negative or not finite",
            Self::Control => "the control is not finite or outside the motion model's domain",
            Self::Implausible(what) => return what.fmt(f),
        })
    }
}

impl core::error::Error for PredictError {}

/// Errors of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ScanError {
    /// The filter has not been reset yet.
    NotStarted,
    /// The scan has more measurements than the memory of the detector, or of the joint map, has room for. The caller decides which
    /// to leave out.
    TooManyMeasurements {
        /// Measurements in the scan.
        measurements: usize,
        /// Capacity of the memory.
        capacity: usize,
    },
    /// A measurement is not finite.
    NonFinite {
        /// Its index in the scan.
        index: usize,
    },
    /// The covariance of the sensor's noise is not positive definite.
    SensorNoise,
    /// The detector has moving births, and the state has no memory for moving features.
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

impl fmt::Display for ScanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotStarted => f.write_str("the filter has not been reset yet"),
            Self::TooManyMeasurements { measurements, capacity } => {
                write!(f, "{measurements} measurements do not fit a state for {capacity}")
            }
            Self::NonFinite { index } => write!(f, "measurement {index} is not finite"),
            Self::NoRoomForMoving => f.write_str("births.of_moving is above 0, but the state has no moving maps"),
            Self::SensorNoise => f.write_str("the covariance of the sensor's noise is not positive definite"),
        }
    }
}

impl core::error::Error for ScanError {}

/// Errors of a fix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ObserveError {
    /// The filter has not been reset yet.
    NotStarted,
    /// The measurement is not finite.
    NonFinite,
    /// The covariance of its noise is not positive definite.
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

impl fmt::Display for ObserveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotStarted => "the filter has not been reset yet",
            Self::NonFinite => "the measurement is not finite",
            Self::Noise => "the covariance of the noise is not positive definite",
        })
    }
}

impl core::error::Error for ObserveError {}

/// Which limit of [`Plausible`](crate::Plausible) a prediction exceeds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Implausible {
    /// The time step is longer than [`Plausible::step_max_s`](crate::Plausible::step_max_s).
    Step,
    /// The vehicle would be faster than [`Plausible::speed_max_mps`](crate::Plausible::speed_max_mps).
    Speed,
    /// The vehicle would turn faster than [`Plausible::turn_rate_max_radps`](crate::Plausible::turn_rate_max_radps).
    TurnRate,
    /// The vehicle would move farther than [`Plausible::jump_max_m`](crate::Plausible::jump_max_m) in one step.
    Jump,
}

impl fmt::Display for Implausible {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Step => "the time step is longer than step_max_s",
            Self::Speed => "the vehicle would be faster than speed_max_mps",
            Self::TurnRate => "the vehicle would turn faster than turn_rate_max_radps",
            Self::Jump => "the vehicle would move farther than jump_max_m in one step",
        })
    }
}

/// Inconsistencies of a state. The filter itself produces none of them; damaged memory can.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Flaw {
    /// A count, a time or a value of the divergence monitor is out of range.
    Cursor,
    /// A pose is out of range, or its covariance is not finite.
    Pose,
    /// The weights do not sum to one.
    Weights,
    /// The data of the delayed births is invalid.
    Waiting,
    /// The page lists and the reference counts of the pages do not agree.
    Pages,
    /// A component is not finite, not positive definite, or outside the bounding box of its page.
    Component,
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Cursor => "a count, a time or a value of the divergence monitor is out of range",
            Self::Pose => "a pose is out of range",
            Self::Weights => "the weights do not sum to one",
            Self::Waiting => "the delayed births are invalid",
            Self::Pages => "the page lists and the reference counts do not agree",
            Self::Component => "a component is not finite, not positive definite or outside the box of its page",
        })
    }
}

impl core::error::Error for Flaw {}
