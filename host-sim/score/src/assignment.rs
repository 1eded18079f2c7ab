//! Optimal assignment of rows to columns.
//!
//! `pathfinding::kuhn_munkres` is a maintained Hungarian algorithm that requires totally ordered weights and at most as many rows
//! as columns. It is called with fixed-point i128 numbers: the costs times a power of two that brings the greatest just below
//! 2¹⁰⁰. Costs down to 2⁻⁴⁷ of the greatest keep all bits, smaller ones those above 2⁻¹⁰⁰ of it, far below the rounding of a sum
//! of f64 costs. All arithmetic in between is exact, so that rounding does not decide an assignment. (`lapjv` uses f64 directly,
//! but only on square matrices, and is maintained "as is".)

use pathfinding::prelude::{Matrix, kuhn_munkres_min};

/// Binary digits before the point of a fixed-point cost. Sums of n labels stay in i128 for n < 2²⁶.
const DIGITS: i32 = 100;

/// The pairs (row, column) with the least total cost: `min(rows, columns)` pairs by ascending row.
///
/// `costs` is row by row, each finite; of several optimal assignments always the same is chosen.
///
/// # Panics
///
/// If the number of `costs` is not `rows · columns`, or one of them is not finite.
pub fn assign(costs: &[f64], rows: usize, columns: usize) -> Vec<(usize, usize)> {
    assert_eq!(costs.len(), rows * columns, "as many costs as pairs");
    assert!(costs.iter().all(|cost| cost.is_finite()), "finite costs");
    let greatest = costs.iter().fold(0.0, |max: f64, cost| max.max(cost.abs()));
    let shift = DIGITS - libm::frexp(greatest).1;
    let fixed = |row: usize, column: usize| libm::scalbn(costs[row * columns + column], shift) as i128;
    if rows == 0 || columns == 0 {
        Vec::new()
    } else if rows <= columns {
        let matrix = Matrix::from_fn(rows, columns, |(row, column)| fixed(row, column));
        kuhn_munkres_min(&matrix).1.into_iter().enumerate().collect()
    } else {
        let matrix = Matrix::from_fn(columns, rows, |(column, row)| fixed(row, column));
        let chosen = kuhn_munkres_min(&matrix).1.into_iter().enumerate();
        let mut pairs: Vec<_> = chosen.map(|(column, row)| (row, column)).collect();
        pairs.sort_unstable();
        pairs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_log::noise::Noise;

    fn total(costs: &[f64], columns: usize, pairs: &[(usize, usize)]) -> f64 {
        pairs.iter().map(|&(row, column)| costs[row * columns + column]).sum()
    }

    /// Least total over all assignments of the rows from `row` to columns not in `used`.
    fn exhaustive(costs: &[f64], rows: usize, columns: usize, row: usize, used: u32) -> f64 {
        if row == rows {
            return 0.0;
        }
        let free = (0..columns).filter(|column| used & (1 << column) == 0);
        free.map(|column| {
            costs[row * columns + column] + exhaustive(costs, rows, columns, row + 1, used | (1 << column))
        })
        .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn assignments_are_as_good_as_by_exhaustive_search() {
        let mut noise = Noise::new(7);
        for case in 0..300 {
            let (rows, columns) = (1 + case % 5, 1 + case % 6);
            if rows > columns {
                continue;
            }
            // Costs over many magnitudes, some negative.
            let costs: Vec<f64> =
                (0..rows * columns).map(|_| noise.normal() * libm::exp2(20.0 * noise.normal())).collect();
            let pairs = assign(&costs, rows, columns);
            assert_eq!(pairs.len(), rows);
            let best = exhaustive(&costs, rows, columns, 0, 0);
            let scale = costs.iter().fold(0.0, |max: f64, cost| max.max(cost.abs()));
            assert!((total(&costs, columns, &pairs) - best).abs() <= 1e-14 * scale);
            // The transposed problem has the same solution.
            let transposed: Vec<f64> = (0..columns * rows).map(|k| costs[k % rows * columns + k / rows]).collect();
            let back = assign(&transposed, columns, rows);
            assert!((total(&transposed, rows, &back) - best).abs() <= 1e-14 * scale);
        }
    }

    #[test]
    fn neither_rows_nor_columns() {
        assert!(assign(&[], 0, 3).is_empty());
        assert!(assign(&[], 3, 0).is_empty());
        assert_eq!(assign(&[0.0, 0.0], 2, 1).len(), 1);
    }

    #[test]
    fn tiny_costs_beside_great_ones_still_count() {
        let costs = [1e-20, 2e-20, 1e6, 3e-20, 1e-20, 1e6, 1e6, 1e6, 1.0];
        assert_eq!(assign(&costs, 3, 3), [(0, 0), (1, 1), (2, 2)]);
        let subnormal = [2e-320, 1e-320, 1e-320, 2e-320];
        assert_eq!(assign(&subnormal, 2, 2), [(0, 1), (1, 0)]);
    }

    #[test]
    #[should_panic(expected = "finite costs")]
    fn not_a_number_is_refused() {
        let _ = assign(&[f64::NAN], 1, 1);
    }

    #[test]
    fn oracle() {
        let oracle = scphd_shared_data::oracle("assignment_permanent.json");
        for case in oracle["assignment"].as_array().unwrap() {
            let matrix: Vec<Vec<f64>> =
                case["cost"].as_array().unwrap().iter().map(scphd_shared_data::numbers).collect();
            let (rows, columns) = (matrix.len(), matrix[0].len());
            let costs = matrix.concat();
            let pairs = assign(&costs, rows, columns);
            let side = |name: &str| scphd_shared_data::numbers(&case[name]).into_iter().map(|k| k as usize);
            assert_eq!(pairs, side("rows").zip(side("cols")).collect::<Vec<_>>());
            assert!((total(&costs, columns, &pairs) - case["total"].as_f64().unwrap()).abs() < 1e-9);
        }
    }
}
