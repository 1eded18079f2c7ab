//! A linear Kalman filter with few states and gated measurements.

use crate::numerics::vector::applied;
use crate::{Component, Correction, Linear, Real, Symmetric, Vector};

/// Result of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outcome {
    /// The measurement was used.
    Accepted,
    /// The measurement is beyond its gate or not finite; the state is unchanged.
    Rejected,
}

/// A Gaussian state N(x, P).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Kalman<N: Vector> {
    pub(super) mean: N,
    pub(super) covariance: Symmetric<N>,
}

impl<T: Real, N: Vector<Scalar = T>> Kalman<N> {
    /// x ← F x, P ← F P Fᵀ + Q; the state is unchanged if the result is beyond the range of the scalar.
    pub(super) fn predict(&mut self, transition: &Linear<N, N>, noise: &Symmetric<N>) {
        let mean = applied::<N, N>(transition, &self.mean);
        let covariance = self.covariance.congruence::<N>(transition).plus(noise);
        if mean.as_slice().iter().all(|x| x.is_finite()) && covariance.is_finite() {
            *self = Self { mean, covariance };
        }
    }

    /// Updates with z = H x + e, e ~ N(0, R), unless (z − H x)ᵀ S⁻¹ (z − H x) exceeds `gate`.
    pub(super) fn update<Z: Vector<Scalar = T>>(
        &mut self,
        measured: &Z,
        h: &Linear<Z, N>,
        noise: &Symmetric<Z>,
        gate: T,
    ) -> Outcome {
        let innovation = *measured - applied::<Z, N>(h, &self.mean);
        let Some(factor) = self.covariance.congruence::<Z>(h).plus(noise).factor() else { return Outcome::Rejected };
        // The comparison is written so that NaN is rejected.
        if !(factor.mahalanobis(&innovation) <= gate) {
            return Outcome::Rejected;
        }
        let correction = Correction::<N, Z>::new::<N>(&self.covariance, h, noise, &factor);
        let prior = Component { label: 0, ln_weight: T::ZERO, mean: self.mean, covariance: self.covariance };
        let Component { mean, covariance, .. } = correction.apply(&prior, &innovation, T::ZERO);
        *self = Self { mean, covariance };
        Outcome::Accepted
    }
}
