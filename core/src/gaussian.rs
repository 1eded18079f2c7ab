//! One component of an intensity: a weighted Gaussian, and its Kalman update.

use crate::{Dim, Factor, Packed, Real, Symmetric};
use nalgebra::{SMatrix, SVector};

/// A component w N(m, P) of a Gaussian mixture (5.8), with the logarithm of its weight.
///
/// The weight is the expected number of features that the component stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaussian<T: Real, const N: usize>
where
    Dim<N>: Packed,
{
    /// ln w.
    pub ln_weight: T,
    /// m: of a static feature its position, m.
    pub mean: SVector<T, N>,
    /// P: of a static feature, m².
    pub covariance: Symmetric<T, N>,
}

impl<T: Real, const N: usize> Gaussian<T, N>
where
    Dim<N>: Packed,
{
    /// All zero; a placeholder for unused memory.
    pub const ZERO: Self = Self {
        ln_weight: T::ZERO,
        mean: SVector::from_array_storage(nalgebra::ArrayStorage([[T::ZERO; N]; 1])),
        covariance: Symmetric::ZERO,
    };

    /// The position: the first D coordinates of the mean.
    #[inline]
    #[must_use]
    pub fn position<const D: usize>(&self) -> SVector<T, D> {
        SVector::from_fn(|row, _| self.mean.get(row).copied().unwrap_or(T::ZERO))
    }
}

/// The Kalman correction of one component (5.20–5.22). It does not hang on the measurement's value, so it is
/// computed once per component and applied to every measurement that meets it.
#[derive(Debug, Clone, Copy)]
pub struct Correction<T: Real, const N: usize, const Z: usize>
where
    Dim<N>: Packed,
{
    /// K, N × Z.
    gain: SMatrix<T, N, Z>,
    /// P⁺, positive definite.
    covariance: Symmetric<T, N>,
    /// Whether rounding had to be repaired to keep it so.
    repaired: bool,
}

impl<T: Real, const N: usize, const Z: usize> Correction<T, N, Z>
where
    Dim<N>: Packed,
    Dim<Z>: Packed,
{
    /// K = P Hᵀ S⁻¹ and P⁺ = (I − K H) P (I − K H)ᵀ + K R Kᵀ: the Joseph form, a sum of two positive
    /// semidefinite terms whatever K is, so that rounding in single precision cannot turn P⁺ indefinite the way
    /// it can in (I − K H) P.
    ///
    /// `h` is Z × D and sees the first D coordinates; `factor` is that of S = H P Hᵀ + R.
    #[inline]
    #[must_use]
    pub fn new<const D: usize>(
        covariance: &Symmetric<T, N>,
        h: &SMatrix<T, Z, D>,
        r: &Symmetric<T, Z>,
        factor: &Factor<T, Z>,
    ) -> Self {
        let cross = covariance.times_transpose(h);
        let mut gain = SMatrix::<T, N, Z>::zeros();
        for (mut row, cross_row) in gain.row_iter_mut().zip(cross.row_iter()) {
            row.copy_from(&factor.solve(&cross_row.transpose()).transpose());
        }
        let residual = SMatrix::<T, N, N>::from_fn(|row, column| {
            let identity = if row == column { T::ONE } else { T::ZERO };
            let seen = if column < D {
                gain.row(row).iter().zip(h.column(column).iter()).fold(T::ZERO, |sum, (&k, &h)| sum + k * h)
            } else {
                T::ZERO
            };
            identity - seen
        });
        let joseph = covariance.congruence(&residual).plus(&r.congruence(&gain));
        let (covariance, repaired) = joseph.kept_positive_definite();
        Self { gain, covariance, repaired }
    }

    /// The component after the measurement with this innovation z ⊖ ẑ, with the given ln weight.
    #[inline]
    #[must_use]
    pub fn apply(&self, mean: &SVector<T, N>, innovation: &SVector<T, Z>, ln_weight: T) -> Gaussian<T, N> {
        Gaussian { ln_weight, mean: mean + self.gain * innovation, covariance: self.covariance }
    }

    /// Whether the corrected covariance had to be repaired.
    #[inline]
    #[must_use]
    pub fn repaired(&self) -> bool {
        self.repaired
    }
}
