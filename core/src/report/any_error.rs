//! One error for a function that does several operations.

use super::error::{LoadMapError, ObserveError, PredictError, ResetError, ScanError, SetupError};
use crate::{ConfigError, ModelError};
use core::fmt;

/// Why any operation of a filter was refused, so that `?` serves for all of them in one function.
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
    /// Of a model, a configuration or a filter that is set up.
    Setup(SetupError),
    /// Of a reset, a relocation or an inflated covariance.
    Reset(ResetError),
    /// Of a map that is loaded.
    LoadMap(LoadMapError),
    /// Of a prediction.
    Predict(PredictError),
    /// Of a scan.
    Scan(ScanError),
    /// Of a measurement of the pose.
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
