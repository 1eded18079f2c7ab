//! Symmetric matrices in packed storage, and their square-root-free Cholesky factors.
//!
//! A covariance of dimension N takes N(N+1)/2 scalars: the lower triangle, row after row.

// Every index below is bounded by the dimension or by the length of the triangle. The loops are unrolled and the checks removed;
// iterators would hide the linear algebra.
#![allow(clippy::indexing_slicing)]

use super::triangle::{Triangle, at, element};
use crate::{Linear, Matrix, Real, Vector, Zero};

/// A symmetric matrix in packed storage: the covariance of a `V`.
///
/// ```
/// use nalgebra::Vector2;
/// use scphd::numerics::Symmetric;
///
/// let p = Symmetric::<Vector2<f64>>::from_fn(|row, column| if row == column { 2.0 } else { 0.5 });
/// assert_eq!(p.get(0, 1), p.get(1, 0));
/// let factor = p.factor().unwrap();
/// assert!((factor.ln_determinant() - 3.75_f64.ln()).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Symmetric<V: Vector> {
    lower: V::Lower,
}

impl<T: Real, V: Vector<Scalar = T>> Symmetric<V> {
    /// The zero matrix.
    pub const ZERO: Self = Self { lower: V::Lower::ZERO };

    /// The matrix with elements `element(row, column)`, which is called only with `row` ≥ `column`.
    #[inline]
    pub fn from_fn(element: impl FnMut(usize, usize) -> T) -> Self {
        Self { lower: Triangle::with(element) }
    }

    /// The diagonal matrix of `diagonal`.
    #[inline]
    pub fn from_diagonal(diagonal: V::Array<T>) -> Self {
        Self::from_fn(|row, column| if row == column { element(diagonal.as_ref(), row) } else { T::ZERO })
    }

    /// Element (`row`, `column`); zero outside the matrix.
    #[inline]
    #[must_use]
    pub fn get(&self, row: usize, column: usize) -> T {
        let (row, column) = if row < column { (column, row) } else { (row, column) };
        // The compiler cannot always see that the index is within the triangle; indexing could then panic.
        let element = if row < V::DIMENSION { self.lower.as_ref().get(at(row, column)) } else { None };
        element.copied().unwrap_or(T::ZERO)
    }

    /// The packed lower triangle, row after row.
    #[inline]
    pub fn as_lower(&self) -> &[T] {
        self.lower.as_ref()
    }

    /// The packed lower triangle, mutable.
    #[cfg(any(test, feature = "flips"))]
    pub(crate) fn as_lower_mut(&mut self) -> &mut [T] {
        self.lower.as_mut()
    }

    /// The full matrix.
    #[must_use]
    pub fn to_matrix(&self) -> Linear<V, V> {
        Matrix::with(|row, column| self.get(row, column))
    }

    /// The sum of two matrices.
    #[inline]
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self::from_fn(|row, column| self.get(row, column) + other.get(row, column))
    }

    /// The matrix times a scalar.
    #[inline]
    #[must_use]
    pub fn scaled(&self, factor: T) -> Self {
        Self::from_fn(|row, column| self.get(row, column) * factor)
    }

    /// Adds `weight` v vᵀ.
    #[inline]
    pub fn add_outer(&mut self, weight: T, v: &V) {
        *self = Self::from_fn(|row, column| self.get(row, column) + weight * v.at(row) * v.at(column));
    }

    /// The upper left block of the first coordinates, for example the covariance of the position of a feature.
    #[inline]
    pub fn leading<D: Vector<Scalar = T>>(&self) -> Symmetric<D> {
        Symmetric::from_fn(|row, column| self.get(row, column))
    }

    /// P Hᵀ for a measurement matrix H that applies to the first coordinates.
    #[inline]
    #[must_use]
    pub fn times_transpose<D: Vector<Scalar = T>, Z: Vector<Scalar = T>>(&self, h: &Linear<Z, D>) -> Linear<V, Z> {
        Matrix::with(|row, column| sum(D::DIMENSION, |k| self.get(row, k) * h.at(column, k)))
    }

    /// A P Aᵀ.
    #[inline]
    #[must_use]
    pub fn congruence<M: Vector<Scalar = T>>(&self, a: &Linear<M, V>) -> Symmetric<M> {
        let product: Linear<M, V> =
            Matrix::with(|row, column| sum(V::DIMENSION, |k| a.at(row, k) * self.get(k, column)));
        Symmetric::from_fn(|row, column| sum(V::DIMENSION, |k| product.at(row, k) * a.at(column, k)))
    }

    /// (I − K H) P (I − K H)ᵀ for a measurement matrix H that applies to the first coordinates: the other columns of I − K H are
    /// those of I, and need no multiplication.
    #[inline]
    #[must_use]
    pub(crate) fn joseph<D: Vector<Scalar = T>, Z: Vector<Scalar = T>>(
        &self,
        gain: &Linear<V, Z>,
        h: &Linear<Z, D>,
    ) -> Self {
        let (seen, one) = (D::DIMENSION, T::ONE);
        let residual: Linear<V, D> = Matrix::with(|row, column| {
            let identity = if row == column { one } else { T::ZERO };
            identity - sum(Z::DIMENSION, |k| gain.at(row, k) * h.at(k, column))
        });
        let product: Linear<V, V> = Matrix::with(|row, column| {
            let of_seen = sum(seen, |k| residual.at(row, k) * self.get(k, column));
            if row < seen { of_seen } else { of_seen + self.get(row, column) }
        });
        Self::from_fn(|row, column| {
            let of_seen = sum(seen, |k| product.at(row, k) * residual.at(column, k));
            if column < seen { of_seen } else { of_seen + product.at(row, column) }
        })
    }

    /// Whether all elements are finite.
    pub fn is_finite(&self) -> bool {
        self.lower.as_ref().iter().all(|element| element.is_finite())
    }

    /// The matrix itself if it is positive definite beyond rounding errors; otherwise the matrix with the smallest sufficient
    /// addition to its diagonal, and `true`. For covariances that result from a computation: rounding errors of single precision
    /// can make one with a large condition number indefinite.
    ///
    /// `None` if an element is not finite, or if adding the trace itself is not sufficient.
    #[inline]
    #[must_use]
    pub fn kept_positive_definite(self) -> Option<(Self, bool)> {
        if self.is_beyond_rounding() { Some((self, false)) } else { Some((self.raised()?, true)) }
    }

    /// Whether the matrix is positive definite beyond rounding errors. Not inlined, because it is called from several places and
    /// unrolled.
    #[inline(never)]
    fn is_beyond_rounding(&self) -> bool {
        let least = T::EPSILON * T::from_f64(4.0);
        let above = |(k, &pivot): (usize, &T)| pivot >= least * self.get(k, k);
        self.factor().is_some_and(|factor| factor.pivots.as_ref().iter().enumerate().all(above))
    }

    /// The matrix with the smallest sufficient addition to its diagonal, from a sequence of powers of four.
    #[cold]
    #[inline(never)]
    fn raised(&self) -> Option<Self> {
        let trace = (0..V::DIMENSION).fold(T::ZERO, |sum, k| sum + self.get(k, k).abs());
        let mut raise = trace * T::EPSILON * T::from_f64(4.0);
        // Each iteration adds four times as much, up to the trace itself, which is sufficient for any matrix that is positive
        // semidefinite except for rounding errors: 12 iterations in single precision, 26 in double.
        for _ in 0..26 {
            if !(raise <= trace * T::from_f64(2.0)) {
                break;
            }
            let raised =
                Self::from_fn(|row, column| self.get(row, column) + if row == column { raise } else { T::ZERO });
            if raised.is_beyond_rounding() {
                return Some(raised);
            }
            raise *= T::from_f64(4.0);
        }
        None
    }

    /// A lower triangular A with A Aᵀ = the matrix, which need only be positive semidefinite: coordinates that have no variance of
    /// their own beyond rounding errors get columns of zeros.
    #[must_use]
    pub fn root(&self) -> Linear<V, V> {
        // Row by row.
        let mut root = V::Array::<V>::ZERO;
        let a = root.as_mut();
        for column in 0..V::DIMENSION {
            let pivot =
                (0..column).fold(self.get(column, column), |pivot, k| pivot - a[column].at(k) * a[column].at(k));
            let rounding = T::EPSILON * T::from_f64(16.0) * self.get(column, column);
            // The comparison is written so that NaN gives zeros too.
            if !(pivot > rounding && pivot.is_finite()) {
                continue;
            }
            let on_diagonal = pivot.sqrt();
            a[column].as_mut_slice()[column] = on_diagonal;
            for row in column + 1..V::DIMENSION {
                let rest = (0..column).fold(self.get(row, column), |rest, k| rest - a[row].at(k) * a[column].at(k));
                a[row].as_mut_slice()[column] = rest / on_diagonal;
            }
        }
        Matrix::with(|row, column| a[row].at(column))
    }

    /// The factors L and d of L diag(d) Lᵀ, or `None` unless the matrix is positive definite.
    #[inline]
    pub fn factor(&self) -> Option<Factor<V>> {
        let mut factor = Factor::<V> { lower: self.lower, pivots: V::Array::ZERO };
        let positive = factor.lower.factor(factor.pivots.as_mut());
        positive.then_some(factor)
    }
}

/// The factors of a positive definite matrix S = L diag(d) Lᵀ, L with a unit diagonal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factor<V: Vector> {
    /// The elements of L below its diagonal of ones.
    lower: V::Lower,
    pivots: V::Array<V::Scalar>,
}

impl<T: Real, V: Vector<Scalar = T>> Factor<V> {
    /// L⁻¹ v.
    #[inline]
    fn forward(&self, v: &V) -> V {
        let l = self.lower.as_ref();
        let mut solved = *v;
        let y = solved.as_mut_slice();
        for row in 0..V::DIMENSION {
            for k in 0..row {
                let known = y[k];
                y[row] -= l[at(row, k)] * known;
            }
        }
        solved
    }

    /// vᵀ S⁻¹ v, the squared Mahalanobis distance.
    #[inline]
    #[must_use]
    pub fn mahalanobis(&self, v: &V) -> T {
        let y = self.forward(v);
        let pivots = self.pivots.as_ref();
        (0..V::DIMENSION).fold(T::ZERO, |sum, k| sum + y.at(k) * y.at(k) / pivots[k])
    }

    /// vᵀ S v.
    #[inline]
    #[must_use]
    pub fn quadratic(&self, v: &V) -> T {
        let (l, pivots) = (self.lower.as_ref(), self.pivots.as_ref());
        let along = |k: usize| (k + 1..V::DIMENSION).fold(v.at(k), |sum, row| sum + l[at(row, k)] * v.at(row));
        (0..V::DIMENSION).fold(T::ZERO, |sum, k| sum + pivots[k] * (along(k) * along(k)))
    }

    /// S⁻¹ v.
    #[inline]
    #[must_use]
    pub fn solve(&self, v: &V) -> V {
        let (l, pivots) = (self.lower.as_ref(), self.pivots.as_ref());
        let mut solved = self.forward(v);
        let y = solved.as_mut_slice();
        for row in (0..V::DIMENSION).rev() {
            y[row] /= pivots[row];
            for k in row + 1..V::DIMENSION {
                let known = y[k];
                y[row] -= l[at(k, row)] * known;
            }
        }
        solved
    }

    /// L⁻ᵀ diag(d)^{-½} v: transforms a vector with covariance I to one with covariance S⁻¹.
    #[inline]
    #[must_use]
    pub fn spread_inverse(&self, v: &V) -> V {
        let (l, pivots) = (self.lower.as_ref(), self.pivots.as_ref());
        let mut spread = *v;
        let y = spread.as_mut_slice();
        for row in (0..V::DIMENSION).rev() {
            y[row] /= pivots[row].sqrt();
            for k in row + 1..V::DIMENSION {
                let known = y[k];
                y[row] -= l[at(k, row)] * known;
            }
        }
        spread
    }

    /// S⁻¹.
    #[must_use]
    pub fn inverse(&self) -> Symmetric<V> {
        let mut columns = V::Array::<V>::ZERO;
        for (column, slot) in columns.as_mut().iter_mut().enumerate() {
            *slot = self.solve(&V::with(|row| if row == column { T::ONE } else { T::ZERO }));
        }
        Symmetric::from_fn(|row, column| columns.as_ref()[column].at(row))
    }

    /// The determinant.
    #[inline]
    pub fn determinant(&self) -> T {
        self.pivots.as_ref().iter().fold(T::ONE, |product, &pivot| product * pivot)
    }

    /// ln det S.
    #[inline]
    pub fn ln_determinant(&self) -> T {
        self.determinant().ln()
    }

    /// ln of the greatest value of the Gaussian density with covariance S: −½ ln det(2πS).
    #[inline]
    pub fn ln_peak(&self) -> T {
        let half = T::from_f64(0.5);
        let dimension = T::from_usize(V::DIMENSION);
        -half * (self.ln_determinant() + dimension * T::from_f64(LN_TAU))
    }
}

/// ln 2π.
const LN_TAU: f64 = 1.837_877_066_409_345_3;

/// The sum of a number of terms.
#[inline]
fn sum<T: Real>(terms: usize, term: impl Fn(usize) -> T) -> T {
    (1..terms).fold(term(0), |sum, k| sum + term(k))
}

#[cfg(test)]
mod tests {
    use super::Symmetric;
    use nalgebra::{SMatrix, Vector1, Vector2, Vector3};

    #[test]
    fn peak_is_that_of_the_normal_distribution() {
        let s = Symmetric::<Vector1<f64>>::from_diagonal([0.25]);
        let peak = 1.0 / (0.5 * core::f64::consts::TAU.sqrt());
        assert!((s.factor().unwrap().ln_peak() - peak.ln()).abs() < 1e-15);
    }

    #[test]
    fn products_agree_with_full_matrices() {
        let rows = [[4.0, 0.0, 0.0], [1.0, 3.0, 0.0], [-0.5, 0.2, 2.0]];
        let s = Symmetric::<Vector3<f64>>::from_fn(|r, c| rows[r][c]);
        let h = SMatrix::<f64, 2, 2>::new(1.0, 2.0, -1.0, 0.5);
        let padded = SMatrix::<f64, 2, 3>::new(1.0, 2.0, 0.0, -1.0, 0.5, 0.0);
        let off = s.times_transpose::<Vector2<f64>, Vector2<f64>>(&h) - s.to_matrix() * padded.transpose();
        assert!(off.abs().max() < 1e-14);
        let mut outer = s.leading::<Vector2<f64>>();
        outer.add_outer(0.5, &Vector2::new(2.0, -1.0));
        assert_eq!((outer.get(0, 0), outer.get(1, 0), outer.get(1, 1)), (6.0, 0.0, 3.5));
    }

    #[test]
    fn a_covariance_made_indefinite_by_rounding_is_repaired() {
        // Standard deviations of 1 m and 0.1 mm at 30°, in single precision.
        let (s, c) = (0.5_f32, 0.75_f32.sqrt());
        let flat = Symmetric::<Vector2<f32>>::from_fn(|row, column| match (row, column) {
            (0, 0) => c * c + 1e-8 * s * s,
            (1, 1) => s * s + 1e-8 * c * c,
            _ => s * c,
        });
        let (repaired, changed) = flat.kept_positive_definite().unwrap();
        assert!(changed && repaired.factor().is_some());
        assert!((repaired.get(0, 0) - flat.get(0, 0)).abs() < 1e-4);
        let round = Symmetric::<Vector2<f32>>::from_diagonal([1.0, 0.5]);
        assert_eq!(round.kept_positive_definite(), Some((round, false)));
    }

    #[test]
    fn a_covariance_is_repaired_in_either_precision_or_not_at_all() {
        // Not positive semidefinite by 1e-8: a rounding error of single precision, but a large one in double precision.
        let flat = Symmetric::<Vector2<f64>>::from_fn(|row, column| if row == column { 1.0 } else { 1.0 + 1e-8 });
        let (repaired, changed) = flat.kept_positive_definite().unwrap();
        assert!(changed && repaired.factor().is_some(), "{repaired:?}");
        assert!((repaired.get(0, 0) - 1.0).abs() < 1e-6);
        let indefinite = Symmetric::<Vector2<f64>>::from_fn(|row, column| if row == column { 1.0 } else { 1.9 });
        assert!(indefinite.kept_positive_definite().unwrap().0.factor().is_some());
        let hopeless = Symmetric::<Vector2<f64>>::from_fn(|row, column| if row == column { 1.0 } else { 1e9 });
        assert!(
            hopeless.kept_positive_definite().is_none()
                && Symmetric::<Vector2<f32>>::ZERO.kept_positive_definite().is_none()
        );
        for element in [f32::INFINITY, f32::NAN] {
            assert!(Symmetric::<Vector2<f32>>::from_diagonal([1.0, element]).kept_positive_definite().is_none());
            let crossed = Symmetric::<Vector2<f32>>::from_fn(|r, c| if r == c { 1.0 } else { element });
            assert!(crossed.kept_positive_definite().is_none());
        }
    }

    #[test]
    fn only_positive_definite_matrices_have_factors() {
        assert!(Symmetric::<Vector2<f64>>::from_diagonal([1.0, 0.0]).factor().is_none());
        assert!(Symmetric::<Vector2<f64>>::from_fn(|r, c| if r == c { 1.0 } else { 1.5 }).factor().is_none());
        assert!(Symmetric::<Vector2<f64>>::from_diagonal([1.0, f64::NAN]).factor().is_none());
        assert!(Symmetric::<Vector2<f64>>::from_diagonal([f64::INFINITY, 1.0]).factor().is_none());
        // The variance of a range of 1e-18 m: its reciprocal would be infinite.
        let flat = Symmetric::<Vector2<f32>>::from_diagonal([0.27, 4e-43]);
        assert!(flat.factor().is_none());
        let (repaired, _) = flat.kept_positive_definite().unwrap();
        assert!(repaired.factor().unwrap().inverse().is_finite());
    }
}
