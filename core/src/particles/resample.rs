//! Resampling: drawing candidates in proportion to their weights.

use crate::numerics::ln_sum::ln_sum;
use crate::numerics::work;
use crate::particles::candidate::{Candidate, PART};
use crate::{Pose, Real};

/// Systematic resampling (Arulampalam et al. 2002, algorithm 2): one uniform number, positions (i + u)/N, each selects the first
/// index whose cumulative weight exceeds it. The weights must sum to one; positions beyond the sum, because of rounding, select
/// the last index with a weight above 0.
pub(crate) fn systematic<T: Real>(weights: impl Iterator<Item = T>, uniform: T, survivors: &mut [u16]) {
    let count = T::from_usize(survivors.len());
    let mut weights = weights.enumerate().filter(|&(_, weight)| weight > T::ZERO);
    // The sum over the previous parts, and the sum within this part so far.
    let (mut index, mut before, mut within) = (0, T::ZERO, T::ZERO);
    for (place, survivor) in survivors.iter_mut().enumerate() {
        let position = position(place, uniform, count);
        while before + within <= position {
            work::round();
            let Some((next, weight)) = weights.next() else { break };
            if next / PART != index / PART {
                (before, within) = (before + within, T::ZERO);
            }
            index = next;
            within += weight;
        }
        *survivor = index as u16;
    }
}

/// The position of survivor `place` of `count`.
pub(crate) fn position<T: Real>(place: usize, uniform: T, count: T) -> T {
    (T::from_usize(place) + uniform) / count
}

/// Draws one of a particle's children in proportion to their weights, with a uniform number. Returns its index among them and ln
/// of their total weight, which it gets. Unbiased: the expected measure is that of the children.
pub(crate) fn one_child<T: Real, P: Pose<Scalar = T>>(children: &[Candidate<P>], uniform: T) -> (usize, T) {
    let total = ln_sum(children.iter().map(|child| child.ln_weight));
    if !(total > T::NEG_INFINITY) {
        let drawn = (uniform * T::from_usize(children.len())).to_i32();
        return (usize::try_from(drawn).unwrap_or(0), T::NEG_INFINITY);
    }
    let mut cumulated = T::ZERO;
    let chosen = children.iter().position(|child| {
        cumulated += (child.ln_weight - total).exp();
        cumulated > uniform
    });
    let last = children.iter().rposition(|child| child.ln_weight > T::NEG_INFINITY);
    (chosen.or(last).unwrap_or(0), total)
}

#[cfg(test)]
mod tests {
    use super::{one_child, systematic};
    use crate::particles::candidate::{Candidate, effective_number};
    use crate::{Noise, PlanarPose};
    use serde_json::Value;
    use std::vec::Vec;

    fn candidates(weights: &[f64]) -> Vec<Candidate<PlanarPose<f64>>> {
        weights.iter().map(|w| Candidate { ln_weight: w.ln(), ..Candidate::ZERO }).collect()
    }

    /// The expected values are from an independent implementation.
    #[test]
    fn survivors_and_effective_number_agree_with_the_oracle() {
        let file = scphd_shared_data::oracle("systematic_resampling.json");
        let numbers =
            |value: &Value| -> Vec<f64> { value.as_array().unwrap().iter().flat_map(Value::as_f64).collect() };
        for case in file["cases"].as_array().unwrap() {
            let weights = numbers(&case["weights"]);
            let mut survivors: Vec<u16> = weights.iter().map(|_| 0).collect();
            systematic(weights.iter().copied(), case["u"].as_f64().unwrap(), &mut survivors);
            let expected: Vec<u16> = numbers(&case["indices"]).into_iter().map(|index| index as u16).collect();
            assert_eq!(survivors, expected);
            let effective = effective_number(&candidates(&weights));
            assert!((effective - case["ess"].as_f64().unwrap()).abs() < 1e-12);
        }
    }

    #[test]
    fn positions_take_the_first_exceeding_sum() {
        let mut survivors = [0; 4];
        systematic([0.1, 0.2, 0.3, 0.4].into_iter(), 0.25, &mut survivors);
        assert_eq!(survivors, [0, 2, 2, 3]);
        systematic([0.0, 0.0, 1.0, 0.0].into_iter(), 0.999, &mut survivors);
        assert_eq!(survivors, [2; 4]);
    }

    #[test]
    fn selection_among_children_is_unbiased() {
        let weights = [0.05, 0.15, 0.0, 0.3];
        let children = candidates(&weights);
        let mut noise = Noise::seeded(5);
        let mut drawn = [0.0; 4];
        let runs = 40_000;
        for _ in 0..runs {
            let (child, total) = one_child(&children, noise.uniform());
            drawn[child] += total.exp();
        }
        for (mean, weight) in drawn.iter().map(|sum| sum / f64::from(runs)).zip(weights) {
            // Five standard errors: values 0 and ½ have a standard deviation of at most ¼.
            assert!((mean - weight).abs() < 5.0 * 0.25 / f64::from(runs).sqrt(), "{mean} against {weight}");
        }
    }

    #[test]
    fn children_without_weight_are_drawn_evenly() {
        let children = candidates(&[0.0, 0.0]);
        assert_eq!(one_child(&children, 0.4), (0, f64::NEG_INFINITY));
        assert_eq!(one_child(&children, 0.6), (1, f64::NEG_INFINITY));
    }
}
