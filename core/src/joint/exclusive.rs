//! A measurement has one cause, and a feature causes one measurement at most: the responsibilities that respect both, by belief
//! propagation on the graph of features and measurements (Williams & Lau 2014).
//!
//! With the odds a_jz = p_D v_j N(z; ẑ_j, S_j) / ((1 − p_D v_j) λ_z), λ_z = κ + w_b, messages go to and fro:
//! μ_jz = a_jz / (1 + Σ_{z'≠z} a_jz' ν_z'j) and ν_zj = 1 / (1 + Σ_{j'≠j} μ_j'z). Where no two features want the same two
//! measurements the graph has no circle, and the shares are exact.

use super::claims::{Claim, Explained};
use super::state::Slot;
use crate::{Real, Vector};

/// Rounds of messages. A graph without circles is done after as many as its longest path has features, and what lies farther off
/// than this hardly matters.
const ROUNDS: usize = 8;

/// Shares of a measurement that sum to no more than this are settled.
const SETTLED: f64 = 1.001;

/// ln of the largest odds: such a claim leaves nothing to clutter, and sums of them stay finite in single precision.
const LN_ODDS_MAX: f64 = 40.0;

/// Fills in every claim's share, and of every measurement the share that no feature has. Given Σ ln(1 − p_D v), that nothing was
/// detected, ln of the likelihood of the scan, by Bethe's approximation: exact without circles.
pub(super) fn settle<T: Real, D: Vector<Scalar = T>>(
    slots: &mut [Slot<D>],
    explained: &mut [Explained<T>],
    ln_missed: T,
) -> T {
    explained.iter_mut().for_each(weigh);
    for _ in 0..ROUNDS {
        collect(slots, explained);
        explained.iter_mut().for_each(answer);
    }
    collect(slots, explained);
    let ln_1p = |x: T| (T::ONE + x).ln();
    let mut ln_evidence = ln_missed;
    for explained in explained {
        let wanted = explained.claims().iter().fold(T::ZERO, |sum, claim| sum + message(claim));
        explained.unexplained = T::ONE / (T::ONE + wanted);
        ln_evidence += explained.ln_unexplained + ln_1p(wanted);
        for claim in explained.claims_mut() {
            let had = claim.odds * claim.answer;
            claim.share = had / (T::ONE + claim.others + had);
            ln_evidence -= ln_1p(message(claim) * claim.answer);
        }
        share_out(explained);
    }
    slots.iter().fold(ln_evidence, |sum, slot| sum + ln_1p(slot.claimed))
}

/// Scales shares that sum to more than the one measurement that there is: those of messages that have not settled. Each feature's sum to one
/// at most as they are, and to less so.
fn share_out<T: Real>(explained: &mut Explained<T>) {
    let all = explained.claims().iter().fold(T::ZERO, |sum, claim| sum + claim.share);
    if all > T::from_f64(SETTLED) {
        explained.claims_mut().iter_mut().for_each(|claim| claim.share /= all);
    }
}

/// Fills in the odds of a measurement's claims. Where they would be too large, clutter is taken for denser.
fn weigh<T: Real>(explained: &mut Explained<T>) {
    let most = explained.claims().iter().fold(T::NEG_INFINITY, |most, claim| most.at_least(claim.ln_likelihood));
    explained.ln_unexplained = explained.ln_unexplained.at_least(most - T::from_f64(LN_ODDS_MAX));
    let ln_unexplained = explained.ln_unexplained;
    for claim in explained.claims_mut() {
        claim.odds = (claim.ln_likelihood - ln_unexplained).exp();
        claim.answer = T::ONE;
    }
}

/// Σ a ν of every feature; and for every claim, that sum over the feature's other claims: those before it and those behind it, for
/// in a difference they would be lost beside a large one.
fn collect<T: Real, D: Vector<Scalar = T>>(slots: &mut [Slot<D>], explained: &mut [Explained<T>]) {
    slots.iter_mut().for_each(|slot| slot.claimed = T::ZERO);
    for claim in explained.iter_mut().flat_map(Explained::claims_mut) {
        let Some(slot) = slots.get_mut(usize::from(claim.feature)) else { continue };
        claim.others = slot.claimed;
        slot.claimed += claim.odds * claim.answer;
    }
    slots.iter_mut().for_each(|slot| slot.claimed = T::ZERO);
    for claim in explained.iter_mut().rev().flat_map(Explained::claims_mut) {
        let Some(slot) = slots.get_mut(usize::from(claim.feature)) else { continue };
        claim.others += slot.claimed;
        slot.claimed += claim.odds * claim.answer;
    }
}

/// μ: how much a feature wants a measurement, given what else it may have caused.
fn message<T: Real>(claim: &Claim<T>) -> T {
    claim.odds / (T::ONE + claim.others)
}

/// ν: what a measurement answers each feature, given the others that want it.
fn answer<T: Real>(explained: &mut Explained<T>) {
    for place in 0..explained.claims().len() {
        let others = explained.claims().iter().enumerate().filter(|&(other, _)| other != place);
        let wanted = others.fold(T::ZERO, |sum, (_, claim)| sum + message(claim));
        if let Some(claim) = explained.claims_mut().get_mut(place) {
            claim.answer = T::ONE / (T::ONE + wanted);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::claims::{Claim, Explained};
    use super::super::existence::Existence;
    use super::super::state::Slot;
    use super::settle;
    use crate::Noise;
    use nalgebra::Vector2;
    use std::vec;
    use std::vec::Vec;

    /// Odds by feature and measurement, over clutter of one.
    fn settled(odds: &[&[f64]]) -> (Vec<Vec<f64>>, f64) {
        let mut slots = vec![Slot::<Vector2<f64>> { existence: Existence::NONE, ..Slot::ZERO }; odds.len()];
        let mut explained = vec![Explained::ZERO; odds[0].len()];
        for (z, explained) in explained.iter_mut().enumerate() {
            explained.start(0.0);
            for (feature, odds) in odds.iter().enumerate().filter(|(_, odds)| odds[z] > 0.0) {
                explained.claim(Claim::new(feature as u16, odds[z].ln()));
            }
        }
        let ln_evidence = settle(&mut slots, &mut explained, 0.0);
        let mut shares = vec![vec![0.0; odds[0].len()]; odds.len()];
        for (z, explained) in explained.iter().enumerate() {
            let all: f64 = explained.claims().iter().map(|claim| claim.share).sum();
            assert!((all + explained.unexplained - 1.0).abs() < 1e-2, "{all} {}", explained.unexplained);
            explained.claims().iter().for_each(|claim| shares[usize::from(claim.feature)][z] = claim.share);
        }
        (shares, ln_evidence)
    }

    /// Features that all want the same few measurements leave messages to and fro that do not settle in these rounds.
    #[test]
    fn no_measurement_is_shared_out_twice() {
        let mut draws = Noise::seeded(5);
        let mut unsettled = 0;
        for _ in 0..200 {
            let odds: [[f64; 7]; 11] =
                core::array::from_fn(|_| core::array::from_fn(|_| (6.0 * draws.normal::<f64>()).exp()));
            let rows = odds.each_ref().map(|row| &row[..]);
            let mut slots = vec![Slot::<Vector2<f64>> { existence: Existence::NONE, ..Slot::ZERO }; 11];
            let mut explained = vec![Explained::ZERO; 7];
            for (z, explained) in explained.iter_mut().enumerate() {
                explained.start(0.0);
                rows.iter().enumerate().for_each(|(j, odds)| explained.claim(Claim::new(j as u16, odds[z].ln())));
            }
            settle(&mut slots, &mut explained, 0.0);
            let mut of_features = [0.0; 11];
            for explained in &explained {
                let all: f64 = explained.claims().iter().map(|claim| claim.share).sum();
                assert!(all <= 1.0 + 1e-3, "{all}");
                unsettled += usize::from(all + explained.unexplained > 1.01);
                explained.claims().iter().for_each(|claim| of_features[usize::from(claim.feature)] += claim.share);
            }
            assert!(of_features.iter().all(|&sum| sum <= 1.0 + 1e-12), "{of_features:?}");
        }
        assert!(unsettled > 20, "{unsettled}: this tests nothing");
    }

    /// The same by going through all assignments.
    fn by_enumeration(odds: &[&[f64]]) -> (Vec<Vec<f64>>, f64) {
        fn walk(odds: &[&[f64]], feature: usize, taken: &mut Vec<Option<usize>>, sum: &mut f64, by: &mut [Vec<f64>]) {
            if feature == odds.len() {
                let weight = taken.iter().enumerate().map(|(j, z)| z.map_or(1.0, |z| odds[j][z])).product::<f64>();
                *sum += weight;
                taken.iter().enumerate().for_each(|(j, z)| z.iter().for_each(|&z| by[j][z] += weight));
                return;
            }
            for z in std::iter::once(None).chain((0..odds[0].len()).map(Some)) {
                if z.is_none() || !taken.contains(&z) {
                    taken.push(z);
                    walk(odds, feature + 1, taken, sum, by);
                    taken.pop();
                }
            }
        }
        let mut by = vec![vec![0.0; odds[0].len()]; odds.len()];
        let mut sum = 0.0;
        walk(odds, 0, &mut Vec::new(), &mut sum, &mut by);
        by.iter_mut().flatten().for_each(|share| *share /= sum);
        (by, sum.ln())
    }

    fn largest_difference(odds: &[&[f64]]) -> (f64, f64) {
        let ((shares, ln_evidence), (exact, exact_ln)) = (settled(odds), by_enumeration(odds));
        let off = shares.iter().flatten().zip(exact.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        (off, (ln_evidence - exact_ln).abs())
    }

    #[test]
    fn without_circles_it_is_the_sum_over_all_assignments() {
        let cases: [&[&[f64]]; 4] = [
            &[&[5.0]],
            &[&[5.0, 0.3, 0.0], &[0.0, 2.0, 0.7]],
            &[&[40.0, 3.0, 0.0, 0.0], &[0.0, 6.0, 0.5, 0.0], &[0.0, 0.0, 9.0, 100.0]],
            &[&[3.0], &[4.0], &[0.1]],
        ];
        for odds in cases {
            let (shares, ln_evidence) = largest_difference(odds);
            assert!(shares < 1e-12 && ln_evidence < 1e-12, "{odds:?}: {shares} {ln_evidence}");
        }
    }

    #[test]
    fn with_circles_it_is_near() {
        let (shares, ln_evidence) = largest_difference(&[&[8.0, 3.0], &[2.0, 6.0]]);
        assert!(shares < 0.06 && ln_evidence < 0.2, "{shares} {ln_evidence}");
    }

    #[test]
    fn one_feature_has_one_measurement() {
        // Both lie on it, and clutter is a thousand times less likely: without exclusion it would have both.
        let (shares, _) = settled(&[&[1000.0, 1000.0]]);
        assert!((shares[0][0] - 1000.0 / 2001.0).abs() < 1e-12);
    }

    #[test]
    fn huge_odds_stay_numbers() {
        let mut slots = vec![Slot::<Vector2<f32>>::ZERO; 2];
        let mut explained = vec![Explained::<f32>::ZERO; 2];
        for explained in &mut explained {
            explained.start(f32::NEG_INFINITY);
            (0..2).for_each(|feature| explained.claim(Claim::new(feature, 500.0 + f32::from(feature))));
        }
        let ln_evidence = settle(&mut slots, &mut explained, 0.0);
        assert!(ln_evidence.is_finite());
        for explained in &explained {
            let all: f32 = explained.claims().iter().map(|claim| claim.share).sum();
            assert!((all - 1.0).abs() < 1e-3, "{explained:?}");
        }
    }
}
