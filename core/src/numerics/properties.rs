//! Property tests of the arithmetic.

use crate::numerics::ln_sum::ln_sum;
use crate::{LnSum, Matrix, Symmetric, wrap};
use core::f64::consts::{PI, TAU};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use std::vec::Vec;

/// A Aᵀ + ε I, which is positive definite.
fn definite(numbers: [f64; 9]) -> (Symmetric<Vector3<f64>>, Matrix3<f64>) {
    let a = Matrix3::from_row_slice(&numbers);
    let full = a * a.transpose() + Matrix3::identity() * 1e-3;
    (Symmetric::from_fn(|row, column| full[(row, column)]), full)
}

fn numbers() -> impl Strategy<Value = [f64; 9]> {
    proptest::array::uniform9(-10.0..10.0)
}

proptest! {
    #[test]
    fn an_angle_is_wrapped_by_whole_turns(angle in -1e3..1e3_f64, turns in -50_i32..50) {
        let wrapped = wrap(angle);
        prop_assert!(wrapped > -PI && wrapped <= PI);
        prop_assert!(((angle - wrapped) / TAU - ((angle - wrapped) / TAU).round()).abs() < 1e-9);
        let apart = (wrap(angle + TAU * f64::from(turns)) - wrapped).abs();
        prop_assert!(apart < 1e-9 || (apart - TAU).abs() < 1e-9);
        prop_assert!(wrap(wrapped).to_bits() == wrapped.to_bits());
    }

    #[test]
    fn any_single_precision_angle_is_wrapped_into_range(bits in any::<u32>()) {
        let angle = f32::from_bits(bits);
        let wrapped = wrap(angle);
        let in_range = wrapped > -core::f32::consts::PI && wrapped <= core::f32::consts::PI;
        prop_assert!(in_range || !angle.is_finite());
    }

    #[test]
    fn a_sum_of_logarithms_lies_between_its_greatest_term_and_that_of_all(
        terms in proptest::collection::vec(-500.0..500.0_f64, 1..40),
    ) {
        let greatest = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let sum = ln_sum(terms.iter().copied());
        prop_assert!(sum >= greatest - 1e-12 && sum <= greatest + (terms.len() as f64).ln() + 1e-12);
        let exact = greatest + terms.iter().map(|term| (term - greatest).exp()).sum::<f64>().ln();
        prop_assert!((sum - exact).abs() < 1e-9);
        let mut backwards = LnSum::EMPTY;
        terms.iter().rev().for_each(|&term| backwards.add(term));
        prop_assert!((backwards.ln() - sum).abs() < 1e-9);
    }

    #[test]
    fn factors_solve_and_invert(elements in numbers(), v in proptest::array::uniform3(-10.0..10.0_f64)) {
        let (packed, full) = definite(elements);
        let v = Vector3::from(v);
        let factor = packed.factor().unwrap();
        let scale = full.norm() * 1e3 * (1.0 + v.norm());
        prop_assert!((full * factor.solve(&v) - v).norm() < 1e-11 * scale);
        prop_assert!((factor.mahalanobis(&v) - v.dot(&factor.solve(&v))).abs() < 1e-10 * (1.0 + v.norm_squared() * 1e3));
        prop_assert!((factor.quadratic(&v) - v.dot(&(full * v))).abs() < 1e-11 * (1.0 + full.norm() * v.norm_squared()));
        let inverse = factor.inverse();
        let back = full * Matrix3::from_fn(|row, column| inverse.get(row, column));
        prop_assert!((back - Matrix3::identity()).norm() < 1e-9 * scale);
        prop_assert!((factor.determinant() / full.determinant() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_congruence_is_that_of_full_matrices(elements in numbers(), by in numbers()) {
        let (packed, full) = definite(elements);
        let a = Matrix3::from_row_slice(&by);
        let a_packed = Matrix::with(|row, column| a[(row, column)]);
        let (ours, theirs) = (packed.congruence::<Vector3<f64>>(&a_packed), a * full * a.transpose());
        for (row, column) in (0..3).flat_map(|row| (0..3).map(move |column| (row, column))) {
            prop_assert!((ours.get(row, column) - theirs[(row, column)]).abs() < 1e-12 * (1.0 + theirs.norm()));
        }
    }

    /// The result is positive definite, and equals the input except for an addition to its diagonal.
    #[test]
    fn what_is_kept_is_positive_definite(lower in proptest::array::uniform6(-1e3..1e3_f32)) {
        let places = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];
        let of = |at: (usize, usize)| places.iter().position(|&place| place == at).map_or(0.0, |k| lower[k]);
        let matrix = Symmetric::<Vector3<f32>>::from_fn(|row, column| of((row, column)));
        if let Some((kept, raised)) = matrix.kept_positive_definite() {
            prop_assert!(kept.factor().is_some());
            let apart: Vec<f32> = (0..3).map(|k| kept.get(k, k) - matrix.get(k, k)).collect();
            prop_assert!(apart.iter().all(|&by| by >= 0.0) && (raised || kept == matrix));
            prop_assert!(kept.get(1, 0) == matrix.get(1, 0) && kept.get(2, 1) == matrix.get(2, 1));
        }
    }

    #[test]
    fn a_root_times_its_transpose_is_the_matrix(elements in numbers()) {
        let (packed, full) = definite(elements);
        let root = packed.root();
        let back = Matrix3::from_fn(|row, column| (0..3).map(|k| root.at(row, k) * root.at(column, k)).sum::<f64>());
        prop_assert!((back - full).norm() < 1e-10 * (1.0 + full.norm()));
    }
}
