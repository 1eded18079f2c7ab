//! `PruneAndMerge` of appendix A: Vo & Ma 2006, table II.

use super::Config;
use super::gaussian::{Component, inverse, minus, outer, plus, quadratic, scaled, sum, symmetrised};
use std::cmp::Ordering;

/// Prunes, merges and caps a mixture; the result is in the order of [`heaviest_first`].
pub(super) fn prune_and_merge(mixture: &[Component], config: &Config) -> Vec<Component> {
    let mut remaining: Vec<Component> = mixture
        .iter()
        .copied()
        // A weight of exactly zero (missed at p_D = 1) is no component, whatever the bound.
        .filter(|c| c.ln_weight >= config.prune_weight.ln() && c.ln_weight > f64::NEG_INFINITY)
        .collect();
    remaining.sort_by(heaviest_first);

    let mut merged = Vec::new();
    while let Some(&heaviest) = remaining.first() {
        let (close, far): (Vec<_>, Vec<_>) = remaining.into_iter().partition(|c| {
            let offset = minus(c.mean, heaviest.mean);
            quadratic(&inverse(&c.covariance), offset) <= config.merge_distance
        });
        merged.push(merge(&close));
        remaining = far;
    }
    merged.sort_by(heaviest_first);
    merged.truncate(config.max_components);
    merged
}

/// The total order of the reduction: by ln w in steps of 2⁻¹⁶, descending, then by x, then by y,
/// ascending. The steps keep the last bit of a sum from deciding among weights that are equal on paper.
pub(super) fn heaviest_first(a: &Component, b: &Component) -> Ordering {
    let step = |c: &Component| (c.ln_weight * 65_536.0 + 0.5).floor();
    step(b).total_cmp(&step(a)).then(a.mean[0].total_cmp(&b.mean[0])).then(a.mean[1].total_cmp(&b.mean[1]))
}

/// The Gaussian with the mass, mean and spread of all components together.
fn merge(components: &[Component]) -> Component {
    // Relative to the heaviest, which comes first, no weight is lost to underflow.
    let unit = components[0].ln_weight;
    let relative = |c: &Component| (c.ln_weight - unit).exp();
    let total: f64 = components.iter().map(relative).sum();
    let mean = components.iter().fold([0.0; 2], |mean, c| plus(mean, c.mean.map(|x| relative(c) / total * x)));
    let covariance = components.iter().fold([[0.0; 2]; 2], |spread, c| {
        let around = sum(&c.covariance, &outer(minus(c.mean, mean)));
        sum(&spread, &scaled(relative(c) / total, &around))
    });
    Component { ln_weight: unit + total.ln(), mean, covariance: symmetrised(&covariance) }
}

#[cfg(test)]
mod tests {
    use super::super::tests::CONFIG;
    use super::*;

    fn at(weight: f64, x: f64, y: f64) -> Component {
        Component { ln_weight: weight.ln(), mean: [x, y], covariance: [[0.5, 0.1], [0.1, 0.3]] }
    }

    fn apart(limit: usize) -> Config {
        Config { prune_weight: 0.01, merge_distance: 1.0, max_components: limit, ..CONFIG }
    }

    #[test]
    fn bound_itself_is_kept_and_zero_is_not() {
        let mixture = [at(0.01, 0.0, 0.0), at(0.0099, 9.0, 0.0), at(0.0, 18.0, 0.0)];
        assert_eq!(prune_and_merge(&mixture, &apart(9)), vec![mixture[0]]);
        let no_bound = Config { prune_weight: 0.0, ..apart(9) };
        assert_eq!(prune_and_merge(&mixture, &no_bound), mixture[..2].to_vec());
    }

    #[test]
    fn cap_keeps_the_heaviest() {
        let mixture = [at(0.2, 0.0, 0.0), at(0.9, 9.0, 0.0), at(0.4, 18.0, 0.0)];
        assert_eq!(prune_and_merge(&mixture, &apart(2)), vec![mixture[1], mixture[2]]);
    }

    #[test]
    fn weights_equal_to_rounding_are_ordered_by_place() {
        let mixture = [at(0.3 * (1.0 + 1e-13), 9.0, 0.0), at(0.3, 0.0, 9.0), at(0.3 * (1.0 + 2e-13), 0.0, 18.0)];
        let order = [mixture[1], mixture[2], mixture[0]];
        assert_eq!(prune_and_merge(&mixture, &apart(9)), order.to_vec());
    }

    #[test]
    fn distance_is_measured_with_the_lighter_components_covariance() {
        let wide = Component { covariance: [[25.0, 0.0], [0.0, 25.0]], ..at(0.4, 3.0, 0.0) };
        assert_eq!(prune_and_merge(&[at(0.9, 0.0, 0.0), wide], &apart(9)).len(), 1);
        let narrow = at(0.4, 3.0, 0.0);
        let heavy_and_wide = Component { ln_weight: 0.9f64.ln(), mean: [0.0, 0.0], ..wide };
        assert_eq!(prune_and_merge(&[heavy_and_wide, narrow], &apart(9)).len(), 2);
    }

    #[test]
    fn merging_keeps_mass_mean_and_spread() {
        let mixture = [at(0.5, 0.0, 0.0), at(0.3, 0.3, -0.2), at(0.2, -0.1, 0.4)];
        let reduced = prune_and_merge(&mixture, &apart(9));
        assert_eq!(reduced.len(), 1);
        assert!((reduced[0].weight() - 1.0).abs() < 1e-14);
        // E[m mᵀ] of the mixture and of the one Gaussian.
        for row in 0..2 {
            let mean: f64 = mixture.iter().map(|c| c.weight() * c.mean[row]).sum();
            assert!((reduced[0].mean[row] - mean).abs() < 1e-14);
            for column in 0..2 {
                let second: f64 = mixture
                    .iter()
                    .map(|c| c.weight() * (c.covariance[row][column] + c.mean[row] * c.mean[column]))
                    .sum();
                let one = reduced[0].covariance[row][column] + reduced[0].mean[row] * reduced[0].mean[column];
                assert!((second - one).abs() < 1e-14);
            }
        }
    }
}
