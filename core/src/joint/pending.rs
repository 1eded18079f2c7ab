//! Corrections of the joint covariance that are not applied yet: P + Σ_t C_t B_t C_tᵀ, with C_t = P Hᵀ.
//!
//! A correction reads few columns of P and changes all of it. Several corrections are therefore applied in one pass,
//! and columns that are read before it are corrected as they are read. The terms of an element are summed before they
//! are added to it, so that it is rounded once for all of them.

use super::covariance::{Joint, RowsOf, first, row_start};
use crate::numerics::vector::applied;
use crate::{Linear, Matrix, Pose, PositionOf, Real, ScalarOf, TangentOf, Vector, Zero};
use core::ops::Range;

/// Maximum number of terms of one pass: a Cortex-M has registers for the weights of four terms for two rows.
pub(super) const TERMS: usize = 4;

/// The rows of C_t for one feature, for every term.
pub type FeatureRows<P, Z> = [RowsOf<PositionOf<P>, Z>; TERMS];

/// A matrix B_t for every term.
pub(super) type EachBy<Z> = [Linear<Z, Z>; TERMS];

/// The pending terms, and the rows of the next one.
#[derive(Debug)]
pub struct Pending<'s, P: Pose, Z: Vector> {
    /// The rows of C_t for the features.
    pub(super) features: &'s mut [FeatureRows<P, Z>],
    /// The rows of C_t for the pose.
    pub(super) pose: [RowsOf<TangentOf<P>, Z>; TERMS],
    /// B_t.
    pub(super) by: EachBy<Z>,
    pub(super) count: usize,
}

impl<'s, T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>> Pending<'s, P, Z> {
    /// No terms, with borrowed memory for the rows of the features.
    pub(super) fn over(features: &'s mut [FeatureRows<P, Z>]) -> Self {
        Self { features, pose: Zero::ZERO, by: [Zero::ZERO; TERMS], count: 0 }
    }

    pub(super) fn is_full(&self) -> bool {
        self.count == TERMS
    }

    /// The rows of the next term for the pose.
    pub(super) fn pose(&self) -> RowsOf<P::Tangent, Z> {
        self.pose.get(self.count).copied().unwrap_or(Zero::ZERO)
    }

    /// The rows of the next term for the features.
    pub(super) fn features(&self) -> impl Iterator<Item = &RowsOf<P::Position, Z>> + Clone {
        self.features.iter().filter_map(|rows| rows.get(self.count))
    }

    /// The rows of the next term for one feature.
    pub(super) fn feature(&self, index: usize) -> Option<&RowsOf<P::Position, Z>> {
        self.features.get(index)?.get(self.count)
    }

    /// Sets the rows of the next term, for the pose and this number of features.
    pub(super) fn fill(&mut self, features: usize, of: impl Fn(usize) -> Z) {
        set_rows(&mut self.pose, self.count, &[], &of);
        for (feature, rows) in self.features.iter_mut().take(features).enumerate() {
            let first = first::<P>(feature);
            set_rows(rows, self.count, &[], |d| of(first + d));
        }
    }

    /// Whether all variances of the pose are valid after the next term, with B = `by`. If rounding errors have made the
    /// covariance invalid, they may become negative, and all later corrections would be wrong.
    pub(super) fn may_push(&self, joint: &Joint<'_, P>, by: &Linear<Z, Z>) -> bool {
        (0..P::Tangent::DIMENSION).all(|k| {
            let by = self.by.iter().take(self.count).chain(core::iter::once(by));
            let variance = by.zip(&self.pose).fold(joint.get(k, k), |variance, (by, rows)| {
                rows.as_ref().get(k).map_or(variance, |row| variance + applied::<Z, Z>(by, row).dot(row))
            });
            variance >= T::ZERO && variance < T::INFINITY
        })
    }

    /// Adds the next term, with a symmetric B = `by`.
    pub(super) fn push(&mut self, by: &Linear<Z, Z>) {
        if let Some(slot) = self.by.get_mut(self.count) {
            *slot = *by;
            self.count += 1;
        }
    }

    /// The rows of the first `N` terms for one coordinate.
    fn rows_of<const N: usize>(&self, coordinate: usize) -> [Z; N] {
        core::array::from_fn(|term| {
            let row = match coordinate.checked_sub(P::Tangent::DIMENSION) {
                None => self.pose.get(term).and_then(|rows| rows.as_ref().get(coordinate)),
                Some(behind) => {
                    let rows = self.features.get(behind / P::Position::DIMENSION).and_then(|rows| rows.get(term));
                    rows.and_then(|rows| rows.as_ref().get(behind % P::Position::DIMENSION))
                }
            };
            row.copied().unwrap_or(Z::ZERO)
        })
    }
}

/// Sets the rows of the term `next`.
#[inline]
pub(super) fn set_rows<Z: Vector, R: AsRef<[Z]> + AsMut<[Z]>>(
    rows: &mut [R; TERMS],
    next: usize,
    gains: &[Linear<Z, Z>],
    of: impl Fn(usize) -> Z,
) {
    let Some((rows, before)) = rows.get_mut(..=next).and_then(|rows| rows.split_last_mut()) else { return };
    for (k, row) in rows.as_mut().iter_mut().enumerate() {
        let parts = gains.iter().zip(&*before).filter_map(|(gain, rows)| rows.as_ref().get(k).map(|row| (gain, row)));
        *row = parts.fold(of(k), |sum, (gain, row)| sum + applied::<Z, Z>(gain, row));
    }
}

/// H times the rows of P Hᵀ for the coordinates that H refers to.
pub(super) fn h_times<Y: Vector, N: Vector<Scalar = Y::Scalar>, Z: Vector<Scalar = Y::Scalar>>(
    h: &Linear<Y, N>,
    rows: &[Z],
) -> Linear<Y, Z> {
    let rows = || rows.iter().take(N::DIMENSION).enumerate();
    Matrix::with(|row, column| rows().fold(Zero::ZERO, |sum, (k, of)| sum + h.at(row, k) * of.at(column)))
}

impl<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>> Pending<'_, P, Z> {
    /// Adds the pending terms to all rows.
    #[inline]
    pub(super) fn add_to_all(&self, numbers: &mut [T], features: usize) {
        match self.count {
            1 => self.add_terms_to_all::<1>(numbers, features),
            2 => self.add_terms_to_all::<2>(numbers, features),
            _ => self.add_terms_to_all::<TERMS>(numbers, features),
        }
    }

    fn add_terms_to_all<const N: usize>(&self, numbers: &mut [T], features: usize) {
        let behind = first::<P>(features);
        if behind % 2 == 1
            && let Some(variance) = numbers.first_mut()
        {
            self.add_to_first::<N>(variance);
        }
        let mut row = behind % 2;
        while row < behind {
            let Some(pair) = numbers.get_mut(row_start(row)..row_start(row + 2)) else { return };
            self.add_to_pair::<N>(row, pair);
            row += 2;
        }
    }

    /// The numbers that one pass changes, in a covariance of this number of features: those of two rows, so that the rows of C_t
    /// for a column are loaded once for both. If the number of rows is odd, the first part is the first row alone, which is the
    /// shortest. `None` behind the last part.
    pub fn part(features: usize, part: usize) -> Option<Range<usize>> {
        let behind = first::<P>(features);
        let (from, to) = ((2 * part).saturating_sub(behind % 2), 2 * part + 2 - behind % 2);
        (to <= behind).then(|| row_start(from)..row_start(to))
    }

    /// Adds the pending terms to the numbers of one part.
    pub fn add_to(&self, features: usize, part: usize, numbers: &mut [T]) {
        match numbers {
            [variance] => match self.count {
                1 => self.add_to_first::<1>(variance),
                2 => self.add_to_first::<2>(variance),
                _ => self.add_to_first::<TERMS>(variance),
            },
            numbers => {
                let row = (2 * part).saturating_sub(first::<P>(features) % 2);
                match self.count {
                    1 => self.add_to_pair::<1>(row, numbers),
                    2 => self.add_to_pair::<2>(row, numbers),
                    _ => self.add_to_pair::<TERMS>(row, numbers),
                }
            }
        }
    }

    #[inline(always)]
    fn weighed<const N: usize>(&self, rows: &[Z; N]) -> [Z; N] {
        let mut parts = self.by.iter().zip(rows);
        core::array::from_fn(|_| parts.next().map_or(Z::ZERO, |(by, row)| applied::<Z, Z>(by, row)))
    }

    /// Adds the first `N` terms to the first row alone.
    #[inline(always)]
    fn add_to_first<const N: usize>(&self, variance: &mut T) {
        let rows = self.rows_of::<N>(0);
        *variance = (*variance + products(&self.weighed(&rows), &rows)) * rounding();
    }

    /// Adds the first `N` terms to two rows.
    #[inline(always)]
    fn add_to_pair<const N: usize>(&self, row: usize, numbers: &mut [T]) {
        let Some((upper, lower)) = numbers.split_at_mut_checked(row + 1) else { return };
        let (of_upper, of_lower) = (self.rows_of::<N>(row), self.rows_of::<N>(row + 1));
        let weights = [self.weighed(&of_upper), self.weighed(&of_lower)];
        let Some(before) = lower.get_mut(..=row) else { return };
        add_columns(&weights, self, (upper, before));
        if let Some(variance) = upper.last_mut() {
            *variance *= rounding();
        }
        if let Some(variance) = lower.last_mut() {
            *variance = (*variance + products(&weights[1], &of_lower)) * rounding();
        }
    }
}

/// The factor of a variance for rounding errors.
#[inline(always)]
fn rounding<T: Real>() -> T {
    T::ONE + T::EPSILON * T::from_f64(4.0)
}

/// Adds to two rows of the triangle, of the same length, the products of their weights with the rows of C_t for every column.
#[inline(always)]
fn add_columns<P: Pose, Z: Vector<Scalar = ScalarOf<P>>, const N: usize>(
    weights: &[[Z; N]; 2],
    pending: &Pending<'_, P, Z>,
    (upper, lower): (&mut [ScalarOf<P>], &mut [ScalarOf<P>]),
) {
    let of_pose = P::Tangent::DIMENSION.min(upper.len());
    let (pose_upper, upper) = upper.split_at_mut(of_pose);
    let (pose_lower, lower) = lower.split_at_mut(of_pose.min(lower.len()));
    add_block(weights, &pending.pose, pose_upper, pose_lower);
    // Two features at a time, which halves the instructions of the loop itself.
    let (pairs, _) = pending.features.as_chunks::<2>();
    let pair = 2 * P::Position::DIMENSION;
    let rest = pending.features.get(upper.len() / pair * 2..).unwrap_or(&[]);
    let (mut upper, mut lower) = (upper.chunks_exact_mut(pair), lower.chunks_exact_mut(pair));
    for ((upper, lower), [one, other]) in upper.by_ref().zip(lower.by_ref()).zip(pairs) {
        let (upper_one, upper_other) = upper.split_at_mut(P::Position::DIMENSION);
        let (lower_one, lower_other) = lower.split_at_mut(P::Position::DIMENSION);
        add_block(weights, one, upper_one, lower_one);
        add_block(weights, other, upper_other, lower_other);
    }
    // The last features, and of the feature to which the rows belong the columns before the diagonal.
    let upper = upper.into_remainder().chunks_mut(P::Position::DIMENSION);
    for ((upper, lower), columns) in upper.zip(lower.into_remainder().chunks_mut(P::Position::DIMENSION)).zip(rest) {
        add_block(weights, columns, upper, lower);
    }
}

/// The part of this for the columns of the pose, or of one feature.
#[inline(always)]
fn add_block<Z: Vector, R: AsRef<[Z]>, const N: usize>(
    [of_upper, of_lower]: &[[Z; N]; 2],
    columns: &[R; TERMS],
    upper: &mut [Z::Scalar],
    lower: &mut [Z::Scalar],
) {
    for (k, (upper, lower)) in upper.iter_mut().zip(lower).enumerate() {
        // Both sums are computed before one is added: otherwise the compiler must assume that this changes the column.
        let (mut to_upper, mut to_lower) = (no_term::<Z>(), no_term::<Z>());
        for ((rows, of_upper), of_lower) in columns.iter().zip(of_upper).zip(of_lower) {
            let Some(of_column) = rows.as_ref().get(k) else { continue };
            to_upper = plus_product(to_upper, of_upper, of_column);
            to_lower = plus_product(to_lower, of_lower, of_column);
        }
        *upper += to_upper;
        *lower += to_lower;
    }
}

/// Σ_t w_tᵀ c_t, one product after the other.
#[inline(always)]
fn products<Z: Vector, const N: usize>(weights: &[Z; N], of_column: &[Z; N]) -> Z::Scalar {
    weights.iter().zip(of_column).fold(no_term::<Z>(), |sum, (weight, of)| plus_product(sum, weight, of))
}

/// The sum, and wᵀ c added to it, one product after the other.
#[inline(always)]
fn plus_product<Z: Vector>(mut sum: Z::Scalar, weight: &Z, of_column: &Z) -> Z::Scalar {
    for (&weight, &of) in weight.as_slice().iter().zip(of_column.as_slice()) {
        sum += weight * of;
    }
    sum
}

/// A sum of no terms: −0, to which a term is added without a change of its bits.
#[inline(always)]
fn no_term<Z: Vector>() -> Z::Scalar {
    -<Z::Scalar as Zero>::ZERO
}
