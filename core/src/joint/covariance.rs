//! The joint covariance of a pose and its features, stored as a lower triangle row by row: first the coordinates of the
//! pose, then those of one feature after the other.

use crate::numerics::vector::{applied, product};
use crate::{Linear, Matrix, Pose, PositionOf, Real, ScalarOf, Symmetric, TangentOf, Vector, Zero};

/// Number of elements in the lower triangle of the joint covariance of a pose with `pose` coordinates and of `features`
/// features with `dimension` coordinates each: the `NUMBERS` of a [`JointState`](super::JointState).
///
/// ```
/// // Forty features in the plane: 83 coordinates, 3486 numbers, 14 KB in single precision.
/// assert_eq!(scphd::storage::joint_numbers(3, 2, 40), 3486);
/// ```
#[must_use]
pub const fn joint_numbers(pose: usize, dimension: usize, features: usize) -> usize {
    row_start(pose + dimension * features)
}

/// Index of the first element of a row of the triangle.
pub(super) const fn row_start(row: usize) -> usize {
    row * (row + 1) / 2
}

/// A joint covariance in borrowed memory.
#[derive(Debug)]
pub(super) struct Joint<'s, P: Pose> {
    pub(super) numbers: &'s mut [ScalarOf<P>],
}

/// The covariances of the pose and one feature.
pub(super) struct Blocks<P: Pose> {
    /// P_xx.
    pub(super) pose: Linear<TangentOf<P>, TangentOf<P>>,
    /// P_mx.
    pub(super) cross: Linear<PositionOf<P>, TangentOf<P>>,
    /// P_mm.
    pub(super) feature: Linear<PositionOf<P>, PositionOf<P>>,
}

/// A row of type `Z` for every coordinate of an `N`.
pub(super) type RowsOf<N, Z> = <N as Vector>::Array<Z>;

/// The first coordinate of a feature; for the number of features, the total number of coordinates.
pub(super) const fn first<P: Pose>(feature: usize) -> usize {
    P::Tangent::DIMENSION + P::Position::DIMENSION * feature
}

/// Of the numbers of a joint covariance, those of so many features.
pub(super) fn used<P: Pose>(numbers: &[ScalarOf<P>], features: usize) -> &[ScalarOf<P>] {
    numbers.get(..row_start(first::<P>(features))).unwrap_or(&[])
}

/// The element of two coordinates, in any order.
pub(super) fn get<T: Real>(numbers: &[T], row: usize, column: usize) -> T {
    let (row, column) = if row >= column { (row, column) } else { (column, row) };
    numbers.get(row_start(row) + column).copied().unwrap_or(T::ZERO)
}

/// The covariances of a coordinate with consecutive other coordinates, in most cases a part of one stored row.
#[inline]
pub(super) fn run<T: Real, N: Vector<Scalar = T>>(numbers: &[T], row: usize, column: usize) -> N {
    let start = row_start(row) + column;
    match numbers.get(start..start + N::DIMENSION) {
        Some(run) if row + 1 >= column + N::DIMENSION => N::with(|k| run.get(k).copied().unwrap_or(T::ZERO)),
        _ => N::with(|k| get(numbers, row, column + k)),
    }
}

impl<T: Real, P: Pose<Scalar = T>> Joint<'_, P> {
    /// Number of coordinates of the pose; `D` is that of a feature.
    const K: usize = P::Tangent::DIMENSION;
    const D: usize = P::Position::DIMENSION;

    /// The element of two coordinates, in any order.
    pub(super) fn get(&self, row: usize, column: usize) -> T {
        get(self.numbers, row, column)
    }

    /// The covariances of a coordinate with consecutive other coordinates.
    #[inline]
    pub(super) fn run<N: Vector<Scalar = T>>(&self, row: usize, column: usize) -> N {
        run(self.numbers, row, column)
    }

    pub(super) fn set(&mut self, row: usize, column: usize, value: T) {
        let (row, column) = if row >= column { (row, column) } else { (column, row) };
        if let Some(slot) = self.numbers.get_mut(row_start(row) + column) {
            *slot = value;
        }
    }

    /// The elements for this number of features.
    pub(super) fn used(&self, features: usize) -> &[T] {
        used::<P>(self.numbers, features)
    }

    /// The same, mutable.
    pub(super) fn used_mut(&mut self, features: usize) -> &mut [T] {
        self.numbers.get_mut(..row_start(first::<P>(features))).unwrap_or(&mut [])
    }

    /// P_xx: the covariance of the pose.
    pub(super) fn pose(&self) -> Linear<P::Tangent, P::Tangent> {
        Matrix::with(|row, column| self.get(row, column))
    }

    /// The covariance of a feature with another one, or with itself.
    pub(super) fn between(&self, one: usize, other: usize) -> Linear<P::Position, P::Position> {
        Matrix::with(|row, column| self.get(first::<P>(one) + row, first::<P>(other) + column))
    }

    /// The covariance of a feature with the pose.
    pub(super) fn with_pose(&self, feature: usize) -> Linear<P::Position, P::Tangent> {
        Matrix::with(|row, column| self.get(first::<P>(feature) + row, column))
    }

    /// The covariances of the pose and a feature.
    pub(super) fn blocks(&self, feature: usize) -> Blocks<P> {
        Blocks { pose: self.pose(), cross: self.with_pose(feature), feature: self.between(feature, feature) }
    }

    /// Sets the covariance of the pose to zero.
    pub(super) fn clear(&mut self) {
        self.numbers.iter_mut().take(row_start(Self::K)).for_each(|number| *number = T::ZERO);
    }

    /// P_xx ← `pose` = F P_xx Fᵀ + Q and P_mx ← P_mx Fᵀ for this number of features, with F = `transition`.
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

    /// Adds a feature behind this number of features, with zero covariance. The caller adds its variance.
    pub(super) fn put_alone(&mut self, features: usize) {
        let (first, behind) = (first::<P>(features), first::<P>(features + 1));
        for row in first..behind {
            (0..=row).for_each(|column| self.set(row, column, T::ZERO));
        }
    }

    /// Adds a feature m = Σ_k G_k s_k behind this number of features. `of` has the indices of the features s_k and
    /// their gains G_k. The caller adds the part of the covariance that is independent of them.
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

    /// Adds to the covariance of a feature with another one, or with itself.
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

    /// Sets the covariance of a feature with another one, or with itself.
    pub(super) fn put_block(&mut self, one: usize, other: usize, of: impl Fn(usize, usize) -> T) {
        let (one, other) = (first::<P>(one), first::<P>(other));
        for row in 0..P::Position::DIMENSION {
            (0..P::Position::DIMENSION).for_each(|column| self.set(one + row, other + column, of(row, column)));
        }
    }

    /// Sets the variance and all covariances of a coordinate of the pose to zero if rounding errors have made its
    /// variance negative or not finite. Returns the number of such coordinates.
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

    /// Adds a feature m = g(x, z) behind this number of features, with J = ∂g/∂x = `by_pose` and the covariance `own`
    /// from the noise of z.
    pub(super) fn add(
        &mut self,
        by_pose: &Linear<P::Position, P::Tangent>,
        own: &Linear<P::Position, P::Position>,
        features: usize,
    ) {
        let first = first::<P>(features);
        let Some((before, rows)) = self.numbers.split_at_mut_checked(row_start(first)) else { return };
        let before = Joint::<P> { numbers: before };
        for column in 0..first {
            let cross = applied::<P::Position, P::Tangent>(by_pose, &before.run(column, 0));
            for (d, &number) in cross.as_slice().iter().enumerate() {
                if let Some(slot) = rows.get_mut(row_start(first + d) - row_start(first) + column) {
                    *slot = number;
                }
            }
        }
        let block = sandwiched::<P::Position, P::Tangent, P::Tangent>(by_pose, &self.pose(), by_pose) + *own;
        for row in 0..Self::D {
            for column in 0..=row {
                self.set(first + row, first + column, block.at(row, column));
            }
        }
    }

    /// Gives the last of this number of features the index of another feature, which is removed.
    pub(super) fn replace_by_last(&mut self, feature: usize, features: usize) {
        let last = features.saturating_sub(1);
        if feature >= last {
            return;
        }
        let (to, from) = (first::<P>(feature), first::<P>(last));
        let Some((before, last)) = self.numbers.split_at_mut_checked(row_start(from)) else { return };
        for d in 0..Self::D {
            let moved = last.get(row_start(from + d) - row_start(from)..).unwrap_or(&[]);
            let row = before.get_mut(row_start(to + d)..).unwrap_or(&mut []);
            row.iter_mut().zip(moved).take(to).for_each(|(slot, &number)| *slot = number);
            // The covariances with the features between the two: one number in each of their rows.
            let mut index = row_start(to + Self::D) + to + d;
            for (other, &number) in moved.iter().enumerate().take(from).skip(to + Self::D) {
                if let Some(slot) = before.get_mut(index) {
                    *slot = number;
                }
                index += other + 1;
            }
        }
        for row in 0..Self::D {
            (0..=row).for_each(|column| self.set(to + row, to + column, self.get(from + row, from + column)));
        }
    }
}

/// A X Bᵀ.
pub(super) fn sandwiched<R: Vector, A: Vector<Scalar = R::Scalar>, B: Vector<Scalar = R::Scalar>>(
    a: &Linear<R, A>,
    x: &Linear<A, B>,
    b: &Linear<R, B>,
) -> Linear<R, R> {
    product::<R, B, R>(&product::<R, A, B>(a, x), &Matrix::with(|row, column| b.at(column, row)))
}

/// The symmetric part of a matrix that is symmetric except for rounding errors.
pub(super) fn symmetric<N: Vector>(full: &Linear<N, N>) -> Symmetric<N> {
    Symmetric::from_fn(|row, column| (full.at(row, column) + full.at(column, row)) * N::Scalar::from_f64(0.5))
}
