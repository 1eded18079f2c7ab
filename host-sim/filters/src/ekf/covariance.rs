//! A symmetric matrix whose size changes with the map.

use nalgebra::{RowVector2, SMatrix, SVector};

/// Covariance of the whole state, row by row.
#[derive(Debug, Clone)]
pub(super) struct Covariance {
    side: usize,
    entries: Vec<f64>,
}

impl Covariance {
    /// Creates the covariance of `side` variables without uncertainty.
    pub(super) fn zero(side: usize) -> Self {
        Self { side, entries: vec![0.0; side * side] }
    }

    pub(super) fn side(&self) -> usize {
        self.side
    }

    pub(super) fn get(&self, row: usize, column: usize) -> f64 {
        self.entries[row * self.side + column]
    }

    /// Sets an entry and its mirror.
    pub(super) fn set(&mut self, row: usize, column: usize, value: f64) {
        self.entries[row * self.side + column] = value;
        self.entries[column * self.side + row] = value;
    }

    /// The block of these variables.
    pub(super) fn block<const N: usize>(&self, variables: [usize; N]) -> SMatrix<f64, N, N> {
        SMatrix::from_fn(|row, column| self.get(variables[row], variables[column]))
    }

    /// The covariances of one variable with these.
    pub(super) fn row<const N: usize>(&self, row: usize, variables: [usize; N]) -> SVector<f64, N> {
        SVector::from_fn(|k, _| self.get(row, variables[k]))
    }

    /// The covariance of the variables of `kept`, in their order.
    pub(super) fn keep(&self, kept: &[usize]) -> Self {
        let entries = kept.iter().flat_map(|&row| kept.iter().map(move |&column| self.get(row, column)));
        Self { side: kept.len(), entries: entries.collect() }
    }

    /// The covariance with `more` variables without uncertainty appended.
    pub(super) fn grown(&self, more: usize) -> Self {
        let mut grown = Self::zero(self.side + more);
        for (from, to) in self.entries.chunks(self.side.max(1)).zip(grown.entries.chunks_mut(self.side + more)) {
            to[..self.side].copy_from_slice(from);
        }
        grown
    }

    /// P ← P − K (P Hᵀ)ᵀ, with K and P Hᵀ row by row.
    pub(super) fn subtract(&mut self, gain: &[RowVector2<f64>], cross: &[RowVector2<f64>]) {
        for (row, gain) in gain.iter().enumerate() {
            for (column, cross) in cross.iter().enumerate().skip(row) {
                self.set(row, column, self.get(row, column) - gain.dot(cross));
            }
        }
    }

    /// P ← A P Aᵀ of errors e that become e + `by` e_k, with e_k the error of variable `of`, whose own entry of `by` is zero.
    pub(super) fn shear(&mut self, of: usize, by: &[f64]) {
        let cross: Vec<f64> = (0..self.side).map(|column| self.get(of, column)).collect();
        for (row, by_row) in by.iter().enumerate() {
            for (column, by_column) in by.iter().enumerate().skip(row) {
                let more = by_row * cross[column] + cross[row] * by_column + by_row * by_column * cross[of];
                self.set(row, column, self.get(row, column) + more);
            }
        }
    }
}
