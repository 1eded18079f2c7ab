//! A symmetric matrix that grows and shrinks with the map.

/// Covariance of the whole state, row by row.
#[derive(Debug, Clone)]
pub(super) struct Covariance {
    side: usize,
    entries: Vec<f64>,
}

impl Covariance {
    /// Of `side` variables that are known exactly.
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
    pub(super) fn block<const N: usize>(&self, variables: [usize; N]) -> [[f64; N]; N] {
        variables.map(|row| variables.map(|column| self.get(row, column)))
    }

    /// The same with the variables of `kept`, in their order.
    pub(super) fn keep(&self, kept: &[usize]) -> Self {
        let entries = kept.iter().flat_map(|&row| kept.iter().map(move |&column| self.get(row, column)));
        Self { side: kept.len(), entries: entries.collect() }
    }

    /// The same with `more` variables at the end that are known exactly.
    pub(super) fn grown(&self, more: usize) -> Self {
        let mut grown = Self::zero(self.side + more);
        for (from, to) in self.entries.chunks(self.side.max(1)).zip(grown.entries.chunks_mut(self.side + more)) {
            to[..self.side].copy_from_slice(from);
        }
        grown
    }

    /// P ← P − G Hᵀ-like update of rank 2: subtracts gain · crossᵀ, with cross = P Hᵀ and gain = P Hᵀ S⁻¹.
    pub(super) fn subtract(&mut self, gain: &[[f64; 2]], cross: &[[f64; 2]]) {
        for row in 0..self.side {
            let [g0, g1] = gain[row];
            for column in row..self.side {
                let value = self.get(row, column) - g0 * cross[column][0] - g1 * cross[column][1];
                self.set(row, column, value);
            }
        }
    }
}
