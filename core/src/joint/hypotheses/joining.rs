//! Hypotheses with practically the same pose.

use super::super::associate::is_beyond;
use super::super::covariance::row_start;
use super::super::walk::Estimate;
use crate::{CovarianceOf, Pose, Real, Symmetric, TangentOf, Vector};

impl<T: Real, P: Pose<Scalar = T>> Estimate<'_, P> {
    pub(super) fn pose_covariance(&self) -> CovarianceOf<P> {
        Symmetric::from_fn(|row, column| {
            let (row, column) = (row.max(column), row.min(column));
            self.numbers.get(row_start(row) + column).copied().unwrap_or(T::ZERO)
        })
    }
}

/// Whether the pose of `other` is within `sigmas` standard deviations of that of `one`. If the covariance is not positive
/// definite, for example zero, the poses are compared coordinate by coordinate.
pub(super) fn are_alike<T: Real, P: Pose<Scalar = T>>(
    one: &Estimate<'_, P>,
    other: &Estimate<'_, P>,
    sigmas: T,
) -> bool {
    let apart = other.header.pose.difference(&one.header.pose);
    let covariance = one.pose_covariance();
    let squared = sigmas * sigmas;
    // One coordinate alone tells most poses apart.
    if (0..TangentOf::<P>::DIMENSION).any(|k| is_beyond(apart.at(k), covariance.get(k, k).at_least(T::ZERO), squared)) {
        return false;
    }
    match covariance.factor() {
        Some(factor) => factor.mahalanobis(&apart) <= squared,
        None => (0..TangentOf::<P>::DIMENSION)
            .all(|k| apart.at(k) * apart.at(k) <= squared * covariance.get(k, k).at_least(T::ZERO)),
    }
}
