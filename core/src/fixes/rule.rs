//! The rule by which a filter is considered diverged.

use crate::models::require;
use crate::{ModelError, Real};

/// When the filter has diverged and the rejected fixes are right: no fix was accepted for some time, several were rejected in a
/// row, and they agree with each other.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FixRule<T> {
    /// Minimum time since the first rejected fix, s. 7 by default, as in PX4's EKF2. Infinite: the filter is never considered
    /// diverged.
    pub patience_s: T,
    /// Minimum number of fixes rejected in a row, 3 to 1000. 5 by default.
    pub fewest: u16,
}

impl<T: Real> Default for FixRule<T> {
    fn default() -> Self {
        Self { patience_s: T::from_f64(7.0), fewest: 5 }
    }
}

impl<T: Real> FixRule<T> {
    /// Checks the parameters.
    pub(super) fn check(self) -> Result<Self, ModelError> {
        require(self.patience_s >= T::ZERO, "patience_s", "0 or more")?;
        require((3..=1000).contains(&self.fewest), "fewest", "3 to 1000")?;
        Ok(self)
    }
}

/// Greatest residual of consistent fixes, in standard deviations of their noise: real noise exceeds that of data sheets, and
/// odometry adds its own.
pub(super) const LOOSE: f64 = 3.0;
