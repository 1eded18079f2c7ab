//! One error type for a function that calls several operations.

use super::error::{LoadMapError, ObserveError, PredictError, ResetError, ScanError, SetupError};
use crate::{ConfigError, ModelError};

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
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error {
    /// Error of a model, of a configuration, or of the construction of a filter.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// Error of a reset, a relocation or an inflation of the covariance.
    #[error(transparent)]
    Reset(#[from] ResetError),
    /// Error of loading a map.
    #[error(transparent)]
    LoadMap(#[from] LoadMapError),
    /// Error of a prediction.
    #[error(transparent)]
    Predict(#[from] PredictError),
    /// Error of a scan.
    #[error(transparent)]
    Scan(#[from] ScanError),
    /// Error of a fix.
    #[error(transparent)]
    Observe(#[from] ObserveError),
}

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
