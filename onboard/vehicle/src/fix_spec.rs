//! Settings of the fixes.

use scphd::Real;
use scphd::fixes::FixRule;

/// A type of fixes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixSpec<T> {
    /// Standard deviation, m or rad.
    pub sigma: T,
    /// Position of the antenna ahead and to the left of the pose, m, for position fixes.
    pub antenna_m: [T; 2],
    /// Squared Mahalanobis distance beyond which a fix is an outlier; infinite: no gate.
    pub gate: T,
    /// Rule of the monitor that decides whether rejected fixes are right and the filter has diverged; `None`: no monitor.
    pub watch: Option<FixRule<T>>,
}

impl<T: Real> FixSpec<T> {
    /// Fixes with this standard deviation, m or rad, without a gate.
    #[must_use]
    pub fn of_sigma(sigma: T) -> Self {
        Self { sigma, antenna_m: [T::ZERO; 2], gate: T::INFINITY, watch: None }
    }
}
