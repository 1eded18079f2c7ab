//! Corrections of pose and features by associated measurements, and the change of the error's frame.

use super::associate::{Association, over_all, squared};
use super::map_management::LEAST_ABSENT;
use super::models::Models;
use super::state::{Feature, State};
use super::{Config, Joint};
use nalgebra::{DMatrix, DVector};

/// Least probability of detection of a feature in a scan for a correction.
const LEAST_DETECTED: f64 = 0.02;

/// Greatest mean squared distance of a feature's measurements for a correction, in gates, after the corrections before it.
const GATES: f64 = 4.0;

/// Sums for the mean squared innovation.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Innovations {
    pub(super) squares: f64,
    pub(super) shares: f64,
}

impl<M: Models> Joint<M> {
    /// Corrects pose and features, and updates the existence probabilities.
    pub(super) fn correct(&self, state: &mut State, association: &Association, measurements: &[&[f64]]) -> Innovations {
        let mut innovations = Innovations::default();
        for place in 0..state.features.len() {
            let not_detected = association.not_detected[place];
            if association.detection[place] <= 0.0 && not_detected >= 1.0 {
                continue;
            }
            let shares: Vec<f64> = association.shares.row(place).iter().copied().collect();
            let beta: f64 = shares.iter().sum();
            if beta >= LEAST_DETECTED && !self.is_ambiguous(&shares, measurements) {
                self.correct_by(state, place, &shares, measurements, &mut innovations);
            }
            let rival = association.rivals.iter().position(|&rival| rival == Some(place));
            let of_rival = rival.map_or(0.0, |rival| association.mover_shares.row(rival).sum());
            let [weight, seen] =
                rival.map_or([0.0; 2], |rival| [state.movers[rival].weight, association.mover_detection[rival]]);
            let beside = seen * weight;
            scanned(&mut state.features[place], association.detection[place], beta, [weight, seen, of_rival]);
            let there = state.features[place].total();
            if beside > 0.0 && there > 0.0 {
                let rest: Vec<f64> = shares.iter().map(|share| share * (1.0 / there - 1.0)).collect();
                if rest.iter().sum::<f64>() >= LEAST_DETECTED && !self.is_ambiguous(&shares, measurements) {
                    self.correct_position(state, place, &rest, measurements);
                }
            }
        }
        innovations
    }

    /// Whether no measurement has half of the association probability, and their scatter exceeds three standard deviations of the
    /// noise.
    fn is_ambiguous(&self, shares: &[f64], measurements: &[&[f64]]) -> bool {
        let beta: f64 = shares.iter().sum();
        let surest = (0..shares.len()).max_by(|&a, &b| shares[a].total_cmp(&shares[b]));
        let Some(surest) = surest.filter(|&z| shares[z] < 0.5 * beta) else { return false };
        // Relative to the likeliest one.
        let from = DVector::from_column_slice(measurements[surest]);
        let apart: Vec<DVector<f64>> = measurements.iter().map(|z| self.models.innovation(z, &from)).collect();
        let mean = shares.iter().zip(&apart).map(|(&share, d)| d * (share / beta)).sum::<DVector<f64>>();
        let noise = self.models.noise_at(measurements[surest]).try_inverse().expect("R is positive definite");
        let scatter = shares.iter().zip(&apart).map(|(&share, d)| share / beta * squared(&(d - &mean), &noise));
        scatter.sum::<f64>() > 9.0
    }

    /// The update of probabilistic data association with one feature.
    fn correct_by(
        &self,
        state: &mut State,
        place: usize,
        shares: &[f64],
        measurements: &[&[f64]],
        innovations: &mut Innovations,
    ) {
        let Some(expected) = self.models.expected(&state.pose, &state.places[place]) else { return };
        let h = over_all(state, place, &expected);
        let s = &h * &state.covariance * h.transpose() + self.models.noise_at(expected.measurement.as_slice());
        let inverse = s.clone().try_inverse().expect("R is positive definite");
        let gain = &state.covariance * h.transpose() * &inverse;
        let mut mean = DVector::zeros(s.nrows());
        let mut spread = DMatrix::zeros(s.nrows(), s.nrows());
        let mut squares = 0.0;
        for (&share, z) in shares.iter().zip(measurements) {
            let innovation = self.models.innovation(z, &expected.measurement);
            mean += share * &innovation;
            spread += share * &innovation * innovation.transpose();
            squares += share * squared(&innovation, &inverse);
        }
        let beta: f64 = shares.iter().sum();
        innovations.squares += squares;
        innovations.shares += beta;
        if squares > GATES * self.config.gate * beta {
            return;
        }
        let within = spread - &mean * mean.transpose() - beta * s;
        state.covariance += &gain * within * gain.transpose();
        self.inject_correction(state, &(gain * mean));
    }

    /// The same update for the position of the feature only, with the additional association probability given that it exists and
    /// is static.
    fn correct_position(&self, state: &mut State, place: usize, shares: &[f64], measurements: &[&[f64]]) {
        let Some(expected) = self.models.expected(&state.pose, &state.places[place]) else { return };
        let h = over_all(state, place, &expected);
        let common = &state.covariance * h.transpose();
        let s = &h * &common + self.models.noise_at(expected.measurement.as_slice());
        let inverse = s.try_inverse().expect("R is positive definite");
        let mut mean = DVector::zeros(inverse.nrows());
        let mut spread = DMatrix::zeros(inverse.nrows(), inverse.nrows());
        let mut squares = 0.0;
        for (&share, z) in shares.iter().zip(measurements) {
            let innovation = self.models.innovation(z, &expected.measurement);
            mean += share * &innovation;
            spread += share * &innovation * innovation.transpose();
            squares += share * squared(&innovation, &inverse);
        }
        let beta: f64 = shares.iter().sum();
        if squares > GATES * self.config.gate * beta {
            return;
        }
        let learnt = &inverse * -beta;
        let open = &inverse * (spread - &mean * mean.transpose()) * &inverse;
        let (at, each) = (state.first(place), M::FEATURE);
        let of_all = &common * learnt * common.transpose();
        let of_own = &common * open * common.transpose();
        let own = at..at + each;
        for (row, column) in (0..common.nrows()).flat_map(|row| (0..common.nrows()).map(move |column| (row, column))) {
            let [by_row, by_column] = [row, column].map(|index| own.contains(&index));
            if by_row || by_column {
                state.covariance[(row, column)] += of_all[(row, column)];
            }
            if by_row && by_column {
                state.covariance[(row, column)] += of_own[(row, column)];
            }
        }
        let mut moved = common * inverse * mean;
        (0..moved.len()).filter(|index| !own.contains(index)).for_each(|index| moved[index] = 0.0);
        self.inject_correction(state, &moved);
    }

    /// Applies a correction to all coordinates, and changes the frame of the covariance: P ← (I + c eᵀ) P (I + c eᵀ)ᵀ.
    pub(super) fn inject_correction(&self, state: &mut State, moved: &DVector<f64>) {
        state.inject_correction(moved);
        let mut c = DVector::zeros(moved.len());
        let firsts = (0..state.places.len()).map(|place| state.first(place));
        for first in std::iter::once(0).chain(firsts) {
            (c[first], c[first + 1]) = (-moved[first + 1], moved[first]);
        }
        let heading = M::FEATURE;
        let row = state.covariance.row(heading).clone_owned();
        let mut turned = &state.covariance + &c * row;
        let column = turned.column(heading).clone_owned();
        turned += column * c.transpose();
        state.covariance = turned;
    }

    /// Existence probabilities after the time since the last scan.
    pub(super) fn pass_time(&self, state: &mut State) {
        let Config { visible_s, occluded_s, lifetime_s, .. } = self.config;
        let (a, b, c, dt) = (1.0 / visible_s, 1.0 / occluded_s, 1.0 / lifetime_s, state.waited_s);
        for feature in &mut state.features {
            let (total, settled) = (feature.total(), feature.total() * a / (a + b));
            let hidden = settled + (feature.hidden - settled) * (-(a + b) * dt).exp();
            let absent = feature.absent - total * (-c * dt).exp_m1();
            let all = total * (-c * dt).exp() + absent;
            feature.hidden = hidden * (-c * dt).exp() / all;
            feature.in_sight = (total - hidden) * (-c * dt).exp() / all;
            feature.absent = absent / all;
        }
        state.waited_s = 0.0;
    }
}

/// Existence probabilities by Bayes' rule after a scan in which the feature was detected with the probability β, and its moving
/// alternative has weight w, p_D and its own probability of detection.
fn scanned(feature: &mut Feature, detection: f64, beta: f64, [weight, seen, of_rival]: [f64; 3]) {
    let Feature { in_sight: v, hidden: h, absent: g, .. } = *feature;
    let elsewhere = (g - weight).max(0.0) + weight * (1.0 - seen);
    let not_detected = elsewhere + h + v * (1.0 - detection);
    // Loopy belief propagation may give a sum above one.
    let missed = (1.0 - beta - of_rival).max(0.0) / not_detected;
    feature.in_sight = (beta + missed * v * (1.0 - detection)).min(1.0);
    feature.hidden = missed * h;
    feature.absent = (of_rival + missed * elsewhere).max(LEAST_ABSENT);
    feature.detections += beta;
}
