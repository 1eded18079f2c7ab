//! The χ² distribution, and the bounds of a consistent filter's figures.

/// Probability between the two-sided bounds.
pub const CONFIDENCE: f64 = 0.95;

/// The two-sided bounds of χ² with this number of degrees of freedom: 2.5 % of all values are below the lower and 2.5 % above the
/// upper one.
fn bounds(freedom: f64) -> [f64; 2] {
    let tail = 0.5 * (1.0 - CONFIDENCE);
    [quantile(freedom, tail), quantile(freedom, 1.0 - tail)]
}

/// The bounds of the mean of `values` independent χ² values with `freedom` degrees of freedom each, divided by `freedom`: the
/// mean is 1.
pub fn bounds_of_mean(freedom: usize, values: usize) -> [f64; 2] {
    let all = (freedom * values) as f64;
    bounds(all).map(|bound| bound / all)
}

/// Whether a sum of squares with this number of degrees of freedom is within the two-sided bounds.
pub fn is_within(squares: f64, freedom: usize) -> bool {
    let tail = 0.5 * (1.0 - CONFIDENCE);
    (tail..=1.0 - tail).contains(&distribution(freedom as f64, squares))
}

/// The quantile at the probability `below`.
fn quantile(freedom: f64, below: f64) -> f64 {
    let (mut low, mut high) = (0.0, freedom + 10.0);
    while distribution(freedom, high) < below {
        high *= 2.0;
    }
    // More halvings than a double has bits.
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if distribution(freedom, middle) < below { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The distribution function: P(k/2, x/2) with the series of the lower incomplete gamma function P(a, y) = y^a e^−y Σ yⁿ / Γ(a +
/// n + 1).
fn distribution(freedom: f64, x: f64) -> f64 {
    let (a, y) = (0.5 * freedom, 0.5 * x);
    if y <= 0.0 {
        return 0.0;
    }
    // The probability beyond twenty standard deviations is negligible.
    if y > a + 20.0 * a.sqrt() + 20.0 {
        return 1.0;
    }
    let mut term = (a * y.ln() - y - libm::lgamma(a + 1.0)).exp();
    let mut sum = term;
    let mut n = 0.0;
    // Terms grow while n is below y − a, and then decrease faster and faster.
    while n < y || term > 1e-17 * sum {
        n += 1.0;
        term *= y / (a + n);
        sum += term;
    }
    sum.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_of_two_degrees_in_closed_form() {
        // 1 − exp(−x/2).
        let [low, high] = bounds(2.0);
        assert!((low + 2.0 * 0.975_f64.ln()).abs() < 1e-12, "{low}");
        assert!((high + 2.0 * 0.025_f64.ln()).abs() < 1e-9, "{high}");
    }

    #[test]
    fn bounds_as_in_tables() {
        let cases = [
            (1.0, 0.000_982, 5.023_886),
            (3.0, 0.215_795, 9.348_404),
            (4.0, 0.484_419, 11.143_287),
            (10.0, 3.246_973, 20.483_177),
            (100.0, 74.221_927, 129.561_197),
        ];
        for (freedom, low, high) in cases {
            let found = bounds(freedom);
            assert!((found[0] - low).abs() < 1e-5 && (found[1] - high).abs() < 1e-5, "{freedom}: {found:?}");
        }
        // With many degrees of freedom, by the normal distribution.
        let [low, high] = bounds_of_mean(2, 50_000);
        let sigma = (2.0_f64 / 100_000.0).sqrt();
        assert!((low - (1.0 - 1.96 * sigma)).abs() < 0.01 * sigma + 2e-5, "{low}");
        assert!((high - (1.0 + 1.96 * sigma)).abs() < 0.01 * sigma + 2e-5, "{high}");
    }

    #[test]
    fn the_share_of_values_between_the_bounds_is_right() {
        let mut noise = scphd::numerics::Noise::seeded(5);
        let [low, high] = bounds(3.0);
        let runs = 20_000;
        let within = (0..runs)
            .filter(|_| {
                let square: f64 = (0..3).map(|_| noise.normal::<f64>().powi(2)).sum();
                assert_eq!(is_within(square, 3), (low..high).contains(&square), "{square}");
                is_within(square, 3)
            })
            .count();
        // Four standard deviations.
        let bound = 4.0 * (0.95_f64 * 0.05 / f64::from(runs)).sqrt();
        assert!((within as f64 / f64::from(runs) - 0.95).abs() < bound, "{within}");
    }
}
