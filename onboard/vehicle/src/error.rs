//! Errors of descriptions and calls.

use crate::Setting;
use core::fmt;
use scphd::errors::{ScanError, SetupError};
use scphd::models::ModelError;

/// A setting that is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Invalid {
    /// The setting.
    pub setting: Setting,
    /// Index of the sensor, for a setting of a sensor.
    pub sensor: Option<usize>,
}

impl Invalid {
    /// The error of the setting at this place of the list.
    pub(crate) fn at(place: usize, sensor: usize) -> Self {
        Self::of(Setting::at(place), sensor)
    }

    /// The error of a setting; `sensor` is used only for settings of a sensor.
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

/// Errors of building a filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// A setting is out of range.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// Settings do not fit each other or the memory.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The memory has no room for this part of the description.
    #[error("the memory is not for what {} says", part.name())]
    NoRoom {
        /// The setting of the part.
        part: Setting,
    },
    /// The memory has room for this part, which the description does not have.
    #[error("the memory is for a filter with {}, which is not described", part.name())]
    NotDescribed {
        /// The setting of the part.
        part: Setting,
    },
    /// The settings of this part cannot be changed while the filter runs.
    #[error("{} cannot change while the filter runs", part.name())]
    Fixed {
        /// The setting of the part.
        part: Setting,
    },
}

impl From<ModelError> for StartError {
    fn from(error: ModelError) -> Self {
        Self::Setup(error.into())
    }
}

/// Errors of a call; it has no effect.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Refused<E> {
    /// The filter refused the input.
    #[error("{0}")]
    Filter(E),
    /// The description has no such sensor or fix, or it measures something else.
    #[error("there is no such sensor or fix in the description")]
    NotDescribed,
    /// The fixes have a monitor: use the methods of [`Services`](crate::Services) that call it.
    #[error("there is a watch over such fixes")]
    Watched,
    /// The filter does not support the call: a mixture cannot localise.
    #[error("this filter cannot do that")]
    NotPossible,
}

impl From<ScanError> for Refused<ScanError> {
    fn from(error: ScanError) -> Self {
        Self::Filter(error)
    }
}
