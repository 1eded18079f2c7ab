//! The conditional distribution of landmarks, given some others: the anchors.

use super::archive::{ANCHORS, Anchor};
use super::covariance::{Joint, first};
use crate::{Matrix, Pose, PositionOf, Real, ScalarOf, Vector, Zero};

/// Maximum number of coordinates of all anchors together.
const SIDE: usize = 3 * ANCHORS;

/// The coordinates s of the anchors in the joint covariance, for conditioning others on them.
pub(super) struct Conditioning<P: Pose> {
    /// Their rows in the joint covariance.
    rows: [usize; SIDE],
    len: usize,
    /// L of P_ss = L Lᵀ. A coordinate without a variance beyond rounding errors has a column of zeros.
    root: [[ScalarOf<P>; SIDE]; SIDE],
}

/// L⁻¹ P_sc of a coordinate c.
pub(super) type Whitened<P> = [ScalarOf<P>; SIDE];

impl<T: Real, P: Pose<Scalar = T>> Conditioning<P> {
    /// Conditioning on the landmarks with these indices.
    pub(super) fn on(joint: &Joint<'_, P>, indices: &[usize]) -> Self {
        let mut rows = [0; SIDE];
        let of_indices = indices.iter().flat_map(|&index| first::<P>(index)..first::<P>(index + 1));
        let len = rows.iter_mut().zip(of_indices).map(|(row, of)| *row = of).count();
        let mut root = [[T::ZERO; SIDE]; SIDE];
        for column in 0..len {
            let Some(&of_column) = rows.get(column) else { break };
            let variance = joint.get(of_column, of_column);
            let pivot = variance - products(row_of(&root, column), row_of(&root, column), column);
            // The comparison is written so that NaN is not a pivot.
            if !(pivot > T::EPSILON * T::from_f64(64.0) * variance && pivot.is_finite()) {
                continue;
            }
            let on_diagonal = pivot.sqrt();
            for (row, &of_row) in rows.iter().enumerate().take(len).skip(column) {
                let rest = joint.get(of_row, of_column) - products(row_of(&root, row), row_of(&root, column), column);
                if let Some(slot) = root.get_mut(row).and_then(|row| row.get_mut(column)) {
                    *slot = if row == column { on_diagonal } else { rest / on_diagonal };
                }
            }
        }
        Self { rows, len, root }
    }

    /// L⁻¹ P_sc of a coordinate c.
    pub(super) fn whitened(&self, joint: &Joint<'_, P>, coordinate: usize) -> Whitened<P> {
        let mut whitened = [T::ZERO; SIDE];
        for (k, &row) in self.rows.iter().enumerate().take(self.len) {
            let of_k = row_of(&self.root, k);
            let rest = joint.get(coordinate, row) - products(of_k, &whitened, k);
            let pivot = of_k.get(k).copied().unwrap_or(T::ZERO);
            if let Some(slot) = whitened.get_mut(k)
                && pivot > T::ZERO
            {
                *slot = rest / pivot;
            }
        }
        whitened
    }

    /// The covariance of two coordinates, given s.
    pub(super) fn covariance(&self, joint: &Joint<'_, P>, one: usize, other: usize) -> T {
        joint.get(one, other) - products(&self.whitened(joint, one), &self.whitened(joint, other), self.len)
    }

    /// The gain P_cs P_ss⁻¹ of a coordinate c.
    fn gain(&self, joint: &Joint<'_, P>, coordinate: usize) -> Whitened<P> {
        let whitened = self.whitened(joint, coordinate);
        let mut gain = [T::ZERO; SIDE];
        for k in (0..self.len).rev() {
            let behind = (k + 1..self.len).fold(T::ZERO, |sum, j| {
                let of = row_of(&self.root, j).get(k).copied().unwrap_or(T::ZERO);
                sum + of * gain.get(j).copied().unwrap_or(T::ZERO)
            });
            let (rest, pivot) =
                (whitened.get(k).map_or(T::ZERO, |&x| x - behind), row_of(&self.root, k).get(k).copied());
            if let (Some(slot), Some(pivot)) = (gain.get_mut(k), pivot)
                && pivot > T::ZERO
            {
                *slot = rest / pivot;
            }
        }
        gain
    }

    /// Sets the gains of a feature with respect to its anchors.
    pub(super) fn fill(&self, joint: &Joint<'_, P>, index: usize, anchors: &mut [Anchor<P>]) {
        let mut gains = <PositionOf<P> as Vector>::Array::<[T; SIDE]>::ZERO;
        for (d, row) in gains.as_mut().iter_mut().enumerate() {
            *row = self.gain(joint, first::<P>(index) + d);
        }
        for (k, anchor) in anchors.iter_mut().enumerate() {
            anchor.gain = Matrix::with(|row, column| {
                let at = k * PositionOf::<P>::DIMENSION + column;
                gains.as_ref().get(row).and_then(|row| row.get(at)).copied().unwrap_or(T::ZERO)
            });
        }
    }
}

fn row_of<T>(root: &[[T; SIDE]; SIDE], row: usize) -> &[T] {
    root.get(row).map_or(&[], |row| row)
}

/// The inner product of the first `len` elements.
fn products<T: Real>(one: &[T], other: &[T], len: usize) -> T {
    one.iter().zip(other).take(len).fold(T::ZERO, |sum, (&a, &b)| sum + a * b)
}
