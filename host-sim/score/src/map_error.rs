//! Map error of one scan: OSPA of order 1 with the thesis's two cut-offs, in the plane or in space.

use crate::cutoff::Cutoff;
use crate::ospa::{Ospa, ospa};
use scphd_log::dimensions::Coordinates;

/// Cut-off 1 m: an error of more than a metre costs as much as a missing feature.
pub const NEAR: Cutoff = Cutoff::new(1.0, 1.0);
/// Cut-off 10 m, that of figures 5.5b, 5.6c and 5.8b.
pub const FAR: Cutoff = Cutoff::new(1.0, 10.0);

/// OSPA distance of an estimated map to the true map at a scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapError {
    /// With a cut-off of 1 m.
    pub near: Ospa,
    /// With a cut-off of 10 m.
    pub far: Ospa,
}

impl MapError {
    /// Compares the positions of all estimated features, static and moving ones together, with the true ones, m.
    pub fn of<P: Coordinates>(estimate: &[P], truth: &[P]) -> Self {
        Self { near: ospa(estimate, truth, &NEAR), far: ospa(estimate, truth, &FAR) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_cut_offs() {
        let truth = [[0.0, 0.0], [20.0, 0.0], [0.0, 5.0]];
        let error = MapError::of(&[[0.5, 0.0], [20.0, 0.0], [0.0, 7.0]], &truth);
        // Errors of 0.5, 0 and 2 m.
        assert!((error.far.distance - 2.5 / 3.0).abs() < 1e-12 && error.far.cardinality == 0.0);
        assert!((error.near.distance - 1.5 / 3.0).abs() < 1e-12);
        let without = MapError::of(&[[0.5, 0.0], [20.0, 0.0]], &truth);
        assert!((without.far.cardinality - 10.0 / 3.0).abs() < 1e-12);
        assert!((without.far.localization - 0.5 / 3.0).abs() < 1e-12);
    }
}
