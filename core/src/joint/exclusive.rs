//! A measurement has one cause, and a feature causes one measurement at most: the responsibilities that respect both, by belief
//! propagation on the graph of features and measurements (Williams & Lau 2014).
//!
//! With the odds a_jz = p_D v_j N(z; ẑ_j, S_j) / ((1 − p_D v_j) λ_z), λ_z = κ + w_b, messages go to and fro:
//! μ_jz = a_jz / (1 + Σ_{z'≠z} a_jz' ν_z'j) and ν_zj = 1 / (1 + Σ_{j'≠j} μ_j'z). Where no two features want the same two
//! measurements the graph has no circle, and the shares are exact.

use super::claims::{Claim, Explained};
use super::movers::{MOVES, Movers, Tracks};
use super::state::Slot;
use crate::{Pose, PositionOf, Real};

/// Rounds of messages. A graph without circles is done after as many as its longest path has features, and what lies farther off
/// than this hardly matters.
const ROUNDS: usize = 8;

/// Shares of a measurement that sum to no more than this are settled.
const SETTLED: f64 = 1.001;

/// ln of the largest odds: such a claim leaves nothing to clutter, and sums of them stay finite in single precision.
const LN_ODDS_MAX: f64 = 40.0;

/// Fills in every claim's share, and of every measurement the share that no feature has. Given Σ ln(1 − p_D v), that nothing was
/// detected, ln of the likelihood of the scan, by Bethe's approximation: exact without circles.
///
/// A mover and the static feature that it may be instead are one in this: their claims on a measurement are two ways of one cause.
pub(super) fn settle<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    slots: &mut [Slot<PositionOf<P>>],
    explained: &mut [Explained<T>],
    movers: &mut V,
    ln_missed: T,
) -> T {
    explained.iter_mut().for_each(weigh);
    for _ in 0..ROUNDS {
        collect::<T, P, V>(slots, explained, movers);
        explained.iter_mut().for_each(|explained| answer::<T, P, V>(explained, movers));
    }
    collect::<T, P, V>(slots, explained, movers);
    let ln_1p = |x: T| (T::ONE + x).ln();
    let mut ln_evidence = ln_missed;
    for explained in explained {
        let wanted = explained.claims().iter().fold(T::ZERO, |sum, claim| sum + message(claim));
        explained.unexplained = T::ONE / (T::ONE + wanted);
        ln_evidence += explained.ln_unexplained + ln_1p(wanted);
        for place in 0..explained.claims().len() {
            let of_all = |of: fn(&Claim<T>) -> T| of_cause::<T, P, V>(explained.claims(), movers, place, of);
            let (had, wants) =
                (of_all(|claim| claim.odds * claim.answer), of_all(|claim| message(claim) * claim.answer));
            let is_first = is_first_of_cause::<T, P, V>(explained.claims(), movers, place);
            let Some(claim) = explained.claims_mut().get_mut(place) else { break };
            claim.share = claim.odds * claim.answer / (T::ONE + claim.others + had);
            if is_first {
                ln_evidence -= ln_1p(wants);
            }
        }
        share_out(explained);
    }
    let ln_evidence = slots.iter().fold(ln_evidence, |sum, slot| sum + ln_1p(slot.claimed));
    movers.kept().iter().fold(ln_evidence, |sum, mover| sum + ln_1p(mover.claimed))
}

/// What a claimant is, whichever kind it is: of a mover, the static feature that it may be instead, if there is such a one.
fn cause<P: Pose, V: Movers<P>>(movers: &V, claimant: u16) -> u16 {
    if !V::MOVE || claimant & MOVES == 0 {
        return claimant;
    }
    let mover = movers.kept().get(usize::from(claimant & !MOVES));
    mover.and_then(|mover| mover.static_place()).unwrap_or(claimant)
}

/// Sums over the claims of the cause of one claim.
fn of_cause<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    claims: &[Claim<T>],
    movers: &V,
    place: usize,
    of: impl Fn(&Claim<T>) -> T,
) -> T {
    let Some(claim) = claims.get(place) else { return T::ZERO };
    if !V::MOVE {
        return of(claim);
    }
    let own = cause(movers, claim.feature);
    claims.iter().filter(|other| cause(movers, other.feature) == own).fold(T::ZERO, |sum, other| sum + of(other))
}

/// Whether no claim before it is of the same cause.
fn is_first_of_cause<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    claims: &[Claim<T>],
    movers: &V,
    place: usize,
) -> bool {
    let Some(claim) = claims.get(place).filter(|_| V::MOVE) else { return true };
    let own = cause(movers, claim.feature);
    !claims.iter().take(place).any(|other| cause(movers, other.feature) == own)
}

/// Where Σ a ν of a cause is summed.
fn claimed<'c, T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    slots: &'c mut [Slot<PositionOf<P>>],
    tracks: &'c mut Option<Tracks<'_, P>>,
    cause: u16,
) -> Option<&'c mut T> {
    if V::MOVE && cause & MOVES != 0 {
        let mover = tracks.as_mut().and_then(|tracks| tracks.kept_mut().get_mut(usize::from(cause & !MOVES)));
        return mover.map(|mover| &mut mover.claimed);
    }
    slots.get_mut(usize::from(cause)).map(|slot| &mut slot.claimed)
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

/// Σ a ν of every feature; and for every claim, that sum over what its cause claims of other measurements: those before it and those behind
/// it, for in a difference they would be lost beside a large one.
fn collect<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    slots: &mut [Slot<PositionOf<P>>],
    explained: &mut [Explained<T>],
    movers: &mut V,
) {
    forget_claimed::<T, P, V>(slots, movers);
    for explained in explained.iter_mut() {
        add_claimed::<T, P, V>(slots, explained, movers, |claim, before| claim.others = before);
    }
    forget_claimed::<T, P, V>(slots, movers);
    for explained in explained.iter_mut().rev() {
        add_claimed::<T, P, V>(slots, explained, movers, |claim, behind| claim.others += behind);
    }
}

fn forget_claimed<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(slots: &mut [Slot<PositionOf<P>>], movers: &mut V) {
    slots.iter_mut().for_each(|slot| slot.claimed = T::ZERO);
    if let Some(mut tracks) = movers.tracks() {
        tracks.kept_mut().iter_mut().for_each(|mover| mover.claimed = T::ZERO);
    }
}

/// Tells every claim of a measurement what its cause has claimed of others so far, then adds them to that.
fn add_claimed<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    slots: &mut [Slot<PositionOf<P>>],
    explained: &mut Explained<T>,
    movers: &mut V,
    tell: impl Fn(&mut Claim<T>, T),
) {
    for claim in explained.claims_mut() {
        let cause = cause(movers, claim.feature);
        if let Some(&mut so_far) = claimed::<T, P, V>(slots, &mut movers.tracks(), cause) {
            tell(claim, so_far);
        }
    }
    for claim in explained.claims() {
        let cause = cause(movers, claim.feature);
        if let Some(claimed) = claimed::<T, P, V>(slots, &mut movers.tracks(), cause) {
            *claimed += claim.odds * claim.answer;
        }
    }
}

/// μ: how much a feature wants a measurement, given what else it may have caused.
fn message<T: Real>(claim: &Claim<T>) -> T {
    claim.odds / (T::ONE + claim.others)
}

/// ν: what a measurement answers each feature, given the others that want it.
fn answer<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(explained: &mut Explained<T>, movers: &V) {
    for place in 0..explained.claims().len() {
        let own = explained.claims().get(place).map_or(0, |claim| cause(movers, claim.feature));
        let others = explained.claims().iter().enumerate();
        let others =
            others.filter(|&(other, claim)| other != place && (!V::MOVE || cause(movers, claim.feature) != own));
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
    use super::super::movers::NoMovers;
    use super::super::state::Slot;
    use crate::{Noise, PlanarPose, Real};
    use nalgebra::Vector2;
    use std::vec;
    use std::vec::Vec;

    fn settle<T: Real>(slots: &mut [Slot<Vector2<T>>], explained: &mut [Explained<T>], ln_missed: T) -> T {
        super::settle::<T, PlanarPose<T>, _>(slots, explained, &mut NoMovers, ln_missed)
    }

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
