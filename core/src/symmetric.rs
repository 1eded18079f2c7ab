//! Symmetric matrices in packed storage, and their square-root-free Cholesky factors.
//!
//! A covariance of dimension N takes N(N+1)/2 scalars: the lower triangle, row after row.

// Every index below is a pair bounded by the constant N, or by the packed length that `Packed` ties to it. The
// loops unroll and the checks vanish; iterators would hide the linear algebra.
#![allow(clippy::indexing_slicing)]

use crate::Real;
use core::fmt::Debug;
use nalgebra::{SMatrix, SVector};

mod sealed {
    pub trait Sealed {}
}

/// A dimension, as a type: carries the packed storage of symmetric matrices of that dimension.
#[derive(Debug, Clone, Copy)]
pub struct Dim<const N: usize>;

/// Dimensions that have packed storage: [`Dim<1>`] to [`Dim<6>`].
pub trait Packed: sealed::Sealed {
    /// The lower triangle, row after row: N(N+1)/2 scalars.
    type Lower<T: Real>: Lower<T>;
}

/// The dimension of a moving feature's state (position, velocity), E = 2D, of one whose position has the dimension D.
pub trait Twice<const E: usize>: sealed::Sealed {}

impl Twice<2> for Dim<1> {}
impl Twice<4> for Dim<2> {}
impl Twice<6> for Dim<3> {}

/// Array that holds a lower triangle.
pub trait Lower<T>: sealed::Sealed + Copy + PartialEq + Debug + Send + Sync + AsRef<[T]> + AsMut<[T]> {
    /// All zero.
    const ZERO: Self;
}

impl<T: Real, const L: usize> sealed::Sealed for [T; L] {}
impl<T: Real, const L: usize> Lower<T> for [T; L] {
    const ZERO: Self = [T::ZERO; L];
}

macro_rules! implement_packed {
    ($($n:literal: $length:literal),*) => {$(
        impl sealed::Sealed for Dim<$n> {}
        impl Packed for Dim<$n> {
            type Lower<T: Real> = [T; $length];
        }
    )*};
}
implement_packed!(1: 1, 2: 3, 3: 6, 4: 10, 5: 15, 6: 21);

/// Position of element (`row`, `column`), `row` ≥ `column`, in the packed lower triangle.
const fn at(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
}

/// A symmetric N × N matrix in packed storage, such as a covariance.
///
/// ```
/// use scphd::Symmetric;
///
/// let p = Symmetric::<f64, 2>::from_fn(|row, column| if row == column { 2.0 } else { 0.5 });
/// assert_eq!(p.get(0, 1), p.get(1, 0));
/// let factor = p.factor().unwrap();
/// assert!((factor.ln_determinant() - 3.75_f64.ln()).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Symmetric<T: Real, const N: usize>
where
    Dim<N>: Packed,
{
    lower: <Dim<N> as Packed>::Lower<T>,
}

impl<T: Real, const N: usize> Symmetric<T, N>
where
    Dim<N>: Packed,
{
    /// The zero matrix.
    pub const ZERO: Self = Self { lower: <<Dim<N> as Packed>::Lower<T> as Lower<T>>::ZERO };

    /// The matrix with elements `element(row, column)`, asked for `row` ≥ `column` only.
    #[inline]
    #[must_use]
    pub fn from_fn(mut element: impl FnMut(usize, usize) -> T) -> Self {
        let mut result = Self::ZERO;
        // Row by row, each with a number that the compiler knows: two nested loops would not be unrolled.
        result.fill_row::<0>(&mut element);
        result.fill_row::<1>(&mut element);
        result.fill_row::<2>(&mut element);
        result.fill_row::<3>(&mut element);
        result.fill_row::<4>(&mut element);
        result.fill_row::<5>(&mut element);
        result
    }

    /// Sets one row, if there is such.
    #[inline(always)]
    fn fill_row<const ROW: usize>(&mut self, mut element: impl FnMut(usize, usize) -> T) {
        if ROW < N {
            for column in 0..=ROW {
                let element = element(ROW, column);
                if let Some(slot) = self.lower.as_mut().get_mut(at(ROW, column)) {
                    *slot = element;
                }
            }
        }
    }

    /// The diagonal matrix of `diagonal`.
    #[inline]
    #[must_use]
    pub fn from_diagonal(diagonal: [T; N]) -> Self {
        Self::from_fn(|row, column| if row == column { diagonal[row] } else { T::ZERO })
    }

    /// Element (`row`, `column`); zero outside the matrix.
    #[inline]
    #[must_use]
    pub fn get(&self, row: usize, column: usize) -> T {
        let (row, column) = if row < column { (column, row) } else { (row, column) };
        if row < N { self.lower.as_ref()[at(row, column)] } else { T::ZERO }
    }

    /// The packed lower triangle, row after row.
    #[inline]
    #[must_use]
    pub fn as_lower(&self) -> &[T] {
        self.lower.as_ref()
    }

    /// All N² elements.
    #[must_use]
    pub fn to_matrix(&self) -> SMatrix<T, N, N> {
        SMatrix::from_fn(|row, column| self.get(row, column))
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
    pub fn add_outer(&mut self, weight: T, v: &SVector<T, N>) {
        *self = Self::from_fn(|row, column| self.get(row, column) + weight * v[row] * v[column]);
    }

    /// The upper left D × D block, D ≤ N: of a feature's covariance, that of its position.
    #[inline]
    #[must_use]
    pub fn leading<const D: usize>(&self) -> Symmetric<T, D>
    where
        Dim<D>: Packed,
    {
        Symmetric::from_fn(|row, column| self.get(row, column))
    }

    /// P Hᵀ for a measurement matrix H that sees the first D ≤ N coordinates: N × Z.
    #[inline]
    #[must_use]
    pub fn times_transpose<const D: usize, const Z: usize>(&self, h: &SMatrix<T, Z, D>) -> SMatrix<T, N, Z> {
        SMatrix::from_fn(|row, column| (0..D).fold(T::ZERO, |sum, k| sum + self.get(row, k) * h[(column, k)]))
    }

    /// A P Aᵀ: M × M.
    #[inline]
    #[must_use]
    pub fn congruence<const M: usize>(&self, a: &SMatrix<T, M, N>) -> Symmetric<T, M>
    where
        Dim<M>: Packed,
    {
        let product: SMatrix<T, M, N> =
            SMatrix::from_fn(|row, column| (0..N).fold(T::ZERO, |sum, k| sum + a[(row, k)] * self.get(k, column)));
        Symmetric::from_fn(|row, column| (0..N).fold(T::ZERO, |sum, k| sum + product[(row, k)] * a[(column, k)]))
    }

    /// All elements finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.lower.as_ref().iter().all(|element| element.is_finite())
    }

    /// The matrix itself where it is positive definite beyond rounding; otherwise with as little added to its diagonal
    /// as makes it so, and `true`. To be used where a covariance comes out of a computation: one that is much longer
    /// than wide does not survive rounding in single precision.
    ///
    /// `None` where an element is not finite, or where adding the trace itself does not help.
    #[inline]
    #[must_use]
    pub fn kept_positive_definite(self) -> Option<(Self, bool)> {
        if self.is_beyond_rounding() { Some((self, false)) } else { Some((self.raised()?, true)) }
    }

    /// Whether rounding leaves it positive definite. Asked for in many places, and unrolled in one.
    #[inline(never)]
    fn is_beyond_rounding(&self) -> bool {
        let least = T::EPSILON * T::from_f64(4.0);
        let above = |(k, &pivot): (usize, &T)| pivot >= least * self.get(k, k);
        self.factor().is_some_and(|factor| factor.pivots.iter().enumerate().all(above))
    }

    /// With as little added to its diagonal as makes it positive definite.
    #[cold]
    #[inline(never)]
    fn raised(&self) -> Option<Self> {
        let trace = (0..N).fold(T::ZERO, |sum, k| sum + self.get(k, k).abs());
        let mut raise = trace * T::EPSILON * T::from_f64(4.0);
        // Each round adds four times as much, up to the trace itself, which is enough for any matrix that was positive
        // semidefinite but for rounding: 12 rounds in single precision, 26 in double.
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

    /// A lower triangular A with A Aᵀ = the matrix, which need only be positive semidefinite: coordinates without variance
    /// of their own beyond rounding get columns of zeros.
    #[must_use]
    pub fn root(&self) -> SMatrix<T, N, N> {
        let mut a = SMatrix::<T, N, N>::zeros();
        for column in 0..N {
            let pivot = (0..column).fold(self.get(column, column), |pivot, k| pivot - a[(column, k)] * a[(column, k)]);
            let rounding = T::EPSILON * T::from_f64(16.0) * self.get(column, column);
            // Written so that NaN gives zeros too.
            if !(pivot > rounding && pivot.is_finite()) {
                continue;
            }
            let root = pivot.sqrt();
            a[(column, column)] = root;
            for row in column + 1..N {
                let rest = (0..column).fold(self.get(row, column), |rest, k| rest - a[(row, k)] * a[(column, k)]);
                a[(row, column)] = rest / root;
            }
        }
        a
    }

    /// The factors L and d of L diag(d) Lᵀ, or `None` unless the matrix is positive definite.
    #[inline]
    #[must_use]
    pub fn factor(&self) -> Option<Factor<T, N>> {
        let mut factor = Factor { lower: self.lower, pivots: [T::ZERO; N] };
        // Column by column, each with a number that the compiler knows: a loop over them would not be unrolled.
        let positive = factor.eliminate::<0>()
            && factor.eliminate::<1>()
            && factor.eliminate::<2>()
            && factor.eliminate::<3>()
            && factor.eliminate::<4>()
            && factor.eliminate::<5>();
        positive.then_some(factor)
    }
}

/// The factors of a positive definite matrix S = L diag(d) Lᵀ, L with a unit diagonal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factor<T: Real, const N: usize>
where
    Dim<N>: Packed,
{
    /// Below the diagonal: L. The diagonal is implied.
    lower: <Dim<N> as Packed>::Lower<T>,
    pivots: [T; N],
}

impl<T: Real, const N: usize> Factor<T, N>
where
    Dim<N>: Packed,
{
    /// The pivot of a column and what is below it, from the columns before it; `false` where the pivot is not positive.
    #[inline(always)]
    fn eliminate<const COLUMN: usize>(&mut self) -> bool {
        if COLUMN >= N {
            return true;
        }
        let l = self.lower.as_mut();
        let mut pivot = element(l, at(COLUMN, COLUMN));
        let mut scaled = [T::ZERO; COLUMN];
        for (k, (scaled, &earlier)) in scaled.iter_mut().zip(&self.pivots).enumerate() {
            *scaled = element(l, at(COLUMN, k)) * earlier;
            pivot -= element(l, at(COLUMN, k)) * *scaled;
        }
        // Written so that NaN fails too. Below the least normal number the reciprocal is beyond the range.
        if !(pivot >= T::LEAST_NORMAL && pivot < T::INFINITY) {
            return false;
        }
        if let Some(slot) = self.pivots.get_mut(COLUMN) {
            *slot = pivot;
        }
        let per_pivot = T::ONE / pivot;
        for row in COLUMN + 1..N {
            let start = element(l, at(row, COLUMN));
            let product = (0..COLUMN).zip(scaled).fold(start, |sum, (k, scaled)| sum - element(l, at(row, k)) * scaled);
            if let Some(slot) = l.get_mut(at(row, COLUMN)) {
                *slot = product * per_pivot;
            }
        }
        true
    }

    /// L⁻¹ v.
    #[inline]
    fn forward(&self, v: &SVector<T, N>) -> SVector<T, N> {
        let l = self.lower.as_ref();
        let mut y = *v;
        for row in 0..N {
            for k in 0..row {
                let known = y[k];
                y[row] -= l[at(row, k)] * known;
            }
        }
        y
    }

    /// vᵀ S⁻¹ v, the squared Mahalanobis distance.
    #[inline]
    #[must_use]
    pub fn mahalanobis(&self, v: &SVector<T, N>) -> T {
        let y = self.forward(v);
        (0..N).fold(T::ZERO, |sum, k| sum + y[k] * y[k] / self.pivots[k])
    }

    /// S⁻¹ v.
    #[inline]
    #[must_use]
    pub fn solve(&self, v: &SVector<T, N>) -> SVector<T, N> {
        let l = self.lower.as_ref();
        let mut y = self.forward(v);
        for row in (0..N).rev() {
            y[row] /= self.pivots[row];
            for k in row + 1..N {
                let known = y[k];
                y[row] -= l[at(k, row)] * known;
            }
        }
        y
    }

    /// L⁻ᵀ diag(d)^{-½} v: of a vector of covariance I, one of covariance S⁻¹.
    #[inline]
    #[must_use]
    pub fn spread_inverse(&self, v: &SVector<T, N>) -> SVector<T, N> {
        let l = self.lower.as_ref();
        let mut y = *v;
        for row in (0..N).rev() {
            y[row] /= self.pivots[row].sqrt();
            for k in row + 1..N {
                let known = y[k];
                y[row] -= l[at(k, row)] * known;
            }
        }
        y
    }

    /// S⁻¹.
    #[must_use]
    pub fn inverse(&self) -> Symmetric<T, N> {
        let mut full = SMatrix::<T, N, N>::zeros();
        for column in 0..N {
            let mut unit = SVector::<T, N>::zeros();
            unit[column] = T::ONE;
            full.set_column(column, &self.solve(&unit));
        }
        Symmetric::from_fn(|row, column| full[(row, column)])
    }

    /// The determinant.
    #[inline]
    #[must_use]
    pub fn determinant(&self) -> T {
        self.pivots.iter().fold(T::ONE, |product, &pivot| product * pivot)
    }

    /// ln det S.
    #[inline]
    #[must_use]
    pub fn ln_determinant(&self) -> T {
        self.determinant().ln()
    }

    /// ln of the greatest value of the Gaussian density with covariance S: −½ ln det(2πS).
    #[inline]
    #[must_use]
    pub fn ln_peak(&self) -> T {
        let half = T::from_f64(0.5);
        let dimension = T::from_usize(N);
        -half * (self.ln_determinant() + dimension * T::from_f64(LN_TAU))
    }
}

/// ln 2π.
const LN_TAU: f64 = 1.837_877_066_409_345_3;

/// The element at a place of the packed triangle; the loops over a generic dimension stay inside it, which the compiler
/// cannot always see.
#[inline]
fn element<T: Real>(lower: &[T], place: usize) -> T {
    lower.get(place).copied().unwrap_or(T::ZERO)
}

#[cfg(test)]
mod tests {
    use super::Symmetric;
    use nalgebra::{SMatrix, Vector2, Vector3};

    fn example() -> Symmetric<f64, 3> {
        let rows = [[4.0, 0.0, 0.0], [1.0, 3.0, 0.0], [-0.5, 0.2, 2.0]];
        Symmetric::from_fn(|r, c| rows[r][c])
    }

    #[test]
    fn factor_solves_and_measures() {
        let s = example();
        let full = s.to_matrix();
        let factor = s.factor().unwrap();
        let v = Vector3::new(1.0, -2.0, 0.5);
        let x = factor.solve(&v);
        assert!((full * x - v).abs().max() < 1e-14);
        assert!((factor.mahalanobis(&v) - v.dot(&x)).abs() < 1e-14);
        // By cofactors: 4 (3·2 − 0.2²) − 1 (1·2 − 0.2·(−0.5)) + (−0.5)(1·0.2 − 3·(−0.5)).
        let determinant: f64 = 4.0 * (6.0 - 0.04) - (2.0 + 0.1) - 0.5 * (0.2 + 1.5);
        assert!((factor.ln_determinant() - determinant.ln()).abs() < 1e-14);
    }

    #[test]
    fn peak_is_that_of_the_normal_density() {
        let s = Symmetric::<f64, 1>::from_diagonal([0.25]);
        let peak = 1.0 / (0.5 * core::f64::consts::TAU.sqrt());
        assert!((s.factor().unwrap().ln_peak() - peak.ln()).abs() < 1e-15);
    }

    #[test]
    fn products_agree_with_full_matrices() {
        let s = example();
        let a = SMatrix::<f64, 2, 3>::new(1.0, 2.0, -1.0, 0.5, 0.0, 3.0);
        let direct = a * s.to_matrix() * a.transpose();
        assert!((s.congruence(&a).to_matrix() - direct).abs().max() < 1e-14);
        let h = SMatrix::<f64, 2, 2>::new(1.0, 2.0, -1.0, 0.5);
        let padded = SMatrix::<f64, 2, 3>::new(1.0, 2.0, 0.0, -1.0, 0.5, 0.0);
        assert!((s.times_transpose(&h) - s.to_matrix() * padded.transpose()).abs().max() < 1e-14);
        let mut outer = s.leading::<2>();
        outer.add_outer(0.5, &Vector2::new(2.0, -1.0));
        assert_eq!((outer.get(0, 0), outer.get(1, 0), outer.get(1, 1)), (6.0, 0.0, 3.5));
    }

    #[test]
    fn a_covariance_that_rounding_flattened_is_repaired() {
        // One metre long and 0.1 mm wide at 30°, in single precision.
        let (s, c) = (0.5_f32, 0.75_f32.sqrt());
        let flat = Symmetric::<f32, 2>::from_fn(|row, column| match (row, column) {
            (0, 0) => c * c + 1e-8 * s * s,
            (1, 1) => s * s + 1e-8 * c * c,
            _ => s * c,
        });
        let (repaired, changed) = flat.kept_positive_definite().unwrap();
        assert!(changed && repaired.factor().is_some());
        assert!((repaired.get(0, 0) - flat.get(0, 0)).abs() < 1e-4);
        let round = Symmetric::<f32, 2>::from_diagonal([1.0, 0.5]);
        assert_eq!(round.kept_positive_definite(), Some((round, false)));
    }

    #[test]
    fn a_covariance_is_repaired_in_either_precision_or_not_at_all() {
        // Not positive semidefinite by 1e-8: rounding of single precision, left in double.
        let flat = Symmetric::<f64, 2>::from_fn(|row, column| if row == column { 1.0 } else { 1.0 + 1e-8 });
        let (repaired, changed) = flat.kept_positive_definite().unwrap();
        assert!(changed && repaired.factor().is_some(), "{repaired:?}");
        assert!((repaired.get(0, 0) - 1.0).abs() < 1e-6);
        let indefinite = Symmetric::<f64, 2>::from_fn(|row, column| if row == column { 1.0 } else { 1.9 });
        assert!(indefinite.kept_positive_definite().unwrap().0.factor().is_some());
        let hopeless = Symmetric::<f64, 2>::from_fn(|row, column| if row == column { 1.0 } else { 1e9 });
        assert!(
            hopeless.kept_positive_definite().is_none() && Symmetric::<f32, 2>::ZERO.kept_positive_definite().is_none()
        );
        for element in [f32::INFINITY, f32::NAN] {
            assert!(Symmetric::from_diagonal([1.0, element]).kept_positive_definite().is_none());
            let crossed = Symmetric::<f32, 2>::from_fn(|r, c| if r == c { 1.0 } else { element });
            assert!(crossed.kept_positive_definite().is_none());
        }
    }

    #[test]
    fn only_positive_definite_matrices_have_factors() {
        assert!(Symmetric::<f64, 2>::from_diagonal([1.0, 0.0]).factor().is_none());
        assert!(Symmetric::<f64, 2>::from_fn(|r, c| if r == c { 1.0 } else { 1.5 }).factor().is_none());
        assert!(Symmetric::<f64, 2>::from_diagonal([1.0, f64::NAN]).factor().is_none());
        assert!(Symmetric::<f64, 2>::from_diagonal([f64::INFINITY, 1.0]).factor().is_none());
        // What a range of 1e-18 m leaves of a variance: its reciprocal would be infinite.
        let flat = Symmetric::<f32, 2>::from_diagonal([0.27, 4e-43]);
        assert!(flat.factor().is_none());
        let (repaired, _) = flat.kept_positive_definite().unwrap();
        assert!(repaired.factor().unwrap().inverse().is_finite());
    }
}
