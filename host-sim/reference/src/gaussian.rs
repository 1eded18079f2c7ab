//! Components of a map.

use super::algebra::{eliminated, quadratic};
use std::f64::consts::TAU;

/// A position (m, m) or a measurement (m, rad).
pub type Vector = [f64; 2];

/// A full 2×2 matrix, row by row.
pub type Matrix = [[f64; 2]; 2];

/// A component of the mixture that is a particle's map (5.8).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Component<const N: usize = 2> {
    /// ln w; w is the expected number of features under this component.
    pub ln_weight: f64,
    /// Mean m: position of a static feature, m; for a moving one also its velocity, m/s.
    pub mean: [f64; N],
    pub covariance: [[f64; N]; N],
}

impl<const N: usize> Component<N> {
    /// w, the expected number of features under this component.
    pub fn weight(&self) -> f64 {
        self.ln_weight.exp()
    }

    /// Position, m: the first two coordinates of the mean.
    pub fn position(&self) -> Vector {
        [self.mean[0], self.mean[1]]
    }
}

/// The density of a Gaussian with mean zero.
pub(super) struct Density<const N: usize> {
    inverse: [[f64; N]; N],
    ln_determinant: f64,
}

impl<const N: usize> Density<N> {
    pub(super) fn new(covariance: &[[f64; N]; N]) -> Self {
        let (inverse, determinant) = eliminated(covariance);
        Self { inverse, ln_determinant: determinant.ln() }
    }

    /// ln N(residual; 0, covariance).
    pub(super) fn ln(&self, residual: [f64; N]) -> f64 {
        -0.5 * (quadratic(&self.inverse, residual) + self.ln_determinant + N as f64 * TAU.ln())
    }
}
