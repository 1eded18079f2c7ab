//! Why an operation was refused. Whatever is refused leaves the state as it was; but of a prediction the time has passed all
//! the same, and the reports tell of it.

use crate::numerics::range::{is_within_range, is_within_square};
use crate::{ConfigError, Fix, ModelError, Pose, Real, Symmetric, Vector};
use core::fmt;

/// Why a filter cannot be set up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SetupError {
    /// A field of the configuration is out of range.
    Config(ConfigError),
    /// More particles are configured than the state holds.
    TooManyParticles {
        /// Particles configured.
        particles: usize,
        /// Particles the state holds.
        capacity: usize,
    },
    /// More candidates (particles × samples) are configured than the state holds.
    TooManyCandidates {
        /// Candidates configured.
        candidates: usize,
        /// Candidates the state holds.
        capacity: usize,
    },
    /// Features that move are born, and the state has no memory for them.
    NoRoomForMoving,
    /// A parameter of a model is not one the model can work with.
    Model(ModelError),
    /// The sensor's birth intensity has more components than an update has room for (`VIEW` of the static maps).
    TooManyBirths {
        /// Components there is room for.
        capacity: usize,
    },
    /// The state holds particles of an earlier filter, of another number than is configured.
    HeldParticles {
        /// Particles the state holds.
        held: usize,
        /// Particles configured.
        configured: usize,
    },
    /// The state holds the samples of a prediction whose scan has not come yet, of another number than is configured.
    HeldSamples {
        /// Samples the state holds of every particle.
        held: usize,
        /// Samples that the configuration asks for.
        configured: usize,
    },
    /// The state holds particles whose poses are uncertain in themselves, from which only the informed proposal can go on.
    HeldCovariance,
    /// What an earlier filter has left in the state does not fit together: its memory was damaged.
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
                write!(f, "the sensor's birth intensity has more components than a state for {capacity} in view holds")
            }
            Self::HeldParticles { held, configured } => {
                write!(f, "the state holds {held} particles, and {configured} are configured; clear it first")
            }
            Self::HeldSamples { held, configured } => {
                write!(
                    f,
                    "the state holds {held} samples a particle, and the next scan is to have {configured}; clear it first"
                )
            }
            Self::HeldCovariance => f.write_str(
                "the state's poses are uncertain, which the informed proposal alone goes on from; clear it first",
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

/// Why the filter cannot start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ResetError {
    /// The pose is not finite, or a coordinate above 1e8.
    NonFinitePose,
    /// The covariance is not finite, a variance negative, or two coordinates have more in common than their variances allow.
    Covariance,
    /// There is nothing to go on from: the filter has not been reset yet.
    NotStarted,
}

impl ResetError {
    /// Whether a filter may be put to this pose.
    pub(crate) fn check_pose<P: Pose>(pose: &P) -> Result<(), Self> {
        let usable = pose.is_finite() && is_within_range(&pose.coordinates());
        if usable { Ok(()) } else { Err(Self::NonFinitePose) }
    }

    /// Whether poses may be spread by this: finite, no variance negative, and no more in common than two variances allow, but for rounding.
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
            Self::NonFinitePose => "the pose is not finite, or a coordinate above 1e8",
            Self::Covariance => "the covariance is not finite, or not one",
            Self::NotStarted => "the filter has not been reset yet",
        })
    }
}

impl core::error::Error for ResetError {}

/// Why a map cannot be loaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LoadMapError {
    /// The state holds no particles: it has not been reset yet.
    NotStarted,
    /// A component is not finite, farther from the origin than 1e8 m, heavier than a million features, or its covariance not
    /// positive definite.
    Component {
        /// Its place in the map.
        index: usize,
    },
    /// A component's label is above [`ScPhd::GREATEST_LOADED_LABEL`](crate::ScPhd::GREATEST_LOADED_LABEL).
    Tag {
        /// Its place in the map.
        index: usize,
    },
    /// The map has more components than the state holds.
    TooManyComponents {
        /// Components in the map.
        components: usize,
        /// Components the state holds.
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
                    "component {index} is not finite, too far away or too heavy, or its covariance not positive definite"
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

/// Why a prediction was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PredictError {
    /// The state holds no particles: it has not been reset yet.
    NotStarted,
    /// The time step is negative or not finite.
    TimeStep,
    /// The motion model does not admit the control.
    Control,
    /// It is beyond the limits of [`Plausible`](crate::Plausible).
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

/// Why a scan was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ScanError {
    /// The state holds no particles: it has not been reset yet.
    NotStarted,
    /// The scan has more measurements than there is room for, in the detector's memory or in that of a joint map; the caller chooses which
    /// to leave out.
    TooManyMeasurements {
        /// Measurements in the scan.
        measurements: usize,
        /// Measurements there is room for.
        capacity: usize,
    },
    /// A measurement is not finite.
    NonFinite {
        /// Its place in the scan.
        index: usize,
    },
    /// The covariance of the sensor's noise is not positive definite.
    SensorNoise,
    /// The detector gives birth to features that move, and the state has no memory for them.
    NoRoomForMoving,
}

impl ScanError {
    /// Whether a state with room for so many measurements can take these.
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

/// Why a fix was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ObserveError {
    /// The state holds no pose: it has not been reset yet.
    NotStarted,
    /// The measurement is not finite.
    NonFinite,
    /// The covariance of its noise is not positive definite.
    Noise,
}

impl ObserveError {
    /// Whether a filter can take this fix.
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

/// What of a prediction no vehicle does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Implausible {
    /// It takes longer than [`Plausible::step_max_s`](crate::Plausible::step_max_s).
    Step,
    /// The vehicle would be faster than [`Plausible::speed_max_mps`](crate::Plausible::speed_max_mps).
    Speed,
    /// The vehicle would turn faster than [`Plausible::turn_rate_max_radps`](crate::Plausible::turn_rate_max_radps).
    TurnRate,
    /// The vehicle would come farther than [`Plausible::jump_max_m`](crate::Plausible::jump_max_m).
    Jump,
}

impl fmt::Display for Implausible {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Step => "no step takes so long",
            Self::Speed => "no vehicle is so fast",
            Self::TurnRate => "no vehicle turns so fast",
            Self::Jump => "no vehicle comes so far in one step",
        })
    }
}

/// What is wrong with a state. The filter makes none of it; memory that was damaged may show it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Flaw {
    /// A count, a time or a number of the watch is out of range.
    Cursor,
    /// A pose is beyond every range, or its covariance not finite.
    Pose,
    /// The weights do not sum to one.
    Weights,
    /// What is kept of births that wait for the next scan cannot be.
    Waiting,
    /// The lists of pages and the counts of who holds them do not agree.
    Pages,
    /// A component is not finite, not positive definite, or not where its page says.
    Component,
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Cursor => "a count, a time or a number of the watch is out of range",
            Self::Pose => "a pose is beyond every range",
            Self::Weights => "the weights do not sum to one",
            Self::Waiting => "births that wait are out of range",
            Self::Pages => "pages and the counts of their holders do not agree",
            Self::Component => "a component is not finite, not positive definite or out of place",
        })
    }
}

impl core::error::Error for Flaw {}
