//! `PruneAndMerge` of appendix A: Vo & Ma 2006, table II.

use super::algebra::{inverse, minus, outer, plus, quadratic, scaled, sum, symmetrised};
use super::config::Config;
use super::gaussian::Component;
use std::cmp::Ordering;

/// Prunes, merges and caps a mixture; the result is in the order of [`heaviest_first`].
pub(super) fn prune_and_merge<const N: usize>(mixture: &[Component<N>], config: &Config) -> Vec<Component<N>> {
    let mut remaining: Vec<Component<N>> =
        mixture.iter().copied().filter(|c| heavy_enough(c, config.prune_weight)).collect();
    remaining.sort_by(heaviest_first);
    let mut merged = greedy(remaining, config.merge_distance);
    merged.sort_by(heaviest_first);
    merged.truncate(config.max_components);
    merged
}

/// Whether a component survives pruning. A weight of zero (missed with p_D = 1) never survives.
pub(super) fn heavy_enough<const N: usize>(component: &Component<N>, prune_weight: f64) -> bool {
    component.ln_weight >= prune_weight.ln() && component.ln_weight > f64::NEG_INFINITY
}

/// The total order of the reduction: by ln w in steps of 2⁻¹⁶, descending, then by the coordinates of the mean in their order,
/// ascending. With the steps, rounding errors do not decide between equal weights.
pub(super) fn heaviest_first<const N: usize>(a: &Component<N>, b: &Component<N>) -> Ordering {
    let step = |c: &Component<N>| (c.ln_weight * 65_536.0 + 0.5).floor();
    let by_weight = step(b).total_cmp(&step(a));
    a.mean.iter().zip(&b.mean).fold(by_weight, |order, (a, b)| order.then(a.total_cmp(b)))
}

/// Vo & Ma: the heaviest component absorbs all that are close to it, by their own covariances.
fn greedy<const N: usize>(mut remaining: Vec<Component<N>>, merge_distance: f64) -> Vec<Component<N>> {
    let mut merged = Vec::new();
    while let Some(&heaviest) = remaining.first() {
        let (close, far): (Vec<_>, Vec<_>) = remaining.into_iter().partition(|c| {
            let offset = minus(c.mean, heaviest.mean);
            quadratic(&inverse(&c.covariance), offset) <= merge_distance
        });
        merged.push(merge(&close));
        remaining = far;
    }
    merged
}

/// The Gaussian with the mass, mean and covariance of all components together.
fn merge<const N: usize>(components: &[Component<N>]) -> Component<N> {
    // Weights are relative to the first, heaviest one, so that none is lost by underflow.
    let unit = components[0].ln_weight;
    let relative = |c: &Component<N>| (c.ln_weight - unit).exp();
    let total: f64 = components.iter().map(relative).sum();
    let mean = components.iter().fold([0.0; N], |mean, c| plus(mean, c.mean.map(|x| relative(c) / total * x)));
    let covariance = components.iter().fold([[0.0; N]; N], |spread, c| {
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
    fn weights_at_the_bound_are_kept_and_zero_is_not() {
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
    fn weights_equal_up_to_rounding_are_ordered_by_position() {
        let mixture = [at(0.3 * (1.0 + 1e-13), 9.0, 0.0), at(0.3, 0.0, 9.0), at(0.3 * (1.0 + 2e-13), 0.0, 18.0)];
        let order = [mixture[1], mixture[2], mixture[0]];
        assert_eq!(prune_and_merge(&mixture, &apart(9)), order.to_vec());
    }

    fn moving(weight: f64, x: f64, velocity: f64) -> Component<4> {
        let covariance = [[0.9, 0.2, 0.3, -0.1], [0.2, 0.7, 0.05, 0.4], [0.3, 0.05, 0.8, 0.1], [-0.1, 0.4, 0.1, 1.1]];
        Component { ln_weight: weight.ln(), mean: [x, 1.0, velocity, -velocity], covariance }
    }

    #[test]
    fn velocity_keeps_moving_components_apart() {
        assert_eq!(prune_and_merge(&[moving(0.5, 0.0, 3.0), moving(0.3, 0.0, -3.0)], &apart(9)).len(), 2);
        // For equal weights and positions, the lower velocity is first.
        let order = [moving(0.3, 0.0, -3.0), moving(0.3, 0.0, 3.0)];
        assert_eq!(prune_and_merge(&[order[1], order[0]], &apart(9)), order);
    }
}
