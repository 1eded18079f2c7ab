//! Probabilistic data association by loopy belief propagation on the graph of landmarks and measurements (Williams & Lau 2014): a
//! measurement has one cause, and a landmark causes one measurement at most.
//!
//! With the odds a_jz = p_D v_j N(z; ẑ_j, S_j) / ((1 − p_D v_j) λ_z), λ_z = κ + w_b, messages go to and fro:
//! μ_jz = a_jz / (1 + Σ_{z'≠z} a_jz' ν_z'j) and ν_zj = 1 / (1 + Σ_{j'≠j} μ_j'z). Where no two features want the same two
//! measurements the graph has no circle, and the shares are exact.

use super::associations::{Association, AssociationRow};
use super::movers::{MOVES, Movers, Tracks};
use super::state::Landmark;
use crate::{Pose, PositionOf, Real};

/// Rounds of messages. A graph without circles is done after as many as its longest path has features, and what lies farther off
/// than this hardly matters.
const ROUNDS: usize = 8;

/// Shares of a measurement that sum to no more than this are settled.
const SETTLED: f64 = 1.001;

/// ln of the largest odds: such an association leaves nothing to clutter, and sums of them stay finite in single precision.
const LN_ODDS_MAX: f64 = 40.0;

/// Fills in every association's share, and of every measurement the share that no feature has. Given Σ ln(1 − p_D v), that nothing was
/// detected, ln of the likelihood of the scan, by Bethe's approximation: exact without circles.
///
/// A moving track and its static alternative are one object: at most one of them may have caused a measurement.
pub(super) fn marginals<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    landmarks: &mut [Landmark<PositionOf<P>>],
    explained: &mut [AssociationRow<T>],
    movers: &mut V,
    ln_missed: T,
) -> T {
    explained.iter_mut().for_each(set_odds);
    for _ in 0..ROUNDS {
        collect::<T, P, V>(landmarks, explained, movers);
        explained.iter_mut().for_each(|explained| send_nu::<T, P, V>(explained, movers));
    }
    collect::<T, P, V>(landmarks, explained, movers);
    let ln_1p = |x: T| (T::ONE + x).ln();
    let mut ln_evidence = ln_missed;
    for explained in explained {
        let wanted = explained.associations().iter().fold(T::ZERO, |sum, association| sum + mu(association));
        explained.unexplained = T::ONE / (T::ONE + wanted);
        ln_evidence += explained.ln_unexplained + ln_1p(wanted);
        for place in 0..explained.associations().len() {
            let of_all =
                |of: fn(&Association<T>) -> T| of_cause::<T, P, V>(explained.associations(), movers, place, of);
            let (had, wants) = (
                of_all(|association| association.odds * association.nu),
                of_all(|association| mu(association) * association.nu),
            );
            let is_first = is_first_of_cause::<T, P, V>(explained.associations(), movers, place);
            let Some(association) = explained.associations_mut().get_mut(place) else { break };
            association.share = association.odds * association.nu / (T::ONE + association.cavity_sum + had);
            if is_first {
                ln_evidence -= ln_1p(wants);
            }
        }
        normalise(explained);
    }
    let ln_evidence = landmarks.iter().fold(ln_evidence, |sum, slot| sum + ln_1p(slot.claimed));
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

/// Sums over the associations of the cause of one association.
fn of_cause<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    associations: &[Association<T>],
    movers: &V,
    place: usize,
    of: impl Fn(&Association<T>) -> T,
) -> T {
    let Some(association) = associations.get(place) else { return T::ZERO };
    if !V::MOVE {
        return of(association);
    }
    let own = cause(movers, association.feature);
    associations.iter().filter(|other| cause(movers, other.feature) == own).fold(T::ZERO, |sum, other| sum + of(other))
}

/// Whether no association before it is of the same cause.
fn is_first_of_cause<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    associations: &[Association<T>],
    movers: &V,
    place: usize,
) -> bool {
    let Some(association) = associations.get(place).filter(|_| V::MOVE) else { return true };
    let own = cause(movers, association.feature);
    !associations.iter().take(place).any(|other| cause(movers, other.feature) == own)
}

/// Where Σ a ν of a cause is summed.
fn claimed<'c, T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    landmarks: &'c mut [Landmark<PositionOf<P>>],
    tracks: &'c mut Option<Tracks<'_, P>>,
    cause: u16,
) -> Option<&'c mut T> {
    if V::MOVE && cause & MOVES != 0 {
        let mover = tracks.as_mut().and_then(|tracks| tracks.kept_mut().get_mut(usize::from(cause & !MOVES)));
        return mover.map(|mover| &mut mover.claimed);
    }
    landmarks.get_mut(usize::from(cause)).map(|slot| &mut slot.claimed)
}

/// Scales shares that sum to more than the one measurement that there is: those of messages that have not settled. Each feature's sum to one
/// at most as they are, and to less so.
fn normalise<T: Real>(explained: &mut AssociationRow<T>) {
    let all = explained.associations().iter().fold(T::ZERO, |sum, association| sum + association.share);
    if all > T::from_f64(SETTLED) {
        explained.associations_mut().iter_mut().for_each(|association| association.share /= all);
    }
}

/// Fills in the odds of a measurement's associations. Where they would be too large, clutter is taken for denser.
fn set_odds<T: Real>(explained: &mut AssociationRow<T>) {
    let most = explained
        .associations()
        .iter()
        .fold(T::NEG_INFINITY, |most, association| most.at_least(association.ln_likelihood));
    explained.ln_unexplained = explained.ln_unexplained.at_least(most - T::from_f64(LN_ODDS_MAX));
    let ln_unexplained = explained.ln_unexplained;
    for association in explained.associations_mut() {
        association.odds = (association.ln_likelihood - ln_unexplained).exp();
        association.nu = T::ONE;
    }
}

/// Σ a ν of every feature; and for every association, that sum over its cause's associations with other measurements: those before it and those behind
/// it, for in a difference they would be lost beside a large one.
fn collect<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    landmarks: &mut [Landmark<PositionOf<P>>],
    explained: &mut [AssociationRow<T>],
    movers: &mut V,
) {
    forget_claimed::<T, P, V>(landmarks, movers);
    for explained in explained.iter_mut() {
        add_claimed::<T, P, V>(landmarks, explained, movers, |association, before| association.cavity_sum = before);
    }
    forget_claimed::<T, P, V>(landmarks, movers);
    for explained in explained.iter_mut().rev() {
        add_claimed::<T, P, V>(landmarks, explained, movers, |association, behind| association.cavity_sum += behind);
    }
}

fn forget_claimed<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    landmarks: &mut [Landmark<PositionOf<P>>],
    movers: &mut V,
) {
    landmarks.iter_mut().for_each(|slot| slot.claimed = T::ZERO);
    if let Some(mut tracks) = movers.tracks() {
        tracks.kept_mut().iter_mut().for_each(|mover| mover.claimed = T::ZERO);
    }
}

/// Gives every association of a measurement the sum Σ a ν of its cause over other measurements so far, then adds its own a ν to that sum.
fn add_claimed<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    landmarks: &mut [Landmark<PositionOf<P>>],
    explained: &mut AssociationRow<T>,
    movers: &mut V,
    set: impl Fn(&mut Association<T>, T),
) {
    for association in explained.associations_mut() {
        let cause = cause(movers, association.feature);
        if let Some(&mut so_far) = claimed::<T, P, V>(landmarks, &mut movers.tracks(), cause) {
            set(association, so_far);
        }
    }
    for association in explained.associations() {
        let cause = cause(movers, association.feature);
        if let Some(claimed) = claimed::<T, P, V>(landmarks, &mut movers.tracks(), cause) {
            *claimed += association.odds * association.nu;
        }
    }
}

/// μ: the message from a landmark to a measurement, given what else the landmark may have caused.
fn mu<T: Real>(association: &Association<T>) -> T {
    association.odds / (T::ONE + association.cavity_sum)
}

/// ν: the messages from a measurement to each landmark, given those of the other landmarks.
fn send_nu<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(explained: &mut AssociationRow<T>, movers: &V) {
    for place in 0..explained.associations().len() {
        let own = explained.associations().get(place).map_or(0, |association| cause(movers, association.feature));
        let others = explained.associations().iter().enumerate();
        let others = others
            .filter(|&(other, association)| other != place && (!V::MOVE || cause(movers, association.feature) != own));
        let wanted = others.fold(T::ZERO, |sum, (_, association)| sum + mu(association));
        if let Some(association) = explained.associations_mut().get_mut(place) {
            association.nu = T::ONE / (T::ONE + wanted);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::associations::{Association, AssociationRow};
    use super::super::existence::Existence;
    use super::super::movers::NoMovers;
    use super::super::state::Landmark;
    use crate::{Noise, PlanarPose, Real};
    use nalgebra::Vector2;
    use std::vec;
    use std::vec::Vec;

    fn marginals<T: Real>(
        landmarks: &mut [Landmark<Vector2<T>>],
        explained: &mut [AssociationRow<T>],
        ln_missed: T,
    ) -> T {
        super::marginals::<T, PlanarPose<T>, _>(landmarks, explained, &mut NoMovers, ln_missed)
    }

    /// Odds by feature and measurement, over clutter of one.
    fn settled(odds: &[&[f64]]) -> (Vec<Vec<f64>>, f64) {
        let mut landmarks = vec![Landmark::<Vector2<f64>> { existence: Existence::NONE, ..Landmark::ZERO }; odds.len()];
        let mut explained = vec![AssociationRow::ZERO; odds[0].len()];
        for (z, explained) in explained.iter_mut().enumerate() {
            explained.start(0.0);
            for (feature, odds) in odds.iter().enumerate().filter(|(_, odds)| odds[z] > 0.0) {
                explained.associate(Association::new(feature as u16, odds[z].ln()));
            }
        }
        let ln_evidence = marginals(&mut landmarks, &mut explained, 0.0);
        let mut shares = vec![vec![0.0; odds[0].len()]; odds.len()];
        for (z, explained) in explained.iter().enumerate() {
            let all: f64 = explained.associations().iter().map(|association| association.share).sum();
            assert!((all + explained.unexplained - 1.0).abs() < 1e-2, "{all} {}", explained.unexplained);
            explained
                .associations()
                .iter()
                .for_each(|association| shares[usize::from(association.feature)][z] = association.share);
        }
        (shares, ln_evidence)
    }

    /// Features that all want the same few measurements leave messages that do not converge in these rounds.
    #[test]
    fn no_measurement_is_shared_out_twice() {
        let mut draws = Noise::seeded(5);
        let mut unsettled = 0;
        for _ in 0..200 {
            let odds: [[f64; 7]; 11] =
                core::array::from_fn(|_| core::array::from_fn(|_| (6.0 * draws.normal::<f64>()).exp()));
            let rows = odds.each_ref().map(|row| &row[..]);
            let mut landmarks = vec![Landmark::<Vector2<f64>> { existence: Existence::NONE, ..Landmark::ZERO }; 11];
            let mut explained = vec![AssociationRow::ZERO; 7];
            for (z, explained) in explained.iter_mut().enumerate() {
                explained.start(0.0);
                rows.iter()
                    .enumerate()
                    .for_each(|(j, odds)| explained.associate(Association::new(j as u16, odds[z].ln())));
            }
            marginals(&mut landmarks, &mut explained, 0.0);
            let mut of_features = [0.0; 11];
            for explained in &explained {
                let all: f64 = explained.associations().iter().map(|association| association.share).sum();
                assert!(all <= 1.0 + 1e-3, "{all}");
                unsettled += usize::from(all + explained.unexplained > 1.01);
                explained
                    .associations()
                    .iter()
                    .for_each(|association| of_features[usize::from(association.feature)] += association.share);
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
        let mut landmarks = vec![Landmark::<Vector2<f32>>::ZERO; 2];
        let mut explained = vec![AssociationRow::<f32>::ZERO; 2];
        for explained in &mut explained {
            explained.start(f32::NEG_INFINITY);
            (0..2).for_each(|feature| explained.associate(Association::new(feature, 500.0 + f32::from(feature))));
        }
        let ln_evidence = marginals(&mut landmarks, &mut explained, 0.0);
        assert!(ln_evidence.is_finite());
        for explained in &explained {
            let all: f32 = explained.associations().iter().map(|association| association.share).sum();
            assert!((all - 1.0).abs() < 1e-3, "{explained:?}");
        }
    }
}
