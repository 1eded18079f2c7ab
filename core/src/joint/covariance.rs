//! The joint covariance of a pose and its features, as a lower triangle by rows: the pose's coordinates first, then those of
//! one feature after the other.

use crate::{Dim, Packed, Real, Symmetric};
use nalgebra::{SMatrix, SVector};

/// Numbers in the lower triangle of the joint covariance of a pose of `pose` coordinates and `features` features of `dimension`
/// coordinates each: the `NUMBERS` of a [`JointState`](super::JointState).
///
/// ```
/// // Forty features in the plane: 83 coordinates, 3486 numbers, 14 KB in single precision.
/// assert_eq!(scphd::joint_numbers(3, 2, 40), 3486);
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
pub(super) struct Joint<'s, T, const K: usize, const D: usize> {
    pub(super) numbers: &'s mut [T],
}

/// The covariances of a pose and one feature.
pub(super) struct Blocks<T: Real, const K: usize, const D: usize> {
    /// P_xx.
    pub(super) pose: SMatrix<T, K, K>,
    /// P_mx.
    pub(super) cross: SMatrix<T, D, K>,
    /// P_mm.
    pub(super) feature: SMatrix<T, D, D>,
}

/// P Hᵀ, row by row: what every coordinate has in common with a predicted measurement.
#[derive(Debug)]
pub(super) struct Common<'s, T, const K: usize, const Z: usize> {
    pub(super) pose: [SVector<T, Z>; K],
    pub(super) features: &'s mut [SVector<T, Z>],
}

impl<T: Real, const K: usize, const D: usize> Joint<'_, T, K, D> {
    /// The element of that row and column, in any order.
    pub(super) fn get(&self, row: usize, column: usize) -> T {
        let (row, column) = if row >= column { (row, column) } else { (column, row) };
        self.numbers.get(row_start(row) + column).copied().unwrap_or(T::ZERO)
    }

    fn set(&mut self, row: usize, column: usize, value: T) {
        let (row, column) = if row >= column { (row, column) } else { (column, row) };
        if let Some(slot) = self.numbers.get_mut(row_start(row) + column) {
            *slot = value;
        }
    }

    /// All numbers of so many features.
    pub(super) fn used(&self, features: usize) -> &[T] {
        self.numbers.get(..row_start(K + D * features)).unwrap_or(&[])
    }

    /// The pose's own block.
    pub(super) fn pose(&self) -> SMatrix<T, K, K> {
        SMatrix::from_fn(|row, column| self.get(row, column))
    }

    /// The covariance of a feature with another, or with itself.
    pub(super) fn between(&self, one: usize, other: usize) -> SMatrix<T, D, D> {
        SMatrix::from_fn(|row, column| self.get(K + D * one + row, K + D * other + column))
    }

    /// The covariance of a feature with the pose.
    pub(super) fn with_pose(&self, feature: usize) -> SMatrix<T, D, K> {
        SMatrix::from_fn(|row, column| self.get(K + D * feature + row, column))
    }

    /// Those of the pose and a feature.
    pub(super) fn blocks(&self, feature: usize) -> Blocks<T, K, D> {
        Blocks { pose: self.pose(), cross: self.with_pose(feature), feature: self.between(feature, feature) }
    }

    /// Takes the pose as certain, without features.
    pub(super) fn clear(&mut self) {
        self.numbers.iter_mut().take(row_start(K)).for_each(|number| *number = T::ZERO);
    }

    /// P_xx ← F P_xx Fᵀ + Q, P_mx ← P_mx Fᵀ, of so many features.
    pub(super) fn propagate(&mut self, transition: &SMatrix<T, K, K>, pose: &SMatrix<T, K, K>, features: usize) {
        for row in 0..K {
            for column in 0..=row {
                self.set(row, column, element(pose, row, column));
            }
        }
        for row in K..K + D * features {
            let start = row_start(row);
            let Some(cross) = self.numbers.get_mut(start..start + K) else { return };
            let before = SVector::<T, K>::from_fn(|k, _| cross.get(k).copied().unwrap_or(T::ZERO));
            let after = transition * before;
            cross.iter_mut().zip(after.iter()).for_each(|(slot, &after)| *slot = after);
        }
    }

    /// P Hᵀ for a feature's Hx = ∂h/∂x and Hm = ∂h/∂m, over so many features.
    pub(super) fn common<const Y: usize, const Z: usize>(
        &self,
        feature: usize,
        by_pose: &SMatrix<T, Y, K>,
        by_feature: &SMatrix<T, Y, D>,
        features: usize,
        into: &mut Common<'_, T, K, Z>,
    ) {
        let first = K + D * feature;
        let of = |coordinate: usize| {
            let pose = SVector::<T, K>::from_fn(|k, _| self.get(coordinate, k));
            let own = SVector::<T, D>::from_fn(|d, _| self.get(coordinate, first + d));
            let of_measurement = by_pose * pose + by_feature * own;
            SVector::from_fn(|z, _| of_measurement.get(z).copied().unwrap_or(T::ZERO))
        };
        into.pose.iter_mut().enumerate().for_each(|(k, slot)| *slot = of(k));
        into.features.iter_mut().take(D * features).enumerate().for_each(|(d, slot)| *slot = of(K + d));
    }

    /// P Hᵀ for a measurement of the pose alone.
    pub(super) fn common_with_pose<const Y: usize, const Z: usize>(
        &self,
        by_pose: &SMatrix<T, Y, K>,
        features: usize,
        into: &mut Common<'_, T, K, Z>,
    ) {
        let of = |coordinate: usize| {
            let of_measurement = by_pose * SVector::<T, K>::from_fn(|k, _| self.get(coordinate, k));
            SVector::from_fn(|z, _| of_measurement.get(z).copied().unwrap_or(T::ZERO))
        };
        into.pose.iter_mut().enumerate().for_each(|(k, slot)| *slot = of(k));
        into.features.iter_mut().take(D * features).enumerate().for_each(|(d, slot)| *slot = of(K + d));
    }

    /// P ← P + (P Hᵀ) B (P Hᵀ)ᵀ over so many features, B symmetric. A variance keeps what rounding may have taken from it: without
    /// that the matrix would lose its definiteness in the course of a hundred thousand updates.
    pub(super) fn add_product<const Z: usize>(
        &mut self,
        common: &Common<'_, T, K, Z>,
        by: &SMatrix<T, Z, Z>,
        features: usize,
    ) {
        let rounding = T::ONE + T::EPSILON * T::from_f64(4.0);
        let rows = common.pose.iter().chain(common.features.iter().take(D * features));
        for (row, of_row) in rows.enumerate() {
            let weighed = by * of_row;
            let start = row_start(row);
            let Some(numbers) = self.numbers.get_mut(start..=start + row) else { return };
            let columns = common.pose.iter().chain(common.features.iter());
            for (number, of_column) in numbers.iter_mut().zip(columns) {
                *number += weighed.dot(of_column);
            }
            if let Some(variance) = numbers.last_mut() {
                *variance *= rounding;
            }
        }
    }

    /// P ← (I + c eᵀ) P (I + c eᵀ)ᵀ over so many features, with e the direction of the coordinate `heading` and c = `lever` of each
    /// other coordinate (0 of the heading itself): what an uncertain heading means where things have been moved to.
    pub(super) fn turn(&mut self, heading: usize, lever: impl Fn(usize) -> T, features: usize) {
        let variance = self.get(heading, heading);
        for row in (0..K + D * features).filter(|&row| row != heading) {
            let (of_row, with_row) = (lever(row), self.get(row, heading));
            for column in (0..=row).filter(|&column| column != heading) {
                let (of_column, with_column) = (lever(column), self.get(column, heading));
                let grown = of_row * (with_column + of_column * variance) + with_row * of_column;
                self.set(row, column, self.get(row, column) + grown);
            }
        }
        for row in (0..K + D * features).filter(|&row| row != heading) {
            self.set(row, heading, self.get(row, heading) + lever(row) * variance);
        }
    }

    /// Takes a coordinate of the pose whose variance rounding has made negative, or no number at all, for certain and for
    /// independent of the rest; how many.
    pub(super) fn mend_pose(&mut self, features: usize) -> usize {
        let mut mended = 0;
        for row in 0..K {
            let variance = self.get(row, row);
            if !(variance >= T::ZERO && variance < T::INFINITY) {
                (0..K + D * features).for_each(|column| self.set(row, column, T::ZERO));
                mended += 1;
            }
        }
        mended
    }

    /// Adds a feature behind so many: m = g(x, z) with J = ∂g/∂x, and the covariance `own` that z brings.
    pub(super) fn add(&mut self, by_pose: &SMatrix<T, D, K>, own: &SMatrix<T, D, D>, features: usize) {
        let first = K + D * features;
        for column in 0..first {
            let of = SVector::<T, K>::from_fn(|k, _| self.get(column, k));
            let cross = by_pose * of;
            (0..D).for_each(|d| self.set(first + d, column, cross.get(d).copied().unwrap_or(T::ZERO)));
        }
        let block = by_pose * self.pose() * by_pose.transpose() + own;
        for row in 0..D {
            for column in 0..=row {
                self.set(first + row, first + column, element(&block, row, column));
            }
        }
    }

    /// Puts the last of so many features in the place of another.
    pub(super) fn replace_by_last(&mut self, feature: usize, features: usize) {
        let last = features.saturating_sub(1);
        if feature >= last {
            return;
        }
        let (to, from) = (K + D * feature, K + D * last);
        for other in (0..from).filter(|other| !(to..to + D).contains(other)) {
            (0..D).for_each(|d| self.set(to + d, other, self.get(from + d, other)));
        }
        for row in 0..D {
            (0..=row).for_each(|column| self.set(to + row, to + column, self.get(from + row, from + column)));
        }
    }
}

fn element<T: Real, const R: usize, const C: usize>(matrix: &SMatrix<T, R, C>, row: usize, column: usize) -> T {
    matrix.get((row, column)).copied().unwrap_or(T::ZERO)
}

/// The lower triangle of what is symmetric but for rounding.
pub(super) fn symmetric<T: Real, const N: usize>(full: &SMatrix<T, N, N>) -> Symmetric<T, N>
where
    Dim<N>: Packed,
{
    Symmetric::from_fn(|row, column| (element(full, row, column) + element(full, column, row)) * T::from_f64(0.5))
}
