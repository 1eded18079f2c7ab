//! Loop closure: finds landmarks that were initiated twice, by the joint consistency of the landmarks around them.

use super::Joint;
use super::difference::{Closed, Difference, place_of};
use super::models::Models;
use super::state::State;
use std::f64::consts::TAU;

/// Least number of detections of a feature that is fused with another one,
const SEEN: f64 = 3.0;
/// and its least existence probability.
const LIKELY: f64 = 0.5;
/// Prior probability that a feature around a fused one was mapped before, too.
const KNOWN: f64 = 0.5;
/// Least probability that two features are the same.
const SURE: f64 = 0.99;
/// Greatest number of candidates for one feature.
const CHOICES: usize = 8;
/// Greatest number of candidates for each feature around it.
const NEIGHBOURS: usize = 3;
/// Number of features that are tried.
const SEEDS: usize = 6;

impl<M: Models> Joint<M> {
    /// Fuses one of the features in view with most detections with the feature that is surely the same. Returns the number of
    /// fused ones.
    pub(super) fn close_loop(&self, state: &mut State, detection: &mut Vec<f64>) -> usize {
        let Some((one, other)) = self.found(state, detection) else { return 0 };
        if !self.fuse(state, one, other) {
            return 0;
        }
        state.drop_feature(other);
        detection.swap_remove(other);
        1
    }

    fn found(&self, state: &State, detection: &[f64]) -> Option<(usize, usize)> {
        let known: Vec<usize> = (0..state.features.len()).filter(|&place| is_known(state, place)).collect();
        let in_view: Vec<usize> = known.iter().copied().filter(|&place| detection[place] > 0.0).collect();
        let side = |d: usize| {
            let of_all = || known.iter().map(|&place| state.places[place][d]);
            of_all().fold(f64::NEG_INFINITY, f64::max) - of_all().fold(f64::INFINITY, f64::min)
        };
        let density = known.len() as f64 / (0..M::FEATURE).map(side).product::<f64>();
        if !density.is_finite() {
            return None;
        }
        let mut seeds = in_view.clone();
        let detections = |place: usize| state.features[place].detections;
        seeds.sort_by(|&a, &b| detections(b).total_cmp(&detections(a)));
        seeds.truncate(SEEDS);
        let of_each = seeds.iter().filter_map(|&one| {
            let (other, evidence) = self.what_it_is(state, &known, &in_view, one, density)?;
            Some((one, other, evidence))
        });
        let found: Vec<(usize, usize, f64)> = of_each.collect();
        let (one, other, _) = found.into_iter().rev().max_by(|a, b| a.2.total_cmp(&b.2))?;
        Some((one, other))
    }

    /// The feature that is surely the same, and its evidence.
    fn what_it_is(
        &self,
        state: &State,
        known: &[usize],
        in_view: &[usize],
        one: usize,
        density: f64,
    ) -> Option<(usize, f64)> {
        let mut choices: Vec<(usize, f64)> = known
            .iter()
            .filter(|&&other| other != one)
            .filter_map(|&other| {
                let apart = Difference::of::<M>(state, one, other);
                Some((other, apart.closed(&apart.difference, &state.covariance)?.distance))
            })
            .filter(|&(_, distance)| distance <= self.config.merge_distance)
            .collect();
        choices.sort_by(|a, b| a.1.total_cmp(&b.1));
        choices.truncate(CHOICES);
        let evidence: Vec<(usize, f64)> = choices
            .iter()
            .map(|&(other, _)| (other, self.evidence(state, known, in_view, [one, other], density)))
            .collect();
        let all = 1.0 + evidence.iter().map(|&(_, of_one)| of_one).sum::<f64>();
        let (other, most) = evidence.into_iter().rev().max_by(|a, b| a.1.total_cmp(&b.1))?;
        (most / all >= SURE).then_some((other, most))
    }

    /// Evidence that two features are the same: the likelihood ratio to the hypothesis that no feature in view was mapped before.
    fn evidence(
        &self,
        state: &State,
        known: &[usize],
        in_view: &[usize],
        [one, other]: [usize; 2],
        density: f64,
    ) -> f64 {
        // The whole state under the condition that the two are the same.
        let apart = Difference::of::<M>(state, one, other);
        let closed = apart.closed(&apart.difference, &state.covariance).expect("two places");
        let inverse = closed.covariance.clone().try_inverse().expect("it was factored");
        let gain = &state.covariance * apart.h.transpose() * inverse;
        let covariance = &state.covariance - &gain * &closed.covariance * gain.transpose();
        let moved = closed.moved(state, &apart);
        let place = |of: usize| place_of(state, of) + moved.rows(state.first(of), M::FEATURE);
        let is_another = |of: &usize| *of != one && *of != other;
        let mut evidence = KNOWN * state.features[other].total() * normal(&closed) / density;
        for &around in in_view.iter().filter(|of| is_another(of)) {
            let apart = |of: usize| place(of) - place(around);
            let mut near: Vec<usize> = known.iter().copied().filter(|of| is_another(of) && *of != around).collect();
            near.sort_by(|&a, &b| apart(a).norm_squared().total_cmp(&apart(b).norm_squared()));
            near.truncate(NEIGHBOURS);
            let fits = near.iter().map(|&of| {
                let closed = Difference::of::<M>(state, around, of).closed(&apart(of), &covariance);
                state.features[of].total() * closed.as_ref().map_or(0.0, normal) / density
            });
            evidence *= 1.0 - KNOWN + KNOWN * fits.sum::<f64>();
        }
        evidence
    }
}

fn is_known(state: &State, place: usize) -> bool {
    let feature = state.features[place];
    feature.detections >= SEEN && feature.total() >= LIKELY
}

/// N(y; 0, C).
fn normal(closed: &Closed) -> f64 {
    let Closed { off, covariance, distance, .. } = closed;
    (-0.5 * distance).exp() / (TAU.powi(off.len() as i32) * covariance.determinant()).sqrt()
}
