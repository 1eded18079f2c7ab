//! Range of valid numbers.

use crate::{Real, Symmetric, Vector};

/// Coordinates beyond this, m or rad, are not taken for a place: over twice around the Earth, and squares and their products
/// stay in the range of single precision.
const FARTHEST: f64 = 1e8;

/// Whether no covariance of a pose is beyond the square of what is taken for a place.
pub(crate) fn is_within_square<T: Real, K: Vector<Scalar = T>>(covariance: &Symmetric<K>) -> bool {
    let greatest = T::from_f64(FARTHEST * FARTHEST);
    covariance.as_lower().iter().all(|element| element.abs() <= greatest)
}

/// Whether every coordinate is one that the recursion can work with.
pub(crate) fn is_within_range<T: Real, N: Vector<Scalar = T>>(coordinates: &N) -> bool {
    let farthest = T::from_f64(FARTHEST);
    coordinates.as_slice().iter().all(|coordinate| coordinate.abs() <= farthest)
}
