//! Data association: the association probabilities of `docs/joint.md`, with all messages of belief propagation written out.

use super::Joint;
use super::models::{Expected, Models};
use super::mover::Sight;
use super::state::State;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Greatest number of features associated with a measurement.
const ASSOCIATIONS: usize = 4;
/// Iterations of belief propagation.
const ROUNDS: usize = 8;
/// A feature is weak if its innovation has more than this multiple of the least standard deviation, for each coordinate of the
/// measurement.
const WEAK_RATIO: f64 = 3.0;
/// Logarithm of the greatest odds.
const LN_ODDS_MAX: f64 = 40.0;

/// Association of features and measurements of a scan.
#[derive(Debug, Clone)]
pub(super) struct Association {
    /// Number of weak features that were excluded.
    pub(super) weak: usize,
    /// p_D of every feature; 0 out of view and for excluded ones.
    pub(super) detection: Vec<f64>,
    /// s_jz, by feature and measurement.
    pub(super) shares: DMatrix<f64>,
    /// The probability that a feature is not detected, whether it is static or moving.
    pub(super) not_detected: Vec<f64>,
    /// For each moving-object track, the static feature that it may be instead.
    pub(super) rivals: Vec<Option<usize>>,
    /// p_D of every moving-object track.
    pub(super) mover_detection: Vec<f64>,
    /// s_jz of moving-object tracks.
    pub(super) mover_shares: DMatrix<f64>,
    /// The probability that a moving object is not detected, whether it moves or is static.
    pub(super) mover_not_detected: Vec<f64>,
    /// u_z.
    pub(super) unexplained: Vec<f64>,
    /// ln λ_z.
    pub(super) ln_lambda: Vec<f64>,
    /// ln L.
    pub(super) ln_evidence: f64,
}

/// H of a feature with respect to all coordinates.
pub(super) fn over_all(state: &State, place: usize, expected: &Expected) -> DMatrix<f64> {
    let mut h = DMatrix::zeros(expected.measurement.len(), state.covariance.nrows());
    h.columns_mut(0, expected.by_pose.ncols()).copy_from(&expected.by_pose);
    h.columns_mut(state.first(place), expected.by_feature.ncols()).copy_from(&expected.by_feature);
    h
}

/// νᵀ S⁻¹ ν.
pub(super) fn squared(innovation: &DVector<f64>, inverse: &DMatrix<f64>) -> f64 {
    innovation.dot(&(inverse * innovation))
}

impl<M: Models> Joint<M> {
    pub(super) fn associate(&self, state: &State, measurements: &[&[f64]]) -> Association {
        let (n, k, m) = (state.features.len(), state.movers.len(), measurements.len());
        let seen_of = |expected: &Expected| {
            let hidden = measurements.iter().any(|z| self.models.occludes(z, &expected.measurement));
            let p = expected.detection * if hidden { self.config.occlusion_factor } else { 1.0 };
            p.min(1.0 - f64::EPSILON)
        };
        let expected: Vec<Option<Expected>> =
            state.places.iter().map(|place| self.models.expected(&state.pose, place)).collect();
        let sights: Vec<Option<Sight>> = state.movers.iter().map(|mover| self.sight(state, mover)).collect();
        let mut detection: Vec<f64> = expected.iter().map(|expected| expected.as_ref().map_or(0.0, seen_of)).collect();
        let of_sight = |sight: &Option<Sight>| sight.as_ref().map_or(0.0, |sight| seen_of(&sight.expected));
        let mover_detection: Vec<f64> = sights.iter().map(of_sight).collect();
        let rivals: Vec<Option<usize>> = state
            .movers
            .iter()
            .map(|mover| state.features.iter().position(|feature| feature.label == mover.label))
            .collect();
        let weak = self.weak(state, &expected, &detection, &mover_detection, &rivals);
        // Excluded features nevertheless replace features with lower odds.
        let asked = detection.clone();
        weak.iter().for_each(|&place| detection[place] = 0.0);
        // Causes: every static feature together with its alternative moving-object track, then the other tracks.
        let cause_of_mover: Vec<usize> = (0..k).map(|mover| rivals[mover].unwrap_or(n + mover)).collect();
        let mut not_detected = vec![1.0; n + k];
        (0..n).for_each(|place| not_detected[place] -= detection[place] * state.features[place].in_sight);
        (0..k).for_each(|mover| {
            not_detected[cause_of_mover[mover]] -= mover_detection[mover] * state.movers[mover].weight
        });

        // ln( p_D v N / (1 − p_D v − p_D w) ) within the gate, for static features, then for moving-object tracks.
        let mut ln_claims = DMatrix::from_element(n + k, m, f64::NEG_INFINITY);
        let mut claim = |row: usize, none: f64, expected: &Expected, s: DMatrix<f64>, probability: f64| {
            let ln_normal = -0.5 * (s.determinant().ln() + s.nrows() as f64 * TAU.ln());
            let ln_peak = probability.ln() - none.ln() + ln_normal;
            let inverse = s.try_inverse().expect("R is positive definite");
            for (column, z) in measurements.iter().enumerate() {
                let distance = squared(&self.models.innovation(z, &expected.measurement), &inverse);
                if distance <= self.config.gate {
                    ln_claims[(row, column)] = ln_peak - 0.5 * distance;
                }
            }
        };
        for (place, expected) in expected.iter().enumerate() {
            let probability = asked[place] * state.features[place].in_sight;
            let none = if detection[place] > 0.0 { not_detected[place] } else { 1.0 - probability };
            if let Some(expected) = expected.as_ref().filter(|_| probability > 0.0) {
                let h = over_all(state, place, expected);
                let s = &h * &state.covariance * h.transpose() + self.models.noise_at(expected.measurement.as_slice());
                claim(place, none, expected, s, probability);
            }
        }
        for (place, sight) in sights.iter().enumerate() {
            let mover = &state.movers[place];
            let probability = mover_detection[place] * mover.weight;
            if let Some(sight) = sight.as_ref().filter(|_| probability > 0.0) {
                let s = sight.covariance(mover);
                claim(n + place, not_detected[cause_of_mover[place]], &sight.expected, s, probability);
            }
        }

        let of_moving = self.config.moving.map_or(0.0, |moving| moving.birth_intensity);
        let ln_lambda = (self.models.clutter_intensity() + self.config.birth_intensity + of_moving).ln();
        let mut ln_lambdas = vec![ln_lambda; m];
        let mut odds = DMatrix::zeros(n + k, m);
        for (z, ln_lambda) in ln_lambdas.iter_mut().enumerate() {
            let most = |of: &mut Vec<usize>| {
                of.sort_by(|&a, &b| ln_claims[(b, z)].total_cmp(&ln_claims[(a, z)]));
                of.truncate(ASSOCIATIONS);
            };
            let claims = |row: &usize| ln_claims[(*row, z)] > f64::NEG_INFINITY;
            let mut likeliest: Vec<usize> = (0..n).filter(claims).collect();
            most(&mut likeliest);
            likeliest.retain(|place| !weak.contains(place));
            likeliest.extend((n..n + k).filter(claims));
            most(&mut likeliest);
            let Some(&first) = likeliest.first() else { continue };
            *ln_lambda = ln_lambda.max(ln_claims[(first, z)] - LN_ODDS_MAX);
            likeliest.iter().for_each(|&j| odds[(j, z)] = (ln_claims[(j, z)] - *ln_lambda).exp());
        }
        // The odds of a cause are the sum over its alternatives; its association probabilities are divided among them.
        let mut of_causes = odds.clone();
        (0..k).filter(|&mover| rivals[mover].is_some()).for_each(|mover| {
            let own = odds.row(n + mover).clone_owned();
            let mut cause = of_causes.row_mut(cause_of_mover[mover]);
            cause += own;
            of_causes.row_mut(n + mover).fill(0.0);
        });
        let settled = marginals(&of_causes);
        let part = |row: usize, cause: usize, z: usize| {
            if odds[(row, z)] > 0.0 { settled.shares[(cause, z)] * odds[(row, z)] / of_causes[(cause, z)] } else { 0.0 }
        };
        let shares = DMatrix::from_fn(n, m, |place, z| part(place, place, z));
        let mover_shares = DMatrix::from_fn(k, m, |mover, z| part(n + mover, cause_of_mover[mover], z));
        let ln_missed: f64 = not_detected.iter().map(|none: &f64| none.ln()).sum();
        let ln_evidence = ln_missed + settled.ln_evidence + ln_lambdas.iter().sum::<f64>();
        let mover_not_detected = cause_of_mover.iter().map(|&cause| not_detected[cause]).collect();
        not_detected.truncate(n);
        Association {
            weak: weak.len(),
            detection,
            shares,
            not_detected,
            rivals,
            mover_detection,
            mover_shares,
            mover_not_detected,
            unexplained: settled.unexplained,
            ln_lambda: ln_lambdas,
            ln_evidence,
        }
    }
}

impl<M: Models> Joint<M> {
    /// Features with a weak innovation, compared with the most certain one or with one born of the last scan; features with a
    /// moving alternative are not weak.
    fn weak(
        &self,
        state: &State,
        expected: &[Option<Expected>],
        detection: &[f64],
        mover_detection: &[f64],
        rivals: &[Option<usize>],
    ) -> Vec<usize> {
        let may_be_born = self.config.birth_intensity > 0.0 && state.features.len() < self.config.capacity;
        let usual = self.models.noise().determinant();
        let claims: Vec<(usize, [f64; 2])> = (0..state.features.len())
            .filter(|&place| detection[place] * state.features[place].in_sight > 0.0)
            .filter_map(|place| {
                let expected = expected[place].as_ref()?;
                let h = over_all(state, place, expected);
                let noise = self.models.noise_at(expected.measurement.as_slice());
                let s = &h * &state.covariance * h.transpose() + &noise;
                let walked = &expected.by_pose * &state.process_noise * expected.by_pose.transpose();
                // Innovations with another R are compared relative to it.
                let relative = (usual / noise.determinant()).sqrt();
                let newborn = if may_be_born { (walked + noise * 2.0).determinant().sqrt() } else { f64::INFINITY };
                Some((place, [relative * s.determinant().sqrt(), relative * newborn]))
            })
            .collect();
        let least = claims.iter().map(|&(_, [size, _])| size).fold(f64::INFINITY, f64::min);
        let may_move = |place: usize| {
            let of = |mover: &usize| rivals[*mover] == Some(place);
            (0..rivals.len()).filter(of).any(|mover| mover_detection[mover] * state.movers[mover].weight > 0.0)
        };
        let times = WEAK_RATIO.powi(self.models.noise().nrows() as i32);
        let is_loose =
            |&&(place, [size, newborn]): &&(usize, [f64; 2])| size > least.min(newborn) * times && !may_move(place);
        claims.iter().filter(is_loose).map(|&(place, _)| place).collect()
    }
}

/// Greatest sum of the association probabilities of a measurement that is a rounding error.
const SETTLED: f64 = 1.001;

/// Marginal association probabilities.
struct Marginals {
    shares: DMatrix<f64>,
    unexplained: Vec<f64>,
    /// Without the parts of missed detections and of clutter.
    ln_evidence: f64,
}

/// Belief propagation with the odds a_jz of feature and measurement.
fn marginals(a: &DMatrix<f64>) -> Marginals {
    let (n, m) = a.shape();
    // Σ over the other elements of a row or column, computed directly.
    let but = |count: usize, skipped: usize, term: &dyn Fn(usize) -> f64| -> f64 {
        (0..count).filter(|&k| k != skipped).map(term).sum()
    };
    let mut nu = DMatrix::from_element(n, m, 1.0);
    let wanted = |nu: &DMatrix<f64>| {
        DMatrix::from_fn(n, m, |j, z| a[(j, z)] / (1.0 + but(m, z, &|other| a[(j, other)] * nu[(j, other)])))
    };
    for _ in 0..ROUNDS {
        let mu = wanted(&nu);
        nu = DMatrix::from_fn(n, m, |j, z| 1.0 / (1.0 + but(n, j, &|other| mu[(other, z)])));
    }
    let mu = wanted(&nu);
    let had = a.component_mul(&nu);
    let by_feature: Vec<f64> = (0..n).map(|j| 1.0 + had.row(j).sum()).collect();
    let by_measurement: Vec<f64> = (0..m).map(|z| 1.0 + mu.column(z).sum()).collect();
    let pairs: f64 = mu.iter().zip(nu.iter()).map(|(mu, nu)| (1.0 + mu * nu).ln()).sum();
    let ln_sum = |factors: &[f64]| factors.iter().map(|factor| factor.ln()).sum::<f64>();
    let mut shares = DMatrix::from_fn(n, m, |j, z| had[(j, z)] / by_feature[j]);
    for mut of_measurement in shares.column_iter_mut() {
        // Each measurement has one cause, also if the messages have not converged.
        let all = of_measurement.sum();
        if all > SETTLED {
            of_measurement /= all;
        }
    }
    Marginals {
        shares,
        unexplained: by_measurement.iter().map(|sum| 1.0 / sum).collect(),
        ln_evidence: ln_sum(&by_feature) + ln_sum(&by_measurement) - pairs,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Logarithm of the sum over all assignments, and the share of each pair in the sum.
    fn enumerated(a: &DMatrix<f64>) -> (f64, DMatrix<f64>) {
        let (n, m) = a.shape();
        let (mut sum, mut shares) = (0.0, DMatrix::zeros(n, m));
        for code in 0..(m + 1).pow(n as u32) {
            let choice: Vec<usize> = (0..n).map(|j| code / (m + 1).pow(j as u32) % (m + 1)).collect();
            let taken: Vec<usize> = choice.iter().copied().filter(|&z| z < m).collect();
            if (1..taken.len()).any(|k| taken[..k].contains(&taken[k])) {
                continue;
            }
            let pairs = || choice.iter().enumerate().filter(|&(_, &z)| z < m);
            let weight: f64 = pairs().map(|(j, &z)| a[(j, z)]).product();
            sum += weight;
            pairs().for_each(|(j, &z)| shares[(j, z)] += weight);
        }
        (sum.ln(), shares / sum)
    }

    #[test]
    fn without_cycles_belief_propagation_gives_the_sum_over_all_assignments() {
        let chain = DMatrix::from_row_slice(3, 3, &[40.0, 3.0, 0.0, 0.0, 6.0, 0.5, 0.0, 0.0, 9.0]);
        let star = DMatrix::from_row_slice(3, 1, &[3.0, 4.0, 0.1]);
        let apart = DMatrix::from_row_slice(2, 2, &[5.0, 0.0, 0.0, 0.2]);
        for odds in [chain, star, apart] {
            let (settled, (ln_sum, shares)) = (marginals(&odds), enumerated(&odds));
            assert!((settled.ln_evidence - ln_sum).abs() < 1e-12, "{odds}");
            assert!((settled.shares - shares).norm() < 1e-12, "{odds}");
        }
    }
}
