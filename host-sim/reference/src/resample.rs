//! `Resample` of appendix A, and the selection among the samples of each particle.

use super::draws::Draws;
use super::log_domain::log_sum_exp;

/// The surviving candidates and their weights.
#[derive(Debug, Clone, PartialEq)]
pub struct Selection {
    /// Whether N_eff required a resampling over all candidates.
    pub resampled: bool,
    /// For each of the N particles the candidate that it continues.
    pub survivors: Vec<usize>,
    /// ln ζ of each particle.
    pub ln_weights: Vec<f64>,
}

/// N_eff = 1/Σ ζ² of normalised weights.
pub(super) fn effective_number(ln_weights: &[f64]) -> f64 {
    1.0 / ln_weights.iter().map(|w| (2.0 * w).exp()).sum::<f64>()
}

/// Reduces the candidates, whose weights are normalised, to `particles` survivors: by systematic resampling if
/// `N_eff < threshold · C`, otherwise one candidate for every particle; without random numbers if each particle has only one.
pub(super) fn select(
    ln_weights: &[f64],
    n_eff: f64,
    particles: usize,
    threshold: f64,
    draws: &mut dyn Draws,
) -> Selection {
    let candidates = ln_weights.len();
    let samples = candidates / particles;
    if n_eff < threshold * candidates as f64 {
        let weights: Vec<f64> = ln_weights.iter().map(|w| w.exp()).collect();
        Selection {
            resampled: true,
            survivors: systematic(&weights, particles, draws.uniform()),
            ln_weights: vec![-(particles as f64).ln(); particles],
        }
    } else if samples > 1 {
        let (survivors, ln_weights) = ln_weights
            .chunks(samples)
            .enumerate()
            .map(|(parent, children)| {
                let (child, total) = one_of(children, draws.uniform());
                (parent * samples + child, total)
            })
            .unzip();
        Selection { resampled: false, survivors, ln_weights }
    } else {
        Selection { resampled: false, survivors: (0..particles).collect(), ln_weights: ln_weights.to_vec() }
    }
}

/// Systematic resampling (Arulampalam et al. 2002, algorithm 2) with one uniform number: for each position (i + u)/N the first
/// candidate whose cumulative weight exceeds it.
fn systematic(weights: &[f64], count: usize, uniform: f64) -> Vec<usize> {
    (0..count).map(|i| first_above(weights, (i as f64 + uniform) / count as f64)).collect()
}

/// One of a particle's candidates, drawn in proportion to weight, and the logarithm of their total weight.
fn one_of(ln_weights: &[f64], uniform: f64) -> (usize, f64) {
    let total = log_sum_exp(ln_weights);
    if total == f64::NEG_INFINITY {
        return ((uniform * ln_weights.len() as f64) as usize, total);
    }
    let shares: Vec<f64> = ln_weights.iter().map(|w| (w - total).exp()).collect();
    (first_above(&shares, uniform), total)
}

/// The first index whose cumulative weight exceeds `position`; if because of rounding there is none, the last one with a positive
/// weight.
fn first_above(weights: &[f64], position: f64) -> usize {
    let mut cumulated = 0.0;
    let mut last = 0;
    for (index, &weight) in weights.iter().enumerate() {
        cumulated += weight;
        if weight > 0.0 {
            last = index;
        }
        if cumulated > position {
            return index;
        }
    }
    last
}

#[cfg(test)]
mod tests {
    use super::super::oracles;
    use super::*;

    /// Returns the listed uniform numbers, and panics after the last.
    struct Listed<'a>(&'a [f64]);

    impl Draws for Listed<'_> {
        fn normal(&mut self) -> f64 {
            panic!("a selection draws no normal number")
        }

        fn uniform(&mut self) -> f64 {
            let (first, rest) = self.0.split_first().expect("no more draws");
            self.0 = rest;
            *first
        }
    }

    fn ln(weights: &[f64]) -> Vec<f64> {
        weights.iter().map(|w| w.ln()).collect()
    }

    #[test]
    fn systematic_oracle() {
        let oracle = scphd_shared_data::oracle("systematic_resampling.json");
        for case in oracle["cases"].as_array().expect("cases") {
            let weights = oracles::numbers(&case["weights"]);
            let expected: Vec<usize> = oracles::numbers(&case["indices"]).iter().map(|index| *index as usize).collect();
            let uniform = case["u"].as_f64().expect("u");
            assert_eq!(systematic(&weights, weights.len(), uniform), expected);
            let n_eff = effective_number(&ln(&weights));
            assert!((n_eff - case["ess"].as_f64().expect("ess")).abs() < 1e-12);
        }
    }

    #[test]
    fn single_candidates_survive_without_random_numbers() {
        let weights = ln(&[0.3, 0.7]);
        let selection = select(&weights, effective_number(&weights), 2, 0.1, &mut Listed(&[]));
        assert_eq!(selection.survivors, [0, 1]);
        assert_eq!(selection.ln_weights, weights);
    }

    #[test]
    fn candidates_of_weight_zero_are_drawn_evenly() {
        let weights = ln(&[0.0, 0.0, 0.0, 0.3, 0.3, 0.4]);
        let selection = select(&weights, effective_number(&weights), 2, 0.1, &mut Listed(&[0.67, 0.5]));
        assert_eq!(selection.survivors, [2, 4]);
        assert_eq!(selection.ln_weights[0], f64::NEG_INFINITY);
        assert!(selection.ln_weights[1].abs() < 1e-15);
    }

    #[test]
    fn rounding_never_selects_a_weightless_candidate() {
        assert_eq!(first_above(&[0.25, 0.75 - 1e-9, 0.0], 1.0 - 1e-12), 1);
        assert_eq!(first_above(&[0.0, 1.0], 0.0), 1);
    }
}
