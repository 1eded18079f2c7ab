//! The joint covariance of a pose and its features, as a lower triangle by rows: the pose's coordinates first, then those of
//! one feature after the other.

use crate::numerics::vector::{applied, product};
use crate::{Linear, Matrix, Pose, PositionOf, Real, ScalarOf, Symmetric, TangentOf, Vector, Zero};

/// Numbers in the lower triangle of the joint covariance of a pose of `pose` coordinates and `features` features of `dimension`
/// coordinates each: the `NUMBERS` of a [`JointState`](super::JointState).
///
/// ```
/// // Forty features in the plane: 83 coordinates, 3486 numbers, 14 KB in single precision.
/// assert_eq!(scphd::storage::joint_numbers(3, 2, 40), 3486);
/// ```
#[must_use]
pub const fn joint_numbers(pose: usize, dimension: usize, features: usize) -> usize {
    row_start(pose + dimension * features)
}

/// Where a row of the triangle starts.
const fn row_start(row: usize) -> usize {
    row * (row + 1) / 2
}

/// A joint covariance over borrowed numbers.
#[derive(Debug)]
pub(super) struct Joint<'s, P: Pose> {
    pub(super) numbers: &'s mut [ScalarOf<P>],
}

/// Adds to two rows of the triangle, of the same length, the products of what is weighed for each with what goes with every column.
#[inline]
fn add_columns<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    [of_upper, of_lower]: &[Z; 2],
    common: &Common<'_, P, Z>,
    (upper, lower): (&mut [T], &mut [T]),
) {
    let add = |((upper, lower), of_column): ((&mut T, &mut T), &Z)| {
        // Both before either is written, which for all that the compiler knows could change the column's part.
        let (to_upper, to_lower) = (of_upper.dot(of_column), of_lower.dot(of_column));
        *upper += to_upper;
        *lower += to_lower;
    };
    let of_pose = P::Tangent::DIMENSION.min(upper.len());
    let (pose_upper, upper) = upper.split_at_mut(of_pose);
    let (pose_lower, lower) = lower.split_at_mut(of_pose.min(lower.len()));
    pose_upper.iter_mut().zip(pose_lower).zip(common.pose.as_ref()).for_each(add);
    let whole = upper.len() / P::Position::DIMENSION;
    let (mut upper, mut lower) =
        (upper.chunks_exact_mut(P::Position::DIMENSION), lower.chunks_exact_mut(P::Position::DIMENSION));
    for ((upper, lower), columns) in upper.by_ref().zip(lower.by_ref()).zip(common.features.iter()) {
        upper.iter_mut().zip(lower).zip(columns.as_ref()).for_each(add);
    }
    // Of the rows' own feature, the columns before their own.
    if let Some(columns) = common.features.get(whole) {
        upper.into_remainder().iter_mut().zip(lower.into_remainder()).zip(columns.as_ref()).for_each(add);
    }
}

/// The covariances of a pose and one feature.
pub(super) struct Blocks<P: Pose> {
    /// P_xx.
    pub(super) pose: Linear<TangentOf<P>, TangentOf<P>>,
    /// P_mx.
    pub(super) cross: Linear<PositionOf<P>, TangentOf<P>>,
    /// P_mm.
    pub(super) feature: Linear<PositionOf<P>, PositionOf<P>>,
}

/// P Hᵀ, row by row: what every coordinate has in common with a predicted measurement.
#[derive(Debug)]
pub(super) struct Common<'s, P: Pose, Z: Vector> {
    pub(super) pose: RowsOf<TangentOf<P>, Z>,
    /// The rows of one feature after the other.
    pub(super) features: &'s mut [RowsOf<PositionOf<P>, Z>],
}

/// A row for every coordinate of an `N`.
pub(super) type RowsOf<N, Z> = <N as Vector>::Array<Z>;

impl<'s, P: Pose, Z: Vector> Common<'s, P, Z> {
    /// Nothing yet, over borrowed rows.
    pub(super) fn over(features: &'s mut [RowsOf<PositionOf<P>, Z>]) -> Self {
        Self { pose: Zero::ZERO, features }
    }

    /// The row of every coordinate of the pose and of so many features.
    pub(super) fn fill(&mut self, features: usize, of: impl Fn(usize) -> Z) {
        self.pose.as_mut().iter_mut().enumerate().for_each(|(k, row)| *row = of(k));
        for (feature, rows) in self.features.iter_mut().take(features).enumerate() {
            let first = first::<P>(feature);
            rows.as_mut().iter_mut().enumerate().for_each(|(d, row)| *row = of(first + d));
        }
    }
}

/// The first coordinate of a feature; of one behind so many, how many coordinates there are.
pub(super) const fn first<P: Pose>(feature: usize) -> usize {
    P::Tangent::DIMENSION + P::Position::DIMENSION * feature
}

impl<T: Real, P: Pose<Scalar = T>> Joint<'_, P> {
    /// Coordinates of the pose, and of a feature.
    const K: usize = P::Tangent::DIMENSION;
    const D: usize = P::Position::DIMENSION;

    /// The element of that row and column, in any order.
    pub(super) fn get(&self, row: usize, column: usize) -> T {
        let (row, column) = if row >= column { (row, column) } else { (column, row) };
        self.numbers.get(row_start(row) + column).copied().unwrap_or(T::ZERO)
    }

    /// The covariances of a coordinate with some that follow each other: mostly a piece of one row.
    #[inline]
    fn run<N: Vector<Scalar = T>>(&self, row: usize, column: usize) -> N {
        let start = row_start(row) + column;
        match self.numbers.get(start..start + N::DIMENSION) {
            Some(run) if row + 1 >= column + N::DIMENSION => N::with(|k| run.get(k).copied().unwrap_or(T::ZERO)),
            _ => N::with(|k| self.get(row, column + k)),
        }
    }

    pub(super) fn set(&mut self, row: usize, column: usize, value: T) {
        let (row, column) = if row >= column { (row, column) } else { (column, row) };
        if let Some(slot) = self.numbers.get_mut(row_start(row) + column) {
            *slot = value;
        }
    }

    /// All numbers of so many features.
    pub(super) fn used(&self, features: usize) -> &[T] {
        self.numbers.get(..row_start(first::<P>(features))).unwrap_or(&[])
    }

    /// The same, to be changed.
    pub(super) fn used_mut(&mut self, features: usize) -> &mut [T] {
        self.numbers.get_mut(..row_start(first::<P>(features))).unwrap_or(&mut [])
    }

    /// The pose's own block.
    pub(super) fn pose(&self) -> Linear<P::Tangent, P::Tangent> {
        Matrix::with(|row, column| self.get(row, column))
    }

    /// The covariance of a feature with another, or with itself.
    pub(super) fn between(&self, one: usize, other: usize) -> Linear<P::Position, P::Position> {
        Matrix::with(|row, column| self.get(first::<P>(one) + row, first::<P>(other) + column))
    }

    /// The covariance of a feature with the pose.
    pub(super) fn with_pose(&self, feature: usize) -> Linear<P::Position, P::Tangent> {
        Matrix::with(|row, column| self.get(first::<P>(feature) + row, column))
    }

    /// Those of the pose and a feature.
    pub(super) fn blocks(&self, feature: usize) -> Blocks<P> {
        Blocks { pose: self.pose(), cross: self.with_pose(feature), feature: self.between(feature, feature) }
    }

    /// Takes the pose as certain, without features.
    pub(super) fn clear(&mut self) {
        self.numbers.iter_mut().take(row_start(Self::K)).for_each(|number| *number = T::ZERO);
    }

    /// P_xx ← F P_xx Fᵀ + Q, P_mx ← P_mx Fᵀ, of so many features.
    pub(super) fn propagate(
        &mut self,
        transition: &Linear<P::Tangent, P::Tangent>,
        pose: &Linear<P::Tangent, P::Tangent>,
        features: usize,
    ) {
        for row in 0..Self::K {
            for column in 0..=row {
                self.set(row, column, pose.at(row, column));
            }
        }
        for row in Self::K..first::<P>(features) {
            let start = row_start(row);
            let Some(cross) = self.numbers.get_mut(start..start + Self::K) else { return };
            let before = P::Tangent::with(|k| cross.get(k).copied().unwrap_or(T::ZERO));
            let after = applied::<P::Tangent, P::Tangent>(transition, &before);
            cross.iter_mut().zip(after.as_slice()).for_each(|(slot, &after)| *slot = after);
        }
    }

    /// P Hᵀ for a feature's Hx = ∂h/∂x and Hm = ∂h/∂m, over so many features.
    pub(super) fn common<Y: Vector<Scalar = T>, Z: Vector<Scalar = T>>(
        &self,
        feature: usize,
        by_pose: &Linear<Y, P::Tangent>,
        by_feature: &Linear<Y, P::Position>,
        features: usize,
        into: &mut Common<'_, P, Z>,
    ) {
        let first = first::<P>(feature);
        into.fill(features, |coordinate| {
            let (pose, own) = (self.run::<P::Tangent>(coordinate, 0), self.run::<P::Position>(coordinate, first));
            let of_measurement = applied::<Y, P::Tangent>(by_pose, &pose) + applied::<Y, P::Position>(by_feature, &own);
            Z::with(|z| of_measurement.at(z))
        });
    }

    /// Adds a feature behind so many, independent of everything, and so far without a covariance.
    pub(super) fn put_alone(&mut self, features: usize) {
        let (first, behind) = (first::<P>(features), first::<P>(features + 1));
        for row in first..behind {
            (0..=row).for_each(|column| self.set(row, column, T::ZERO));
        }
    }

    /// Adds a feature behind so many: m = Σ_k G_k s_k of features s_k, by their places, so far without a part of its own.
    pub(super) fn add_of(
        &mut self,
        of: impl Iterator<Item = (usize, Linear<P::Position, P::Position>)> + Clone,
        features: usize,
    ) {
        let first = first::<P>(features);
        for column in 0..first {
            let mut cross = P::Position::ZERO;
            for (index, gain) in of.clone() {
                cross += applied::<P::Position, P::Position>(&gain, &self.run(column, self::first::<P>(index)));
            }
            (0..Self::D).for_each(|d| self.set(first + d, column, cross.at(d)));
        }
        for row in 0..Self::D {
            let mut own = P::Position::ZERO;
            for (index, gain) in of.clone() {
                own += applied::<P::Position, P::Position>(&gain, &self.run(first + row, self::first::<P>(index)));
            }
            (0..=row).for_each(|column| self.set(first + row, first + column, own.at(column)));
        }
    }

    /// Adds to the covariance of a feature with another, or with itself.
    pub(super) fn add_block(&mut self, one: usize, other: usize, of: impl Fn(usize, usize) -> T) {
        let (first_of_one, first_of_other) = (first::<P>(one), first::<P>(other));
        for row in 0..Self::D {
            let columns = if one == other { row + 1 } else { Self::D };
            for column in 0..columns {
                let (at, with) = (first_of_one + row, first_of_other + column);
                self.set(at, with, self.get(at, with) + of(row, column));
            }
        }
    }

    /// Sets the covariance of a feature with another, or with itself.
    pub(super) fn put_block(&mut self, one: usize, other: usize, of: impl Fn(usize, usize) -> T) {
        let (one, other) = (first::<P>(one), first::<P>(other));
        for row in 0..P::Position::DIMENSION {
            (0..P::Position::DIMENSION).for_each(|column| self.set(one + row, other + column, of(row, column)));
        }
    }

    /// P Hᵀ for a measurement of the pose alone.
    pub(super) fn common_with_pose<Y: Vector<Scalar = T>, Z: Vector<Scalar = T>>(
        &self,
        by_pose: &Linear<Y, P::Tangent>,
        features: usize,
        into: &mut Common<'_, P, Z>,
    ) {
        into.fill(features, |coordinate| {
            let of_measurement = applied::<Y, P::Tangent>(by_pose, &self.run(coordinate, 0));
            Z::with(|z| of_measurement.at(z))
        });
    }

    /// Whether P + (P Hᵀ) B (P Hᵀ)ᵀ has variances of the pose that can be. Where rounding has spoilt the covariance they may come out
    /// below zero, and all that follows would be worse.
    pub(super) fn may_add<Z: Vector<Scalar = T>>(&self, pose: &RowsOf<P::Tangent, Z>, by: &Linear<Z, Z>) -> bool {
        pose.as_ref().iter().enumerate().all(|(k, of_row)| {
            let variance = self.get(k, k) + applied::<Z, Z>(by, of_row).dot(of_row);
            variance >= T::ZERO && variance < T::INFINITY
        })
    }

    /// P ← P + (P Hᵀ) B (P Hᵀ)ᵀ over so many features, B symmetric. A variance keeps what rounding may have taken from it: without
    /// that the matrix would lose its definiteness in the course of a hundred thousand updates.
    pub(super) fn add_product<Z: Vector<Scalar = T>>(
        &mut self,
        common: &Common<'_, P, Z>,
        by: &Linear<Z, Z>,
        features: usize,
    ) {
        let rounding = T::ONE + T::EPSILON * T::from_f64(4.0);
        let of_features = common.features.iter().take(features).flat_map(|rows| rows.as_ref());
        let mut rows = common.pose.as_ref().iter().chain(of_features).enumerate();
        // Two rows at a time, so that what goes with a column is fetched once for both; of an odd number, the first one is the shortest.
        if first::<P>(features) % 2 == 1
            && let Some(((_, of_row), variance)) = rows.next().zip(self.numbers.first_mut())
        {
            *variance = (*variance + applied::<Z, Z>(by, of_row).dot(of_row)) * rounding;
        }
        while let Some(((row, of_upper), (_, of_lower))) = rows.next().zip(rows.next()) {
            let numbers = self.numbers.get_mut(row_start(row)..row_start(row + 2));
            let Some((upper, lower)) = numbers.and_then(|numbers| numbers.split_at_mut_checked(row + 1)) else {
                return;
            };
            let weighed = [of_upper, of_lower].map(|of_row| applied::<Z, Z>(by, of_row));
            let Some(before) = lower.get_mut(..=row) else { return };
            add_columns(&weighed, common, (upper, before));
            if let Some(variance) = upper.last_mut() {
                *variance *= rounding;
            }
            if let Some(variance) = lower.last_mut() {
                *variance = (*variance + weighed[1].dot(of_lower)) * rounding;
            }
        }
    }

    /// P ← (I + c eᵀ) P (I + c eᵀ)ᵀ over so many features, with e the direction of the coordinate `heading` and c the `levers` of the
    /// pose's other coordinates (0 of the heading itself) and of each feature's: what an uncertain heading means where things have been moved to.
    pub(super) fn turn(
        &mut self,
        heading: usize,
        (of_pose, of_feature): (&P::Tangent, impl Fn(usize) -> P::Position),
        features: usize,
    ) {
        let variance = self.get(heading, heading);
        let lever = |row: usize| match row.checked_sub(Self::K) {
            None => of_pose.at(row),
            Some(behind) => of_feature(behind / Self::D).at(behind % Self::D),
        };
        for row in (0..first::<P>(features)).filter(|&row| row != heading) {
            let (of_row, with_row) = (lever(row), self.get(row, heading));
            let grown =
                |of_column: T, with_column: T| of_row * (with_column + of_column * variance) + with_row * of_column;
            for column in (0..Self::K.min(row + 1)).filter(|&column| column != heading) {
                let more = grown(of_pose.at(column), self.get(column, heading));
                self.set(row, column, self.get(row, column) + more);
            }
            let Some((before, numbers)) = self.numbers.split_at_mut_checked(row_start(row)) else { return };
            let with_features = numbers.get_mut(Self::K..=row).unwrap_or(&mut []);
            // Where the covariances of the columns' coordinates with the heading are: one a row.
            let (mut index, mut next) = (row_start(Self::K) + heading, Self::K + 1);
            for (feature, numbers) in with_features.chunks_mut(Self::D).enumerate() {
                let of_columns = of_feature(feature);
                for (number, &of_column) in numbers.iter_mut().zip(of_columns.as_slice()) {
                    *number += grown(of_column, before.get(index).copied().unwrap_or(with_row));
                    (index, next) = (index + next, next + 1);
                }
            }
        }
        for row in (0..first::<P>(features)).filter(|&row| row != heading) {
            self.set(row, heading, self.get(row, heading) + lever(row) * variance);
        }
    }

    /// Takes a coordinate of the pose whose variance rounding has made negative, or no number at all, for certain and for
    /// independent of the rest; how many.
    pub(super) fn repair_pose(&mut self, features: usize) -> usize {
        let mut mended = 0;
        for row in 0..Self::K {
            let variance = self.get(row, row);
            if !(variance >= T::ZERO && variance < T::INFINITY) {
                (0..first::<P>(features)).for_each(|column| self.set(row, column, T::ZERO));
                mended += 1;
            }
        }
        mended
    }

    /// Adds a feature behind so many: m = g(x, z) with J = ∂g/∂x, and the covariance `own` that z brings.
    pub(super) fn add(
        &mut self,
        by_pose: &Linear<P::Position, P::Tangent>,
        own: &Linear<P::Position, P::Position>,
        features: usize,
    ) {
        let first = first::<P>(features);
        for column in 0..first {
            let cross = applied::<P::Position, P::Tangent>(by_pose, &self.run(column, 0));
            (0..Self::D).for_each(|d| self.set(first + d, column, cross.at(d)));
        }
        let block = sandwiched::<P::Position, P::Tangent, P::Tangent>(by_pose, &self.pose(), by_pose) + *own;
        for row in 0..Self::D {
            for column in 0..=row {
                self.set(first + row, first + column, block.at(row, column));
            }
        }
    }

    /// Puts the last of so many features in the place of another.
    pub(super) fn replace_by_last(&mut self, feature: usize, features: usize) {
        let last = features.saturating_sub(1);
        if feature >= last {
            return;
        }
        let (to, from) = (first::<P>(feature), first::<P>(last));
        for other in (0..from).filter(|other| !(to..to + Self::D).contains(other)) {
            (0..Self::D).for_each(|d| self.set(to + d, other, self.get(from + d, other)));
        }
        for row in 0..Self::D {
            (0..=row).for_each(|column| self.set(to + row, to + column, self.get(from + row, from + column)));
        }
    }
}

/// A X Bᵀ.
pub(super) fn sandwiched<R, A, B>(a: &Linear<R, A>, x: &Linear<A, B>, b: &Linear<R, B>) -> Linear<R, R>
where
    R: Vector,
    A: Vector<Scalar = R::Scalar>,
    B: Vector<Scalar = R::Scalar>,
{
    product::<R, B, R>(&product::<R, A, B>(a, x), &Matrix::with(|row, column| b.at(column, row)))
}

/// The lower triangle of what is symmetric but for rounding.
pub(super) fn symmetric<N: Vector>(full: &Linear<N, N>) -> Symmetric<N> {
    Symmetric::from_fn(|row, column| (full.at(row, column) + full.at(column, row)) * N::Scalar::from_f64(0.5))
}
