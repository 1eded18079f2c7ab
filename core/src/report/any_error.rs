//! One error type for a function that calls several operations.

use super::error::{LoadMapError, ObserveError, PredictError, ResetError, ScanError, SetupError};
use crate::{ConfigError, ModelError};
use core::fmt;

/// An error of any operation of a filter, so that one function can use `?` for all of them.
///
/// ```
/// use scphd::models::{ControlNoise, PositionFix, RangeBearing, Step, Unicycle};
///
/// fn models() -> Result<(Unicycle<f32>, RangeBearing<f32>, PositionFix<f32>), scphd::errors::Error> {
///     Ok((Unicycle::new(Step::Arc, ControlNoise::wheeled())?, RangeBearing::new(0.05, 0.01)?, PositionFix::new(0.5)?))
/// }
/// assert!(models().is_ok());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error {
    /// Error of a model, of a configuration, or of the construction of a filter.
    Setup(SetupError),
    /// Error of a reset, a relocation or an inflation of the covariance.
    Reset(ResetError),
    /// Error of loading a map.
    LoadMap(LoadMapError),
    /// Error of a prediction.
    Predict(PredictError),
    /// Error of a scan.
    Scan(ScanError),
    /// Error of a fix.
    Observe(ObserveError),
}

macro_rules! from {
    ($($error:ident as $variant:ident),*) => {
        $(impl From<$error> for Error {
            fn from(error: $error) -> Self {
                Self::$variant(error)
            }
        })*

        impl fmt::Display for Error {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                match self {
                    $(Self::$variant(error) => error.fmt(f),)*
                }
            }
        }
    };
}

from!(
    SetupError as Setup,
    ResetError as Reset,
    LoadMapError as LoadMap,
    PredictError as Predict,
    ScanError as Scan,
    ObserveError as Observe
);

impl From<ModelError> for Error {
    fn from(error: ModelError) -> Self {
        Self::Setup(error.into())
    }
}

impl From<ConfigError> for Error {
    fn from(error: ConfigError) -> Self {
        Self::Setup(error.into())
    }
}

impl core::error::Error for Error {}
