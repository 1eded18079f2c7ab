//! Why a description or a call is refused.

use crate::Setting;
use core::fmt;
use scphd::errors::{ScanError, SetupError};
use scphd::models::ModelError;

/// A setting that is out of range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Invalid {
    /// Which setting.
    pub setting: Setting,
    /// Of a setting of a sensor: which sensor.
    pub sensor: Option<usize>,
}

impl Invalid {
    /// A setting, of this sensor where it is one of a sensor.
    pub(crate) fn of(setting: Setting, sensor: usize) -> Self {
        Self { setting, sensor: setting.is_of_a_sensor().then_some(sensor) }
    }
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, range) = (self.setting.name(), self.setting.range());
        match self.sensor {
            Some(sensor) => write!(f, "{name} of sensor {sensor} must be {range}"),
            None => write!(f, "{name} must be {range}"),
        }
    }
}

impl core::error::Error for Invalid {}

/// Why no filter is assembled.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum StartError {
    /// A setting is out of range.
    Invalid(Invalid),
    /// Settings do not fit each other or the memory, as the library says.
    Setup(SetupError),
    /// The memory is not one for this part of the description.
    NoRoom {
        /// The setting that says so.
        part: Setting,
    },
    /// The memory is one for this part, which the description does not have.
    NotDescribed {
        /// The setting that says so.
        part: Setting,
    },
    /// The numbers of this part cannot be changed while the filter goes on.
    Fixed {
        /// The setting that says so.
        part: Setting,
    },
}

impl fmt::Display for StartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Invalid(invalid) => invalid.fmt(f),
            Self::Setup(error) => error.fmt(f),
            Self::NoRoom { part } => write!(f, "the memory is not for what {} says", part.name()),
            Self::NotDescribed { part } => {
                write!(f, "the memory is for a filter with {}, which is not described", part.name())
            }
            Self::Fixed { part } => write!(f, "{} cannot change while the filter runs", part.name()),
        }
    }
}

impl core::error::Error for StartError {}

impl From<Invalid> for StartError {
    fn from(invalid: Invalid) -> Self {
        Self::Invalid(invalid)
    }
}

impl From<SetupError> for StartError {
    fn from(error: SetupError) -> Self {
        Self::Setup(error)
    }
}

impl From<ModelError> for StartError {
    fn from(error: ModelError) -> Self {
        Self::Setup(error.into())
    }
}

/// Why a call does nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Refused<E> {
    /// The filter refuses it.
    Filter(E),
    /// The description has no such sensor or fix, or it measures something else.
    NotDescribed,
    /// There is a watch over such fixes, which [`Services`](crate::Services) have see them.
    Watched,
    /// This filter cannot do it: a mixture cannot localise, a map with an archive behind it cannot be loaded.
    NotPossible,
}

impl<E: fmt::Display> fmt::Display for Refused<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Filter(error) => error.fmt(f),
            Self::NotDescribed => f.write_str("there is no such sensor or fix in the description"),
            Self::Watched => f.write_str("there is a watch over such fixes"),
            Self::NotPossible => f.write_str("this filter cannot do that"),
        }
    }
}

impl<E: core::error::Error> core::error::Error for Refused<E> {}

impl From<ScanError> for Refused<ScanError> {
    fn from(error: ScanError) -> Self {
        Self::Filter(error)
    }
}
