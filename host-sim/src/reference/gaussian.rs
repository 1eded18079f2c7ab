//! Components of a map and the plain 2×2 algebra they need.

use std::f64::consts::TAU;

/// A position (m, m) or a measurement (m, rad).
pub type Vector = [f64; 2];

/// A full 2×2 matrix, row by row.
pub type Matrix = [[f64; 2]; 2];

/// One term of the mixture that is a particle's map (5.8).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Component<const N: usize = 2> {
    /// ln w; w is the expected number of features under this component.
    pub ln_weight: f64,
    /// Mean m: of a static feature its position, m; of a moving one also its velocity, m/s.
    pub mean: [f64; N],
    /// Covariance P.
    pub covariance: [[f64; N]; N],
}

impl<const N: usize> Component<N> {
    /// w, the expected number of features under this component.
    pub fn weight(&self) -> f64 {
        self.ln_weight.exp()
    }
}

pub(super) const IDENTITY: Matrix = [[1.0, 0.0], [0.0, 1.0]];

pub(super) fn plus(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1]]
}

pub(super) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

pub(super) fn apply(a: &Matrix, v: Vector) -> Vector {
    [a[0][0] * v[0] + a[0][1] * v[1], a[1][0] * v[0] + a[1][1] * v[1]]
}

pub(super) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let b = transpose(b);
    transpose(&[apply(a, b[0]), apply(a, b[1])])
}

pub(super) fn transpose(a: &Matrix) -> Matrix {
    [[a[0][0], a[1][0]], [a[0][1], a[1][1]]]
}

pub(super) fn sum(a: &Matrix, b: &Matrix) -> Matrix {
    [plus(a[0], b[0]), plus(a[1], b[1])]
}

pub(super) fn difference(a: &Matrix, b: &Matrix) -> Matrix {
    [minus(a[0], b[0]), minus(a[1], b[1])]
}

pub(super) fn scaled(factor: f64, a: &Matrix) -> Matrix {
    a.map(|row| row.map(|entry| factor * entry))
}

/// v vᵀ.
pub(super) fn outer(v: Vector) -> Matrix {
    [[v[0] * v[0], v[0] * v[1]], [v[1] * v[0], v[1] * v[1]]]
}

/// vᵀ A v.
pub(super) fn quadratic(a: &Matrix, v: Vector) -> f64 {
    let av = apply(a, v);
    v[0] * av[0] + v[1] * av[1]
}

pub(super) fn determinant(a: &Matrix) -> f64 {
    a[0][0] * a[1][1] - a[0][1] * a[1][0]
}

pub(super) fn inverse(a: &Matrix) -> Matrix {
    scaled(1.0 / determinant(a), &[[a[1][1], -a[0][1]], [-a[1][0], a[0][0]]])
}

/// (A + Aᵀ)/2: takes the rounding out of a matrix that is symmetric on paper.
pub(super) fn symmetrised(a: &Matrix) -> Matrix {
    scaled(0.5, &sum(a, &transpose(a)))
}

/// A P Aᵀ.
pub(super) fn transformed(a: &Matrix, p: &Matrix) -> Matrix {
    symmetrised(&product(&product(a, p), &transpose(a)))
}

/// ln N(residual; 0, covariance).
pub(super) fn ln_density(residual: Vector, covariance: &Matrix) -> f64 {
    -0.5 * (quadratic(&inverse(covariance), residual) + determinant(covariance).ln()) - TAU.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Matrix = [[2.0, 0.3], [-0.7, 1.5]];

    #[test]
    fn inverse_undoes() {
        let identity = product(&A, &inverse(&A));
        for row in 0..2 {
            for column in 0..2 {
                assert!((identity[row][column] - IDENTITY[row][column]).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn product_is_not_commuted() {
        let b = [[0.0, 1.0], [0.0, 0.0]];
        assert_eq!(product(&A, &b), [[0.0, 2.0], [0.0, -0.7]]);
        assert_eq!(product(&b, &A), [[-0.7, 1.5], [0.0, 0.0]]);
    }

    #[test]
    fn density_integrates_to_one() {
        let covariance = [[0.5, 0.2], [0.2, 0.3]];
        let step = 0.05;
        let mut mass = 0.0;
        for i in -100..100 {
            for j in -100..100 {
                let point = [step * f64::from(i), step * f64::from(j)];
                mass += ln_density(point, &covariance).exp() * step * step;
            }
        }
        assert!((mass - 1.0).abs() < 1e-9, "mass {mass}");
    }
}
