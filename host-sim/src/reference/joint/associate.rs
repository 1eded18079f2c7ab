//! Who may have caused which measurement: the responsibilities of `docs/joint.md`, with every message written out.

use super::models::{Expected, Models};
use super::state::State;
use super::{Config, Joint};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Features that share a measurement, at most.
const CLAIMS: usize = 4;
/// Rounds of messages.
const ROUNDS: usize = 8;
/// ln of the largest odds.
const LN_ODDS_MAX: f64 = 40.0;

/// What a scan says of the features, and the features of a scan.
#[derive(Debug, Clone)]
pub(super) struct Association {
    /// p_D of every feature, 0 out of view.
    pub(super) detection: Vec<f64>,
    /// s_jz, by feature and measurement.
    pub(super) shares: DMatrix<f64>,
    /// u_z.
    pub(super) unexplained: Vec<f64>,
    /// ln λ_z.
    pub(super) ln_lambda: Vec<f64>,
    /// ln L.
    pub(super) ln_evidence: f64,
}

/// H of a feature over all coordinates.
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
        let (n, m) = (state.features.len(), measurements.len());
        let Config { gate, behind, birth_intensity, .. } = self.config;
        let mut detection = vec![0.0; n];
        // ln( p_D v N / (1 − p_D v) ) within the gate.
        let mut ln_claims = DMatrix::from_element(n, m, f64::NEG_INFINITY);
        let mut ln_evidence = 0.0;
        for place in 0..n {
            let Some(expected) = self.models.expected(&state.pose, &state.places[place]) else { continue };
            let hidden = measurements.iter().any(|z| self.models.hides(z, &expected.measurement));
            let p = expected.detection * if hidden { behind } else { 1.0 };
            detection[place] = p.min(1.0 - f64::EPSILON);
            let pv = detection[place] * state.features[place].in_sight;
            if pv <= 0.0 {
                continue;
            }
            ln_evidence += (1.0 - pv).ln();
            let h = over_all(state, place, &expected);
            let s = &h * &state.covariance * h.transpose() + self.models.noise();
            let ln_peak = pv.ln() - (1.0 - pv).ln() - 0.5 * (s.determinant().ln() + s.nrows() as f64 * TAU.ln());
            let inverse = s.try_inverse().expect("R is positive definite");
            for (column, z) in measurements.iter().enumerate() {
                let distance = squared(&self.models.innovation(z, &expected.measurement), &inverse);
                if distance <= gate {
                    ln_claims[(place, column)] = ln_peak - 0.5 * distance;
                }
            }
        }
        let ln_lambda = (self.models.clutter_intensity() + birth_intensity).ln();
        let mut ln_lambdas = vec![ln_lambda; m];
        let mut odds = DMatrix::zeros(n, m);
        for (z, ln_lambda) in ln_lambdas.iter_mut().enumerate() {
            let mut likeliest: Vec<usize> = (0..n).filter(|&j| ln_claims[(j, z)] > f64::NEG_INFINITY).collect();
            likeliest.sort_by(|&a, &b| ln_claims[(b, z)].total_cmp(&ln_claims[(a, z)]));
            likeliest.truncate(CLAIMS);
            let Some(&first) = likeliest.first() else { continue };
            *ln_lambda = ln_lambda.max(ln_claims[(first, z)] - LN_ODDS_MAX);
            likeliest.iter().for_each(|&j| odds[(j, z)] = (ln_claims[(j, z)] - *ln_lambda).exp());
        }
        let settled = settle(&odds);
        let ln_evidence = ln_evidence + settled.ln_evidence + ln_lambdas.iter().sum::<f64>();
        let Settled { shares, unexplained, .. } = settled;
        Association { detection, shares, unexplained, ln_lambda: ln_lambdas, ln_evidence }
    }
}

/// A sum of shares of a measurement that is rounding above one.
const SETTLED: f64 = 1.001;

/// Odds after the messages.
struct Settled {
    shares: DMatrix<f64>,
    unexplained: Vec<f64>,
    /// Without the parts of what is missed and of clutter.
    ln_evidence: f64,
}

/// Belief propagation over odds a_jz by feature and measurement.
fn settle(a: &DMatrix<f64>) -> Settled {
    let (n, m) = a.shape();
    // Σ over the others of a row or column, each time anew.
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
        // There is one of each, whatever messages that have not settled say.
        let all = of_measurement.sum();
        if all > SETTLED {
            of_measurement /= all;
        }
    }
    Settled {
        shares,
        unexplained: by_measurement.iter().map(|sum| 1.0 / sum).collect(),
        ln_evidence: ln_sum(&by_feature) + ln_sum(&by_measurement) - pairs,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ln of the sum over all assignments, and the share of each pair in it.
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
    fn without_circles_messages_find_the_sum_over_all_assignments() {
        let chain = DMatrix::from_row_slice(3, 3, &[40.0, 3.0, 0.0, 0.0, 6.0, 0.5, 0.0, 0.0, 9.0]);
        let star = DMatrix::from_row_slice(3, 1, &[3.0, 4.0, 0.1]);
        let apart = DMatrix::from_row_slice(2, 2, &[5.0, 0.0, 0.0, 0.2]);
        for odds in [chain, star, apart] {
            let (settled, (ln_sum, shares)) = (settle(&odds), enumerated(&odds));
            assert!((settled.ln_evidence - ln_sum).abs() < 1e-12, "{odds}");
            assert!((settled.shares - shares).norm() < 1e-12, "{odds}");
        }
    }
}
