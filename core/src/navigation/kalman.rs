//! A linear Kalman filter of few states, whose measurements are gated.

use crate::{Component, Correction, Dim, Packed, Real, Symmetric};
use nalgebra::{SMatrix, SVector};

/// What became of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outcome {
    /// It was taken in.
    Accepted,
    /// It lies too far from what was expected, or is not finite; the state is as it was.
    Rejected,
}

/// A Gaussian state N(x, P).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Kalman<T: Real, const N: usize>
where
    Dim<N>: Packed,
{
    pub(super) mean: SVector<T, N>,
    pub(super) covariance: Symmetric<T, N>,
}

impl<T: Real, const N: usize> Kalman<T, N>
where
    Dim<N>: Packed,
{
    /// x ← F x, P ← F P Fᵀ + Q, unless that is beyond the range of the scalar: then the state is as it was.
    pub(super) fn predict(&mut self, transition: &SMatrix<T, N, N>, noise: &Symmetric<T, N>) {
        let mean = transition * self.mean;
        let covariance = self.covariance.congruence(transition).plus(noise);
        if mean.iter().all(|x| x.is_finite()) && covariance.is_finite() {
            *self = Self { mean, covariance };
        }
    }

    /// Takes in z = H x + e, e ~ N(0, R), unless (z − H x)ᵀ S⁻¹ (z − H x) exceeds `gate`.
    pub(super) fn update<const Z: usize>(
        &mut self,
        measured: &SVector<T, Z>,
        h: &SMatrix<T, Z, N>,
        noise: &Symmetric<T, Z>,
        gate: T,
    ) -> Outcome
    where
        Dim<Z>: Packed,
    {
        let innovation = measured - h * self.mean;
        let Some(factor) = self.covariance.congruence(h).plus(noise).factor() else { return Outcome::Rejected };
        // Written so that NaN is rejected too.
        if !(factor.mahalanobis(&innovation) <= gate) {
            return Outcome::Rejected;
        }
        let correction = Correction::new(&self.covariance, h, noise, &factor);
        let prior = Component { tag: 0, ln_weight: T::ZERO, mean: self.mean, covariance: self.covariance };
        let Component { mean, covariance, .. } = correction.apply(&prior, &innovation, T::ZERO);
        *self = Self { mean, covariance };
        Outcome::Accepted
    }
}
