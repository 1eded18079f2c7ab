//! Range of valid numbers.

use crate::{Real, Symmetric, Vector};

/// Greatest valid coordinate, m or rad: more than twice the circumference of the Earth, and small enough that squares and
/// products of squares stay in the range of single precision.
const FARTHEST: f64 = 1e8;

/// Whether every element of a covariance is at most the square of the greatest coordinate.
pub(crate) fn is_within_square<T: Real, K: Vector<Scalar = T>>(covariance: &Symmetric<K>) -> bool {
    let greatest = T::from_f64(FARTHEST * FARTHEST);
    covariance.as_lower().iter().all(|element| element.abs() <= greatest)
}

/// Whether every coordinate is finite and at most the greatest one.
pub(crate) fn is_within_range<T: Real, N: Vector<Scalar = T>>(coordinates: &N) -> bool {
    let farthest = T::from_f64(FARTHEST);
    coordinates.as_slice().iter().all(|coordinate| coordinate.abs() <= farthest)
}
