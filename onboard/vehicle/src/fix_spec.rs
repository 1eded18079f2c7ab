//! How measurements of the pose itself are taken.

use scphd::Real;
use scphd::fixes::FixRule;

/// A kind of fixes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixSpec<T> {
    /// Standard deviation, m or rad.
    pub sigma: T,
    /// Of positions: how far ahead of the pose and how far to its left the antenna is, m.
    pub antenna_m: [T; 2],
    /// A squared Mahalanobis distance beyond which a fix is an outlier; infinite: none is.
    pub gate: T,
    /// When fixes that are refused are right, and the filter is wrong; `None`: they are never watched.
    pub watch: Option<FixRule<T>>,
}

impl<T: Real> FixSpec<T> {
    /// Fixes with this standard deviation, m or rad, of which none is an outlier.
    #[must_use]
    pub fn of_sigma(sigma: T) -> Self {
        Self { sigma, antenna_m: [T::ZERO; 2], gate: T::INFINITY, watch: None }
    }
}
