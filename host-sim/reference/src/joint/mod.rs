//! The joint filter of `docs/joint.md` in double precision, written from that page as simply as possible: on the heap, with full
//! matrices, all pairs of features and measurements, all messages written out, and automatic differentiation.
//!
//! It shares only that page with the filter. It has no counterpart of the filter's measures against rounding and against numbers
//! out of range.

mod associate;
mod correct;
mod difference;
mod dual;
mod loop_closure;
mod map_management;
mod models;
mod mover;
mod movers;
mod planar;
mod space;
mod state;
#[cfg(test)]
mod tests;

pub use models::{Expected, Inverse, Models, Moved};
pub use mover::{Mover, Moving};
pub use planar::Planar;
pub use state::{Feature, State};

/// Parameters, named as in `docs/joint.md` and in the filter's configuration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    /// w_b.
    pub birth_intensity: f64,
    /// Least probability that a measurement is unexplained for a birth.
    pub birth_probability_min: f64,
    /// Greatest squared Mahalanobis distance of a measurement from its prediction.
    pub gate: f64,
    /// Mean time for which a landmark is visible, s.
    pub visible_s: f64,
    /// Mean time for which it is occluded, s.
    pub occluded_s: f64,
    /// Mean time until it is removed, s.
    pub lifetime_s: f64,
    /// Share of p_D behind a nearer detection.
    pub occlusion_factor: f64,
    /// Least existence probability of a feature.
    pub least_existence: f64,
    /// The same for a tentative one in view.
    pub least_tentative: f64,
    /// Greatest squared Mahalanobis distance of features that are merged.
    pub merge_distance: f64,
    /// Greatest number of features.
    pub capacity: usize,
    /// Moving objects, if there may be any.
    pub moving: Option<Moving>,
}

/// The result of a scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Features in view before the scan.
    pub in_view: usize,
    pub births: usize,
    /// Measurements without an inverse in view.
    pub no_birth: usize,
    /// Births, or features replaced by them, that were lost for lack of capacity.
    pub lost: usize,
    pub merged: usize,
    pub dropped: usize,
    /// ln L.
    pub ln_evidence: f64,
    /// Mean squared innovation divided by its dimension; 0 without detections.
    pub innovation: f64,
}

/// The filter: parameters and models. Its state is in [`State`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint<M> {
    pub config: Config,
    pub models: M,
}

impl<M: Models> Joint<M> {
    pub fn initial(&self, pose: Vec<f64>) -> State {
        State::new(pose, M::POSE)
    }

    pub fn predict(&self, state: &mut State, control: &M::Control, dt: f64) {
        state.waited_s += dt;
        let Moved { pose, transition, noise } = self.models.moved(&state.pose, control, dt);
        state.pose = pose;
        let rows = &transition * state.covariance.rows(0, M::POSE);
        state.covariance.rows_mut(0, M::POSE).copy_from(&rows);
        let columns = state.covariance.columns(0, M::POSE) * transition.transpose();
        state.covariance.columns_mut(0, M::POSE).copy_from(&columns);
        let mut own = state.covariance.view_mut((0, 0), (M::POSE, M::POSE));
        own += &noise;
        state.process_noise = &transition * &state.process_noise * transition.transpose() + noise;
    }

    pub fn scan(&self, state: &mut State, measurements: &[&[f64]]) -> Outcome {
        self.advance(state);
        self.pass_time(state);
        self.bound_movers(state);
        let mut association = self.associate(state, measurements);
        let in_view = association.detection.iter().filter(|&&p| p > 0.0).count();
        let innovations = self.correct(state, &association, measurements);
        self.correct_movers(state, &association, measurements);
        let united = self.manage_tracks(state);
        let first_label = state.next_label;
        let [births, no_birth, lost] = self.initiate(state, &mut association, measurements);
        let mut merged = united + self.merge(state, &mut association.detection);
        if association.weak > 0 {
            merged += self.close_loop(state, &mut association.detection);
        }
        let dropped = self.drop_unlikely(state, &mut association.detection, first_label);
        let dimension = self.models.noise().nrows() as f64;
        let innovation =
            if innovations.shares > 0.0 { innovations.squares / (innovations.shares * dimension) } else { 0.0 };
        let ln_evidence = association.ln_evidence;
        Outcome { in_view, births, no_birth, lost, merged, dropped, ln_evidence, innovation }
    }
}
