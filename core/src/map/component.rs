//! A component of an intensity: a weighted Gaussian, and its Kalman update.

use crate::numerics::range::is_within_range;
use crate::numerics::vector::applied;
use crate::{Factor, Linear, Matrix, Real, Symmetric, Vector, Zero};

/// ln 10⁶, the greatest ln w of a component from outside.
const LN_HEAVIEST: f64 = 13.815_510_557_964_274;

/// A component w N(m, P) of a Gaussian mixture (5.8), with the logarithm of its weight.
///
/// The weight is the expected number of features of the component. The state of a static feature is its position, that of a moving
/// one its position and velocity.
///
/// `T` is always the scalar of `N`: with a projection as the type of a field, the compiler (1.95) fails if a closure uses the
/// rest of a captured component, as in `Component { label, ..known }`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Component<N: Vector, T = <N as Vector>::Scalar> {
    /// Identity of the feature from scan to scan, unique in one map among components of one kind. The label identifies the
    /// measurement from which the feature was born, and is the same in all particles.
    pub label: u32,
    /// ln w.
    pub ln_weight: T,
    /// m: position, m; for a moving feature followed by its velocity, m/s.
    pub mean: N,
    /// P, in the squares of those units.
    pub covariance: Symmetric<N>,
}

impl<T: Real, N: Vector<Scalar = T>> Component<N> {
    /// All zero; a placeholder for unused memory.
    pub const ZERO: Self = Self { label: 0, ln_weight: T::ZERO, mean: N::ZERO, covariance: Symmetric::ZERO };

    /// Whether a component from outside is valid: a finite weight of at most a million features, so that sums of weights stay
    /// finite; a mean within range; and a positive definite covariance.
    pub(crate) fn is_usable(&self) -> bool {
        self.ln_weight.is_finite()
            && self.ln_weight <= T::from_f64(LN_HEAVIEST)
            && is_within_range(&self.mean)
            && self.covariance.factor().is_some()
    }

    /// The position: the first coordinates of the mean.
    #[inline]
    pub fn position<D: Vector<Scalar = T>>(&self) -> D {
        D::with(|row| self.mean.at(row))
    }
}

/// The Kalman correction of one component (5.20–5.22). It does not depend on the value of the measurement, so it is computed once
/// per component and applied to every measurement in its gate.
#[derive(Debug, Clone, Copy)]
pub struct Correction<N: Vector, Z: Vector> {
    /// K.
    gain: Linear<N, Z>,
    /// P⁺, positive definite.
    covariance: Symmetric<N>,
    /// Whether rounding errors had to be repaired to keep the covariance positive definite.
    repaired: bool,
}

impl<T: Real, N: Vector<Scalar = T>, Z: Vector<Scalar = T>> Correction<N, Z> {
    /// K = P Hᵀ S⁻¹ and P⁺ = (I − K H) P (I − K H)ᵀ + K R Kᵀ: the Joseph form, a sum of two positive semidefinite terms for any K,
    /// so that rounding in single precision cannot make P⁺ indefinite as it can (I − K H) P. If the result is out of the range of
    /// the scalar, the correction has no effect.
    ///
    /// `h` applies to the first coordinates; `factor` is that of S = H P Hᵀ + R.
    #[inline]
    pub fn new<D: Vector<Scalar = T>>(
        covariance: &Symmetric<N>,
        h: &Linear<Z, D>,
        r: &Symmetric<Z>,
        factor: &Factor<Z>,
    ) -> Self {
        let cross: Linear<N, Z> = covariance.times_transpose::<D, Z>(h);
        let mut gain = N::Array::<Z>::ZERO;
        for (row, solved) in gain.as_mut().iter_mut().enumerate() {
            *solved = factor.solve(&Z::with(|column| cross.at(row, column)));
        }
        let gain: Linear<N, Z> =
            Matrix::with(|row, column| gain.as_ref().get(row).map_or(T::ZERO, |row| row.at(column)));
        let joseph = covariance.joseph::<D, Z>(&gain, h).plus(&r.congruence::<N>(&gain));
        match joseph.kept_positive_definite() {
            Some((covariance, repaired)) => Self { gain, covariance, repaired },
            None => Self { gain: Zero::ZERO, covariance: *covariance, repaired: true },
        }
    }

    /// The component after the measurement with this innovation z ⊖ ẑ, with the given ln weight.
    #[inline]
    #[must_use]
    pub fn apply(&self, component: &Component<N>, innovation: &Z, ln_weight: T) -> Component<N> {
        let mean = component.mean + applied::<N, Z>(&self.gain, innovation);
        Component { label: component.label, ln_weight, mean, covariance: self.covariance }
    }

    /// Whether the corrected covariance had to be repaired.
    #[inline]
    pub fn repaired(&self) -> bool {
        self.repaired
    }
}
