//! Matrices of any size as plain arrays, row by row, and the linear algebra of mixtures.

use std::array::from_fn;

pub(super) fn identity<const N: usize>() -> [[f64; N]; N] {
    from_fn(|row| from_fn(|column| if row == column { 1.0 } else { 0.0 }))
}

pub(super) fn plus<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    from_fn(|k| a[k] + b[k])
}

pub(super) fn minus<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    from_fn(|k| a[k] - b[k])
}

pub(super) fn dot<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    (0..N).map(|k| a[k] * b[k]).sum()
}

pub(super) fn apply<const R: usize, const C: usize>(a: &[[f64; C]; R], v: [f64; C]) -> [f64; R] {
    a.map(|row| dot(row, v))
}

pub(super) fn product<const R: usize, const K: usize, const C: usize>(
    a: &[[f64; K]; R],
    b: &[[f64; C]; K],
) -> [[f64; C]; R] {
    let columns = transpose(b);
    a.map(|row| columns.map(|column| dot(row, column)))
}

pub(super) fn transpose<const R: usize, const C: usize>(a: &[[f64; C]; R]) -> [[f64; R]; C] {
    from_fn(|row| from_fn(|column| a[column][row]))
}

pub(super) fn sum<const R: usize, const C: usize>(a: &[[f64; C]; R], b: &[[f64; C]; R]) -> [[f64; C]; R] {
    from_fn(|row| plus(a[row], b[row]))
}

pub(super) fn difference<const R: usize, const C: usize>(a: &[[f64; C]; R], b: &[[f64; C]; R]) -> [[f64; C]; R] {
    from_fn(|row| minus(a[row], b[row]))
}

pub(super) fn scaled<const R: usize, const C: usize>(factor: f64, a: &[[f64; C]; R]) -> [[f64; C]; R] {
    a.map(|row| row.map(|entry| factor * entry))
}

/// v vᵀ.
pub(super) fn outer<const N: usize>(v: [f64; N]) -> [[f64; N]; N] {
    v.map(|entry| v.map(|other| entry * other))
}

/// vᵀ A v.
pub(super) fn quadratic<const N: usize>(a: &[[f64; N]; N], v: [f64; N]) -> f64 {
    dot(v, apply(a, v))
}

/// (A + Aᵀ)/2: removes rounding errors from a symmetric matrix.
pub(super) fn symmetrised<const N: usize>(a: &[[f64; N]; N]) -> [[f64; N]; N] {
    scaled(0.5, &sum(a, &transpose(a)))
}

/// A P Aᵀ.
pub(super) fn transformed<const R: usize, const C: usize>(a: &[[f64; C]; R], p: &[[f64; C]; C]) -> [[f64; R]; R] {
    symmetrised(&product(&product(a, p), &transpose(a)))
}

pub(super) fn determinant<const N: usize>(a: &[[f64; N]; N]) -> f64 {
    eliminated(a).1
}

pub(super) fn inverse<const N: usize>(a: &[[f64; N]; N]) -> [[f64; N]; N] {
    eliminated(a).0
}

/// Inverse and determinant by Gauss and Jordan's elimination with row pivoting.
pub(super) fn eliminated<const N: usize>(a: &[[f64; N]; N]) -> ([[f64; N]; N], f64) {
    let (mut left, mut right, mut determinant) = (*a, identity(), 1.0);
    for k in 0..N {
        let pivot = (k..N).max_by(|&i, &j| left[i][k].abs().total_cmp(&left[j][k].abs())).expect("rows are left");
        if pivot != k {
            left.swap(k, pivot);
            right.swap(k, pivot);
            determinant = -determinant;
        }
        let scale = left[k][k];
        determinant *= scale;
        left[k] = left[k].map(|entry| entry / scale);
        right[k] = right[k].map(|entry| entry / scale);
        for row in (0..N).filter(|&row| row != k) {
            let factor = left[row][k];
            left[row] = minus(left[row], left[k].map(|entry| factor * entry));
            right[row] = minus(right[row], right[k].map(|entry| factor * entry));
        }
    }
    (right, determinant)
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: [[f64; 2]; 2] = [[2.0, 0.3], [-0.7, 1.5]];
    /// Starts with a zero on the diagonal, so that rows must be exchanged.
    const B: [[f64; 4]; 4] = [[0.0, 2.0, 0.1, 0.4], [1.0, 0.0, -0.3, 0.2], [0.5, 0.6, 0.0, 3.0], [0.2, -1.0, 1.5, 0.0]];

    fn undone<const N: usize>(a: &[[f64; N]; N]) {
        for (row, entries) in product(a, &inverse(a)).iter().enumerate() {
            for (column, entry) in entries.iter().enumerate() {
                let expected = if row == column { 1.0 } else { 0.0 };
                assert!((entry - expected).abs() < 2e-15, "{entry} at {row}, {column}");
            }
        }
    }

    #[test]
    fn a_matrix_times_its_inverse_is_the_identity() {
        undone(&A);
        undone(&B);
    }

    /// Laplace's expansion along the first row.
    fn expanded(a: &[Vec<f64>]) -> f64 {
        if a.is_empty() {
            return 1.0;
        }
        let without = |column: usize| -> Vec<Vec<f64>> {
            a[1..].iter().map(|row| [&row[..column], &row[column + 1..]].concat()).collect()
        };
        (0..a.len()).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 } * a[0][k] * expanded(&without(k))).sum()
    }

    #[test]
    fn determinant_by_expansion() {
        assert!((determinant(&A) - 3.21).abs() < 1e-15);
        assert!((determinant(&B) - expanded(&B.map(|row| row.to_vec()))).abs() < 1e-14);
        assert_eq!(determinant(&[[0.0, 1.0], [1.0, 0.0]]), -1.0);
    }
}
