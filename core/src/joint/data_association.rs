//! Probabilistic data association by loopy belief propagation on the graph of landmarks and measurements (Williams &
//! Lau 2014). A measurement has exactly one origin, and a landmark causes at most one measurement.
//!
//! With the odds a_jz = p_D v_j N(z; ẑ_j, S_j) / ((1 − p_D v_j) λ_z), λ_z = κ + w_b (plus w_m with moving-object tracks), the
//! messages are μ_jz = a_jz / (1 + Σ_{z'≠z} a_jz' ν_z'j) and ν_zj = 1 / (1 + Σ_{j'≠j} μ_j'z). If no two landmarks are candidates
//! for the same two measurements, the graph has no cycle, and the association probabilities are exact.

use super::associations::{Association, AssociationRow};
use super::landmark::Landmark;
use super::movers::{MOVES, Movers, Tracks};
use crate::{Pose, PositionOf, Real};

/// Iterations of belief propagation. A graph without cycles has converged after as many iterations as its longest path
/// has landmarks; landmarks farther away on the graph hardly influence a message.
const ITERATIONS: usize = 8;

/// Association probabilities of a measurement are normalised if their sum is greater than this.
const MAX_SUM: f64 = 1.001;

/// ln of the largest odds of an association. Clutter then has practically no probability, and sums of odds stay finite
/// in single precision.
const LN_ODDS_MAX: f64 = 40.0;

/// Computes the probability of every association, and for every measurement the probability that no landmark caused it.
/// Returns ln of the likelihood of the scan by Bethe's approximation, which is exact without cycles; `ln_missed` is Σ
/// ln(1 − p_D v), that of no detection at all.
///
/// A moving-object track and the static landmark of the same object have one origin: at most one of them causes a measurement.
pub(super) fn marginals<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    landmarks: &mut [Landmark<PositionOf<P>>],
    table: &mut [AssociationRow<T>],
    movers: &mut V,
    ln_missed: T,
) -> T {
    table.iter_mut().for_each(set_odds);
    for _ in 0..ITERATIONS {
        update_cavity_sums::<T, P, V>(landmarks, table, movers);
        table.iter_mut().for_each(|row| update_nu::<T, P, V>(row, movers));
    }
    update_cavity_sums::<T, P, V>(landmarks, table, movers);
    let ln_1p = |x: T| (T::ONE + x).ln();
    let mut ln_evidence = ln_missed;
    for row in table {
        let sum_of_mu = row.associations().iter().fold(T::ZERO, |sum, association| sum + mu(association));
        row.no_feature_probability = T::ONE / (T::ONE + sum_of_mu);
        ln_evidence += row.ln_lambda + ln_1p(sum_of_mu);
        for index in 0..row.associations().len() {
            let of_all = |of: fn(&Association<T>) -> T| sum_of_origin::<T, P, V>(row.associations(), movers, index, of);
            let (own_message, mu_nu) = (
                of_all(|association| association.odds * association.nu),
                of_all(|association| mu(association) * association.nu),
            );
            let is_first = is_first_of_origin::<T, P, V>(row.associations(), movers, index);
            let Some(association) = row.associations_mut().get_mut(index) else { break };
            association.probability =
                association.odds * association.nu / (T::ONE + association.probability + own_message);
            if is_first {
                ln_evidence -= ln_1p(mu_nu);
            }
        }
        normalise(row);
    }
    let ln_evidence = landmarks.iter().fold(ln_evidence, |sum, landmark| sum + ln_1p(landmark.scratch));
    movers.kept().iter().fold(ln_evidence, |sum, mover| sum + ln_1p(mover.message_sum))
}

/// The origin of an association. For a moving-object track this is the static landmark of the same object, if there is one.
fn origin<P: Pose, V: Movers<P>>(movers: &V, claimant: u16) -> u16 {
    if !movers.are_tracked() || claimant & MOVES == 0 {
        return claimant;
    }
    let mover = movers.kept().get(usize::from(claimant & !MOVES));
    mover.and_then(|mover| mover.static_index()).unwrap_or(claimant)
}

/// Sums `of` over all associations of a row that have the same origin as association `index`.
fn sum_of_origin<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    associations: &[Association<T>],
    movers: &V,
    index: usize,
    of: impl Fn(&Association<T>) -> T,
) -> T {
    let Some(association) = associations.get(index) else { return T::ZERO };
    if !movers.are_tracked() {
        return of(association);
    }
    let own = origin(movers, association.feature);
    associations.iter().filter(|other| origin(movers, other.feature) == own).fold(T::ZERO, |sum, other| sum + of(other))
}

/// Whether no earlier association of the row has the same origin.
fn is_first_of_origin<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    associations: &[Association<T>],
    movers: &V,
    index: usize,
) -> bool {
    let Some(association) = associations.get(index).filter(|_| movers.are_tracked()) else { return true };
    let own = origin(movers, association.feature);
    !associations.iter().take(index).any(|other| origin(movers, other.feature) == own)
}

/// The memory in which Σ a ν of an origin is summed.
fn message_sum<'c, T: Real, P: Pose<Scalar = T>>(
    landmarks: &'c mut [Landmark<PositionOf<P>>],
    tracks: &'c mut Option<Tracks<'_, P>>,
    origin: u16,
) -> Option<&'c mut T> {
    if tracks.is_some() && origin & MOVES != 0 {
        let mover = tracks.as_mut().and_then(|tracks| tracks.kept_mut().get_mut(usize::from(origin & !MOVES)));
        return mover.map(|mover| &mut mover.message_sum);
    }
    landmarks.get_mut(usize::from(origin)).map(|landmark| &mut landmark.scratch)
}

/// Normalises the association probabilities of a measurement if their sum is above one, because the messages have not
/// converged. The sum of each landmark is at most one before, and decreases.
fn normalise<T: Real>(row: &mut AssociationRow<T>) {
    let all = row.associations().iter().fold(T::ZERO, |sum, association| sum + association.probability);
    if all > T::from_f64(MAX_SUM) {
        row.associations_mut().iter_mut().for_each(|association| association.probability /= all);
    }
}

/// Computes the odds of a measurement's associations and initialises the messages. If the odds were too large, λ is increased.
fn set_odds<T: Real>(row: &mut AssociationRow<T>) {
    let most = row.associations().iter().fold(T::NEG_INFINITY, |most, association| most.at_least(association.odds));
    row.ln_lambda = row.ln_lambda.at_least(most - T::from_f64(LN_ODDS_MAX));
    let ln_lambda = row.ln_lambda;
    for association in row.associations_mut() {
        association.odds = (association.odds - ln_lambda).exp();
        association.nu = T::ONE;
    }
}

/// Sums a ν for every origin, and for every association the cavity sum: the same sum without this measurement. The cavity sum is
/// added up from the measurements before and those after, because the difference of two large sums would lose its digits.
fn update_cavity_sums<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    landmarks: &mut [Landmark<PositionOf<P>>],
    table: &mut [AssociationRow<T>],
    movers: &mut V,
) {
    clear_message_sums::<T, P, V>(landmarks, movers);
    for row in table.iter_mut() {
        add_messages::<T, P, V>(landmarks, row, movers, |association, before| association.probability = before);
    }
    clear_message_sums::<T, P, V>(landmarks, movers);
    for row in table.iter_mut().rev() {
        add_messages::<T, P, V>(landmarks, row, movers, |association, behind| association.probability += behind);
    }
}

fn clear_message_sums<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    landmarks: &mut [Landmark<PositionOf<P>>],
    movers: &mut V,
) {
    landmarks.iter_mut().for_each(|landmark| landmark.scratch = T::ZERO);
    if let Some(mut tracks) = movers.tracks() {
        tracks.kept_mut().iter_mut().for_each(|mover| mover.message_sum = T::ZERO);
    }
}

/// Calls `set` with every association of a measurement and the sum Σ a ν of its origin so far, then adds its own a ν to that sum.
fn add_messages<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(
    landmarks: &mut [Landmark<PositionOf<P>>],
    row: &mut AssociationRow<T>,
    movers: &mut V,
    set: impl Fn(&mut Association<T>, T),
) {
    for association in row.associations_mut() {
        let origin = origin(movers, association.feature);
        if let Some(&mut so_far) = message_sum(landmarks, &mut movers.tracks(), origin) {
            set(association, so_far);
        }
    }
    for association in row.associations() {
        let origin = origin(movers, association.feature);
        if let Some(sum) = message_sum(landmarks, &mut movers.tracks(), origin) {
            *sum += association.odds * association.nu;
        }
    }
}

/// μ: the message from a landmark to a measurement, while the field of the probability has the cavity sum.
fn mu<T: Real>(association: &Association<T>) -> T {
    association.odds / (T::ONE + association.probability)
}

/// ν: the messages from a measurement to its landmarks.
fn update_nu<T: Real, P: Pose<Scalar = T>, V: Movers<P>>(row: &mut AssociationRow<T>, movers: &V) {
    for index in 0..row.associations().len() {
        let own = row.associations().get(index).map_or(0, |association| origin(movers, association.feature));
        let others = row.associations().iter().enumerate();
        let others = others.filter(|&(other, association)| {
            other != index && (!movers.are_tracked() || origin(movers, association.feature) != own)
        });
        let sum_of_mu = others.fold(T::ZERO, |sum, (_, association)| sum + mu(association));
        if let Some(association) = row.associations_mut().get_mut(index) {
            association.nu = T::ONE / (T::ONE + sum_of_mu);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::associations::{Association, AssociationRow};
    use super::super::existence::Existence;
    use super::super::landmark::Landmark;
    use super::super::movers::NoMovers;
    use crate::{Noise, PlanarPose, Real};
    use nalgebra::Vector2;
    use std::vec;
    use std::vec::Vec;

    fn marginals<T: Real>(landmarks: &mut [Landmark<Vector2<T>>], table: &mut [AssociationRow<T>], ln_missed: T) -> T {
        super::marginals::<T, PlanarPose<T>, _>(landmarks, table, &mut NoMovers, ln_missed)
    }

    /// Association probabilities and ln evidence for the odds of each landmark and measurement, with λ = 1.
    fn associated(odds: &[&[f64]]) -> (Vec<Vec<f64>>, f64) {
        let mut landmarks = vec![Landmark::<Vector2<f64>> { existence: Existence::NONE, ..Landmark::ZERO }; odds.len()];
        let mut table = vec![AssociationRow::ZERO; odds[0].len()];
        for (z, row) in table.iter_mut().enumerate() {
            row.start(0.0);
            for (feature, odds) in odds.iter().enumerate().filter(|(_, odds)| odds[z] > 0.0) {
                row.associate(Association::new(feature as u16, odds[z].ln()));
            }
        }
        let ln_evidence = marginals(&mut landmarks, &mut table, 0.0);
        let mut probabilities = vec![vec![0.0; odds[0].len()]; odds.len()];
        for (z, row) in table.iter().enumerate() {
            let all: f64 = row.associations().iter().map(|association| association.probability).sum();
            assert!((all + row.no_feature_probability - 1.0).abs() < 1e-2, "{all} {}", row.no_feature_probability);
            row.associations()
                .iter()
                .for_each(|association| probabilities[usize::from(association.feature)][z] = association.probability);
        }
        (probabilities, ln_evidence)
    }

    /// With many landmarks that compete for few measurements, the messages do not converge in the given number of iterations.
    #[test]
    fn probabilities_of_a_measurement_sum_to_at_most_one() {
        let mut draws = Noise::seeded(5);
        let mut unconverged = 0;
        for _ in 0..200 {
            let odds: [[f64; 7]; 11] =
                core::array::from_fn(|_| core::array::from_fn(|_| (6.0 * draws.normal::<f64>()).exp()));
            let rows = odds.each_ref().map(|row| &row[..]);
            let mut landmarks = vec![Landmark::<Vector2<f64>> { existence: Existence::NONE, ..Landmark::ZERO }; 11];
            let mut table = vec![AssociationRow::ZERO; 7];
            for (z, row) in table.iter_mut().enumerate() {
                row.start(0.0);
                rows.iter().enumerate().for_each(|(j, odds)| row.associate(Association::new(j as u16, odds[z].ln())));
            }
            marginals(&mut landmarks, &mut table, 0.0);
            let mut of_features = [0.0; 11];
            for row in &table {
                let all: f64 = row.associations().iter().map(|association| association.probability).sum();
                assert!(all <= 1.0 + 1e-3, "{all}");
                unconverged += usize::from(all + row.no_feature_probability > 1.01);
                row.associations()
                    .iter()
                    .for_each(|association| of_features[usize::from(association.feature)] += association.probability);
            }
            assert!(of_features.iter().all(|&sum| sum <= 1.0 + 1e-12), "{of_features:?}");
        }
        assert!(unconverged > 20, "{unconverged}: this tests nothing");
    }

    /// The same by enumeration of all assignments.
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
        by.iter_mut().flatten().for_each(|probability| *probability /= sum);
        (by, sum.ln())
    }

    fn largest_difference(odds: &[&[f64]]) -> (f64, f64) {
        let ((probabilities, ln_evidence), (exact, exact_ln)) = (associated(odds), by_enumeration(odds));
        let off =
            probabilities.iter().flatten().zip(exact.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        (off, (ln_evidence - exact_ln).abs())
    }

    #[test]
    fn without_cycles_the_result_is_exact() {
        let cases: [&[&[f64]]; 4] = [
            &[&[5.0]],
            &[&[5.0, 0.3, 0.0], &[0.0, 2.0, 0.7]],
            &[&[40.0, 3.0, 0.0, 0.0], &[0.0, 6.0, 0.5, 0.0], &[0.0, 0.0, 9.0, 100.0]],
            &[&[3.0], &[4.0], &[0.1]],
        ];
        for odds in cases {
            let (probabilities, ln_evidence) = largest_difference(odds);
            assert!(probabilities < 1e-12 && ln_evidence < 1e-12, "{odds:?}: {probabilities} {ln_evidence}");
        }
    }

    #[test]
    fn with_cycles_the_result_is_approximate() {
        let (probabilities, ln_evidence) = largest_difference(&[&[8.0, 3.0], &[2.0, 6.0]]);
        assert!(probabilities < 0.06 && ln_evidence < 0.2, "{probabilities} {ln_evidence}");
    }

    #[test]
    fn a_feature_causes_at_most_one_measurement() {
        // Both measurements fit the landmark, and clutter is a thousand times less likely.
        let (probabilities, _) = associated(&[&[1000.0, 1000.0]]);
        assert!((probabilities[0][0] - 1000.0 / 2001.0).abs() < 1e-12);
    }

    #[test]
    fn huge_odds_stay_finite() {
        let mut landmarks = vec![Landmark::<Vector2<f32>>::ZERO; 2];
        let mut table = vec![AssociationRow::<f32>::ZERO; 2];
        for row in &mut table {
            row.start(f32::NEG_INFINITY);
            (0..2).for_each(|feature| row.associate(Association::new(feature, 500.0 + f32::from(feature))));
        }
        let ln_evidence = marginals(&mut landmarks, &mut table, 0.0);
        assert!(ln_evidence.is_finite());
        for row in &table {
            let all: f32 = row.associations().iter().map(|association| association.probability).sum();
            assert!((all - 1.0).abs() < 1e-3, "{table:?}");
        }
    }
}
