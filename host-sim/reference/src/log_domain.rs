//! Sums of numbers in the log domain.

/// ln Σ exp(term), in two passes: the largest term, then the sum relative to it. Returns −∞ without terms, or if all are zero.
pub(super) fn log_sum_exp(terms: &[f64]) -> f64 {
    let largest = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if largest == f64::NEG_INFINITY {
        return f64::NEG_INFINITY;
    }
    // Below this, exp is zero in double precision, and slow.
    let relative: f64 = terms.iter().map(|term| term - largest).filter(|&term| term > -746.0).map(f64::exp).sum();
    largest + relative.ln()
}

/// The weights divided by their sum, all as logarithms; `None` if every weight is zero.
pub(super) fn normalised(ln_weights: &[f64]) -> Option<Vec<f64>> {
    let largest = ln_weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if largest == f64::NEG_INFINITY {
        return None;
    }
    // The largest is subtracted first: the logarithm of a sum near e⁻⁵⁰⁰⁰ would lose four digits.
    let relative: Vec<f64> = ln_weights.iter().map(|weight| weight - largest).collect();
    let total = log_sum_exp(&relative);
    Some(relative.iter().map(|weight| weight - total).collect())
}
