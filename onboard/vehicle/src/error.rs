//! Why a description or a call is refused.

use crate::Range;
use core::fmt;
use scphd::errors::{ScanError, SetupError};
use scphd::models::ModelError;

/// A setting that is out of range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Invalid {
    /// Its name, as [`Field::name`](crate::Field::name).
    pub field: &'static str,
    /// What it may be.
    pub range: Range,
    /// Of a setting of a sensor: which sensor.
    pub sensor: Option<usize>,
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.sensor {
            Some(sensor) => write!(f, "{} of sensor {sensor} must be {}", self.field, self.range),
            None => write!(f, "{} must be {}", self.field, self.range),
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
        /// The part, by the name of its setting.
        part: &'static str,
    },
    /// The memory is one for this part, which the description does not have.
    NotDescribed {
        /// The part, by the name of its setting.
        part: &'static str,
    },
    /// The numbers of this part cannot be changed while the filter goes on.
    Fixed {
        /// The part, by the name of its setting.
        part: &'static str,
    },
}

impl fmt::Display for StartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Invalid(invalid) => invalid.fmt(f),
            Self::Setup(error) => error.fmt(f),
            Self::NoRoom { part } => write!(f, "the memory has no room for {part}"),
            Self::NotDescribed { part } => write!(f, "the memory is for a filter with {part}, which is not described"),
            Self::Fixed { part } => write!(f, "{part} cannot change while the filter goes on"),
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
    /// This filter cannot do it: a mixture cannot localise, a map with an archive behind it cannot be loaded.
    NotPossible,
}

impl<E: fmt::Display> fmt::Display for Refused<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Filter(error) => error.fmt(f),
            Self::NotDescribed => f.write_str("there is no such sensor or fix in the description"),
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
