//! Map management: landmarks are initiated, merged and pruned.

use super::associate::{Association, squared};
use super::difference::{Difference, place_of};
use super::models::Models;
use super::state::{Feature, State};
use super::{Config, Joint};
use nalgebra::{DMatrix, DVector};

/// Least number of detections of a feature that is not tentative.
const TWICE: f64 = 1.5;
/// Least probability that a detected feature does not exist.
pub(super) const LEAST_ABSENT: f64 = 1e-12;
/// Greatest existence probability of a feature whose removal is not counted as a loss.
const HARDLY_THERE: f64 = 0.01;
/// Least existence probability of a feature that is merged.
const LIKELY: f64 = 0.5;

impl<M: Models> Joint<M> {
    /// Adds a feature for every unexplained measurement. Returns the numbers of births, of measurements without an inverse, and
    /// of features lost for lack of capacity.
    pub(super) fn initiate(
        &self,
        state: &mut State,
        association: &mut Association,
        measurements: &[&[f64]],
    ) -> [usize; 3] {
        let Config { birth_probability_min, birth_intensity, capacity, moving, .. } = self.config;
        let (mut births, mut no_birth, mut lost) = (0, 0, 0);
        for (index, z) in measurements.iter().enumerate() {
            let unexplained = association.unexplained[index];
            // The case 0/0 is excluded.
            let of = |intensity: f64| (unexplained * intensity / association.ln_lambda[index].exp()).min(1.0);
            let born_of = |intensity: f64| if intensity == 0.0 { 0.0 } else { of(intensity) };
            let v = born_of(birth_intensity);
            let w = moving.map_or(0.0, |moving| born_of(moving.birth_intensity));
            if unexplained < birth_probability_min || v + w <= 0.0 {
                continue;
            }
            let label = state.next_label;
            state.next_label = label.wrapping_add(1);
            let inverse = self.models.inverse(&state.pose, z);
            let expected = inverse.as_ref().and_then(|m| self.models.expected(&state.pose, m.feature.as_slice()));
            let (Some(inverse), Some(expected)) = (inverse, expected.filter(|expected| expected.detection > 0.0))
            else {
                no_birth += 1;
                continue;
            };
            let own = &inverse.by_measurement * self.models.noise_at(z) * inverse.by_measurement.transpose();
            if w > 0.0 {
                lost += self.initiate_track(state, label, w, &inverse.feature, &own);
            }
            if v <= 0.0 {
                continue;
            }
            if state.features.len() == capacity {
                let total = |place: &usize| state.features[*place].total();
                let weakest = (0..capacity).min_by(|a, b| total(a).total_cmp(&total(b)));
                let Some(weakest) = weakest.filter(|place| total(place) < v) else {
                    lost += 1;
                    continue;
                };
                lost += usize::from(total(&weakest) >= HARDLY_THERE);
                state.drop_feature(weakest);
                association.detection.swap_remove(weakest);
            }
            let by_pose = -&inverse.by_measurement * expected.by_pose;
            add(state, &inverse.feature, &by_pose, &own);
            state.features.push(Feature {
                label,
                in_sight: v,
                hidden: 0.0,
                absent: (1.0 - v).max(LEAST_ABSENT),
                detections: v,
            });
            association.detection.push(0.0);
            births += 1;
        }
        [births, no_birth, lost]
    }

    /// Merges features that are the same. Returns their number.
    pub(super) fn merge(&self, state: &mut State, detection: &mut Vec<f64>) -> usize {
        let pose = state.pose.clone();
        let (mut merged, mut one) = (0, 0);
        while one < state.features.len() {
            let alone = is_established(state, detection, one).then(|| self.told_by_one(&pose, &state.places[one]));
            let mean = place_of(state, one);
            let mut other = one + 1;
            while let Some(alone) = alone.as_ref().and_then(Option::as_ref).filter(|_| other < state.features.len()) {
                let near = is_established(state, detection, other)
                    && squared(&(place_of(state, other) - &mean), alone) <= self.config.merge_distance;
                if near && self.fuse(state, one, other) {
                    state.drop_feature(other);
                    detection.swap_remove(other);
                    merged += 1;
                } else {
                    other += 1;
                }
            }
            one += 1;
        }
        merged
    }

    /// (H* R H*ᵀ)⁻¹ for one measurement of the position.
    fn told_by_one(&self, pose: &[f64], place: &[f64]) -> Option<DMatrix<f64>> {
        let expected = self.models.expected(pose, place)?;
        let inverse = self.models.inverse(pose, expected.measurement.as_slice())?;
        (&inverse.by_measurement
            * self.models.noise_at(expected.measurement.as_slice())
            * inverse.by_measurement.transpose())
        .try_inverse()
    }

    /// Fuses two features by the constraint m_one = m_other, if their distance is within the gate. Returns whether it did.
    pub(super) fn fuse(&self, state: &mut State, one: usize, other: usize) -> bool {
        let apart = Difference::of::<M>(state, one, other);
        let Some(closed) = apart.closed(&apart.difference, &state.covariance) else { return false };
        // NaN is not within the gate.
        if closed.distance.partial_cmp(&self.config.merge_distance).is_none_or(|order| order.is_gt()) {
            return false;
        }
        let moved = closed.moved(state, &apart);
        self.inject_correction(state, &moved);
        // After the correction, the constraint does not depend on a rotation.
        let h = Difference::straight::<M>(state, one, other);
        let s = &h * &state.covariance * h.transpose();
        let Some(factor) = s.clone().cholesky() else { return false };
        let gain = &state.covariance * h.transpose() * factor.inverse();
        state.covariance -= &gain * s * gain.transpose();
        let (a, b) = (state.features[one], state.features[other]);
        let likelier = if a.total() >= b.total() { a } else { b };
        let label = if a.detections >= b.detections { a.label } else { b.label };
        state.features[one] = Feature { label, detections: a.detections + b.detections, ..likelier };
        true
    }

    /// Removes features with a low existence probability, except births of this scan. Returns their number.
    pub(super) fn drop_unlikely(&self, state: &mut State, detection: &mut Vec<f64>, first_label: u32) -> usize {
        let Config { least_existence, least_tentative, .. } = self.config;
        let mut dropped = 0;
        for place in (0..state.features.len()).rev() {
            let feature = state.features[place];
            let is_new = feature.label.wrapping_sub(first_label) < state.next_label.wrapping_sub(first_label);
            let tentative = feature.detections < TWICE && detection[place] > 0.0;
            let least = if tentative { least_tentative.max(least_existence) } else { least_existence };
            if !is_new && feature.total() < least {
                state.drop_feature(place);
                detection.swap_remove(place);
                dropped += 1;
            }
        }
        dropped
    }
}

fn is_established(state: &State, detection: &[f64], place: usize) -> bool {
    let feature = state.features[place];
    detection[place] > 0.0 && feature.detections >= TWICE && feature.total() >= LIKELY
}

/// Adds a feature with P_m· = J P_x· and P_mm = J P_xx Jᵀ + `own`.
fn add(state: &mut State, place: &DVector<f64>, by_pose: &DMatrix<f64>, own: &DMatrix<f64>) {
    let (len, each, uncertain) = (state.covariance.nrows(), place.len(), by_pose.ncols());
    let cross = by_pose * state.covariance.rows(0, uncertain);
    let block = cross.columns(0, uncertain) * by_pose.transpose() + own;
    let mut grown = DMatrix::zeros(len + each, len + each);
    grown.view_mut((0, 0), (len, len)).copy_from(&state.covariance);
    grown.view_mut((len, 0), (each, len)).copy_from(&cross);
    grown.view_mut((0, len), (len, each)).copy_from(&cross.transpose());
    grown.view_mut((len, len), (each, each)).copy_from(&block);
    state.covariance = grown;
    state.places.push(place.iter().copied().collect());
}
