//! One component of an intensity: a weighted Component, and its Kalman update.

use crate::plausible::is_within_range;
use crate::{Dim, Factor, Packed, Real, Symmetric};
use nalgebra::{SMatrix, SVector};

/// ln of a million.
const LN_HEAVIEST: f64 = 13.815_510_557_964_274;

/// A component w N(m, P) of a Gaussian mixture (5.8), with the logarithm of its weight.
///
/// The weight is the expected number of features that the component stands for. A static feature has the state (position)
/// of dimension N = D, a moving one (position, velocity) of dimension N = 2D.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Component<T: Real, const N: usize>
where
    Dim<N>: Packed,
{
    /// Names the feature from scan to scan: no two components of one kind in one map have the same. It tells from which
    /// measurement the feature was born, and is the same in all particles.
    pub tag: u32,
    /// ln w.
    pub ln_weight: T,
    /// m: the position, m; of a moving feature then its velocity, m/s.
    pub mean: SVector<T, N>,
    /// P, in the squares of those units.
    pub covariance: Symmetric<T, N>,
}

impl<T: Real, const N: usize> Component<T, N>
where
    Dim<N>: Packed,
{
    /// All zero; a placeholder for unused memory.
    pub const ZERO: Self = Self {
        tag: 0,
        ln_weight: T::ZERO,
        mean: SVector::from_array_storage(nalgebra::ArrayStorage([[T::ZERO; N]; 1])),
        covariance: Symmetric::ZERO,
    };

    /// Whether it may come from outside: of a finite weight, at most a million features, so that sums of weights stay finite;
    /// within range, and the covariance positive definite.
    pub(crate) fn is_usable(&self) -> bool {
        self.ln_weight.is_finite()
            && self.ln_weight <= T::from_f64(LN_HEAVIEST)
            && is_within_range(&self.mean)
            && self.covariance.factor().is_some()
    }

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
    /// it can in (I − K H) P. Where the range of the scalar leaves nothing of it, the correction corrects nothing.
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
        match joseph.kept_positive_definite() {
            Some((covariance, repaired)) => Self { gain, covariance, repaired },
            None => Self { gain: SMatrix::zeros(), covariance: *covariance, repaired: true },
        }
    }

    /// The component after the measurement with this innovation z ⊖ ẑ, with the given ln weight.
    #[inline]
    #[must_use]
    pub fn apply(&self, component: &Component<T, N>, innovation: &SVector<T, Z>, ln_weight: T) -> Component<T, N> {
        let mean = component.mean + self.gain * innovation;
        Component { tag: component.tag, ln_weight, mean, covariance: self.covariance }
    }

    /// Whether the corrected covariance had to be repaired.
    #[inline]
    #[must_use]
    pub fn repaired(&self) -> bool {
        self.repaired
    }
}
