//! Moving-object tracks beside the joint map, as in `docs/joint.md`.

use super::Joint;
use super::associate::{Association, squared};
use super::models::Models;
use super::mover::{Mover, Sight};
use super::state::State;
use nalgebra::{DMatrix, DVector};

impl<M: Models> Joint<M> {
    /// Predicts all tracks, and drops those that are unlikely or too uncertain.
    pub(super) fn advance(&self, state: &mut State) {
        let Some(moving) = &self.config.moving else { return };
        if state.waited_s > 0.0 {
            state.movers.iter_mut().for_each(|mover| mover.advance(state.waited_s, moving));
        }
        self.drop_movers(state);
    }

    /// Limits the weights of tracks: an object is static or moving, and merging may have raised the sum of both above one.
    pub(super) fn bound_movers(&self, state: &mut State) {
        for mover in &mut state.movers {
            if let Some(rival) = state.features.iter().find(|feature| feature.label == mover.label) {
                mover.weight = mover.weight.min(rival.absent);
            }
        }
    }

    fn drop_movers(&self, state: &mut State) {
        let Some(moving) = &self.config.moving else { return };
        for place in (0..state.movers.len()).rev() {
            let mover = &state.movers[place];
            let near = (0..M::FEATURE).all(|k| mover.covariance[(k, k)] <= moving.spread_max_m.powi(2));
            if !near || mover.weight < self.config.least_existence {
                state.movers.swap_remove(place);
            }
        }
    }

    pub(super) fn sight(&self, state: &State, mover: &Mover) -> Option<Sight> {
        let expected = self.models.expected(&state.pose, mover.position())?;
        let noise = self.models.noise_at(expected.measurement.as_slice())
            + &expected.by_pose * &state.process_noise * expected.by_pose.transpose();
        Some(Sight { h: mover.h(&expected), noise, expected })
    }

    /// Updates the tracks with a scan: the mixture over all associations is replaced by one Gaussian.
    pub(super) fn correct_movers(&self, state: &mut State, association: &Association, measurements: &[&[f64]]) {
        let mut movers = std::mem::take(&mut state.movers);
        for (place, mover) in movers.iter_mut().enumerate() {
            let not_detected = association.mover_not_detected[place];
            if not_detected >= 1.0 {
                continue;
            }
            let shares: Vec<f64> = association.mover_shares.row(place).iter().copied().collect();
            let seen: f64 = shares.iter().sum();
            let of_rival = association.rivals[place].map_or(0.0, |rival| association.shares.row(rival).sum());
            let missed = (1.0 - seen - of_rival).max(0.0) / not_detected
                * mover.weight
                * (1.0 - association.mover_detection[place]);
            if let Some(sight) = self.sight(state, mover).filter(|_| seen > 0.0) {
                let gain = &mover.covariance
                    * sight.h.transpose()
                    * sight.covariance(mover).try_inverse().expect("R is positive definite");
                let corrected = &mover.covariance - &gain * &sight.h * &mover.covariance;
                let mut ways = vec![(missed, mover.mean.clone(), mover.covariance.clone())];
                for (&share, z) in shares.iter().zip(measurements).filter(|&(&share, _)| share > 0.0) {
                    let innovation = self.models.innovation(z, &sight.expected.measurement);
                    ways.push((share, &mover.mean + &gain * innovation, corrected.clone()));
                }
                (mover.mean, mover.covariance) = moments(&ways);
            }
            mover.weight = (seen + missed).min(1.0);
        }
        state.movers = movers;
        state.process_noise.fill(0.0);
    }

    /// Merges tracks with equal position and velocity, and drops unlikely ones. Returns the number of merged ones.
    pub(super) fn manage_tracks(&self, state: &mut State) -> usize {
        let (mut united, mut one) = (0, 0);
        while one < state.movers.len() {
            let mut other = one + 1;
            while other < state.movers.len() {
                let (a, b) = (&state.movers[one], &state.movers[other]);
                let apart = &a.mean - &b.mean;
                let within = |mover: &Mover| {
                    let inverse = mover.covariance.clone().try_inverse();
                    inverse.is_some_and(|inverse| squared(&apart, &inverse) <= self.config.merge_distance)
                };
                if !(within(a) && within(b)) {
                    other += 1;
                    continue;
                }
                let step = |mover: &Mover| (mover.weight.ln() * 65_536.0 + 0.5).floor();
                let first = step(b)
                    .total_cmp(&step(a))
                    .then_with(|| a.mean.as_slice().partial_cmp(b.mean.as_slice()).expect("numbers"));
                let label = if first.is_gt() { b.label } else { a.label };
                let ways = [a, b].map(|mover| (mover.weight, mover.mean.clone(), mover.covariance.clone()));
                let (mean, covariance) = moments(&ways);
                let weight = (a.weight + b.weight).min(1.0);
                state.movers[one] = Mover { label, weight, mean, covariance };
                state.movers.swap_remove(other);
                united += 1;
            }
            one += 1;
        }
        self.drop_movers(state);
        united
    }

    /// Initiates a track with a measurement. Returns the number of tracks lost for lack of capacity.
    pub(super) fn initiate_track(
        &self,
        state: &mut State,
        label: u32,
        weight: f64,
        place: &DVector<f64>,
        own: &DMatrix<f64>,
    ) -> usize {
        let Some(moving) = &self.config.moving else { return 0 };
        let each = place.len();
        let mean = DVector::from_fn(2 * each, |k, _| if k < each { place[k] } else { 0.0 });
        let velocity = moving.velocity_sigma_mps.powi(2);
        let covariance =
            DMatrix::from_fn(2 * each, 2 * each, |row, column| match (row < each && column < each, row == column) {
                (true, _) => own[(row, column)],
                (false, true) => velocity,
                (false, false) => 0.0,
            });
        let born = Mover { label, weight, mean, covariance };
        if state.movers.len() < moving.capacity {
            state.movers.push(born);
            return 0;
        }
        let weakest =
            (0..state.movers.len()).min_by(|&a, &b| state.movers[a].weight.total_cmp(&state.movers[b].weight));
        if let Some(weakest) = weakest.filter(|&place| state.movers[place].weight < weight) {
            state.movers[weakest] = born;
        }
        1
    }
}

/// Mean and covariance of a mixture of weights, means and covariances.
fn moments(ways: &[(f64, DVector<f64>, DMatrix<f64>)]) -> (DVector<f64>, DMatrix<f64>) {
    let all: f64 = ways.iter().map(|way| way.0).sum();
    let mean = ways.iter().map(|(weight, mean, _)| mean * (weight / all)).sum::<DVector<f64>>();
    let covariance = ways
        .iter()
        .map(|(weight, of, covariance)| (covariance + (of - &mean) * (of - &mean).transpose()) * (weight / all))
        .sum::<DMatrix<f64>>();
    (mean, covariance)
}
