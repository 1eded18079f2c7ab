//! Tests of realisations against closed forms.
//!
//! Seeds are fixed, so a test that passes keeps passing; the bounds say how rarely another seed would fail.

use super::{Point, Rectangle};

/// Standard errors a mean or a variance may be off: passed with probability 0.99994 each.
const SIGMAS: f64 = 4.0;
/// The standard normal quantile of 0.999, for chi-square.
const NORMAL_999: f64 = 3.0902;

/// Mean of `values` and its standard error.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

/// How many standard errors the mean of `values` lies above `expected`.
fn z(values: &[f64], expected: f64) -> f64 {
    let (mean, error) = mean_and_error(values);
    (mean - expected) / error
}

/// The mean of independent `values` is `expected` within four standard errors.
#[track_caller]
pub fn assert_mean_of(values: &[f64], expected: f64) {
    let z = z(values, expected);
    assert!(z.abs() < SIGMAS, "mean {} is {z} standard errors from {expected}", mean_and_error(values).0);
}

/// The mean and the variance of independent `values` are those given, within four standard errors.
#[track_caller]
pub fn assert_moments(values: &[f64], mean: f64, variance: f64) {
    assert_mean_of(values, mean);
    let squares: Vec<f64> = values.iter().map(|v| (v - mean).powi(2)).collect();
    assert_mean_of(&squares, variance);
}

/// Column by column, the means of independent `rows` are `expected`.
#[track_caller]
pub fn assert_means(rows: &[Vec<f64>], expected: &[f64]) {
    for (column, &mean) in expected.iter().enumerate() {
        assert_mean_of(&rows.iter().map(|row| row[column]).collect::<Vec<f64>>(), mean);
    }
}

/// Pearson's statistic is below the 0.999 quantile of chi-square with `freedom` degrees (Wilson and Hilferty).
#[track_caller]
pub fn assert_chi_square(counts: &[f64], expected: &[f64], freedom: f64) {
    assert_eq!(counts.len(), expected.len());
    let statistic: f64 = counts.iter().zip(expected).map(|(o, e)| (o - e).powi(2) / e).sum();
    let quantile = chi_square_999(freedom);
    assert!(statistic < quantile, "chi-square {statistic} of {freedom} degrees is beyond {quantile}");
}

fn chi_square_999(freedom: f64) -> f64 {
    let spread = 2.0 / (9.0 * freedom);
    freedom * (1.0 - spread + NORMAL_999 * spread.sqrt()).powi(3)
}

/// Points in each of `side` × `side` equal quadrats of `region`, row by row from the lower left; all lie in it.
pub fn quadrat_counts(points: impl IntoIterator<Item = Point>, region: Rectangle, side: usize) -> Vec<f64> {
    let mut counts = vec![0.0; side * side];
    for point in points {
        assert!(region.contains(point), "{point:?}");
        let [column, row] = [0, 1].map(|axis| {
            let share = (point[axis] - region.low()[axis]) / region.sides()[axis];
            ((share * side as f64) as usize).min(side - 1)
        });
        counts[row * side + column] += 1.0;
    }
    counts
}

/// Expected daughters in the quadrats of `seen` by integration: `intensity` times the share of the displacements
/// (equally likely, parent to daughter) that come from within `parents`.
pub fn expected_in_quadrats(
    seen: Rectangle,
    side: usize,
    parents: Rectangle,
    displacements: &[Point],
    intensity: f64,
) -> Vec<f64> {
    let [dx, dy] = seen.sides().map(|length| length / side as f64);
    let mut expected = Vec::new();
    for row in 0..side {
        for column in 0..side {
            let low = [seen.low()[0] + dx * column as f64, seen.low()[1] + dy * row as f64];
            // The area of the quadrat from which a displacement leads back into the parents' rectangle is known exactly.
            let area: f64 = displacements
                .iter()
                .map(|d| {
                    let overlap = |axis: usize, length: f64| {
                        let from = low[axis].max(parents.low()[axis] + d[axis]);
                        let to = (low[axis] + length).min(parents.high()[axis] + d[axis]);
                        (to - from).max(0.0)
                    };
                    overlap(0, dx) * overlap(1, dy)
                })
                .sum();
            expected.push(intensity * area / displacements.len() as f64);
        }
    }
    expected
}

/// An unbiased estimate of Ripley's K(r) (m²) from each realisation of a stationary process of known intensity.
///
/// Counts the pairs no further than `r` apart whose first point is at least `r` inside the region, where all its
/// neighbours are seen.
pub fn pair_densities(realisations: &[Vec<Point>], region: Rectangle, r: f64, intensity: f64) -> Vec<f64> {
    let inner = region.grown(-r).unwrap();
    realisations
        .iter()
        .map(|points| {
            let mut pairs = 0;
            for (first, a) in points.iter().enumerate().filter(|(_, a)| inner.contains(**a)) {
                let near = |b: &Point| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) <= r * r;
                pairs += points.iter().enumerate().filter(|(second, b)| *second != first && near(b)).count();
            }
            pairs as f64 / (inner.area() * intensity * intensity)
        })
        .collect()
}

/// The estimates have the mean `k` within four standard errors.
#[track_caller]
pub fn assert_k(estimates: &[f64], k: f64) {
    assert_mean_of(estimates, k);
}

/// How many standard errors the estimates lie above `k`.
pub fn beyond_k(estimates: &[f64], k: f64) -> f64 {
    z(estimates, k)
}

#[test]
fn quantiles_are_those_of_the_tables() {
    for (freedom, quantile) in [(10.0, 29.588), (19.0, 43.820), (64.0, 104.716), (99.0, 148.230)] {
        assert!((chi_square_999(freedom) / quantile - 1.0).abs() < 7e-3, "{freedom}");
    }
}
