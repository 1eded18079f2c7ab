//! The steps of the recursion, generic over the vehicle, which supplies motion, likelihood and the update of a map.

use super::config::{Config, ScanOutcome, Weighing};
use super::draws::Draws;
use super::gaussian::Component;
use super::log_domain::normalised;
use super::predict;
use super::resample::{self, Selection};
use super::state::{Particle, State};

/// A filter with `N` numbers for a static feature and `V` for a moving one.
pub trait Recursion<const N: usize, const V: usize> {
    type Pose: Copy;
    type Control;
    type Measurement;

    fn config(&self) -> &Config;

    /// A sample of the transition over `dt` seconds (5.12).
    fn moved(&self, pose: &Self::Pose, control: &Self::Control, dt: f64, draws: &mut dyn Draws) -> Self::Pose;

    /// The moving part of a map, predicted by this time after its scan, s.
    fn moving_now(&self, moving: &[Component<V>], waited_s: f64) -> Vec<Component<V>>;

    /// ln L of a pose for both parts of a map, without the clutter rate λ.
    fn ln_likelihood(
        &self,
        pose: &Self::Pose,
        map: &[Component<N>],
        moving: &[Component<V>],
        measurements: &[Self::Measurement],
    ) -> f64;

    /// Both parts of a map updated by the measurements from a pose and reduced (5.17–5.22, appendix A). In each part the order
    /// is: unchanged components out of view; reduced ones, heaviest first; births on unexplained measurements in the order of the
    /// measurements, which are reduced in the next scan.
    fn updated_maps(
        &self,
        pose: &Self::Pose,
        map: &[Component<N>],
        moving: &[Component<V>],
        measurements: &[Self::Measurement],
    ) -> (Vec<Component<N>>, Vec<Component<V>>);

    fn estimated(&self, state: &State<Self::Pose, N, V>) -> Self::Pose;

    /// Predicts over `dt` seconds (0 or more) under a control (5.11–5.13).
    fn predict(&self, state: &mut State<Self::Pose, N, V>, control: &Self::Control, dt: f64, draws: &mut dyn Draws) {
        predict::predict(state, self.config().samples, dt, |pose| self.moved(pose, control, dt, draws));
    }

    /// Processes a scan: [`weigh`](Self::weigh), [`select`](Self::select), [`update`](Self::update).
    fn scan(
        &self,
        state: &mut State<Self::Pose, N, V>,
        measurements: &[Self::Measurement],
        draws: &mut dyn Draws,
    ) -> ScanOutcome {
        let weighing = self.weigh(state, measurements);
        let selection = self.select(state, &weighing, draws);
        self.update(state, measurements, &weighing, &selection);
        ScanOutcome { weighing, selection }
    }

    /// Weighs every candidate with the measurements (4.52, 5.23). Maps are not changed; the moving parts are those at the time of
    /// the last prediction.
    fn weigh(&self, state: &State<Self::Pose, N, V>, measurements: &[Self::Measurement]) -> Weighing {
        let (candidates, samples) = (state.current(), state.samples());
        let moving: Vec<_> =
            state.particles.iter().map(|particle| self.moving_now(&particle.moving, state.waited_s)).collect();
        let ln_likelihoods: Vec<f64> = candidates
            .iter()
            .enumerate()
            .map(|(c, candidate)| (candidate.pose, c / samples))
            .map(|(pose, i)| self.ln_likelihood(&pose, &state.particles[i].map, &moving[i], measurements))
            .collect();
        let before: Vec<f64> = candidates.iter().map(|c| c.ln_weight).collect();
        let after: Vec<f64> = before.iter().zip(&ln_likelihoods).map(|(w, l)| w + l).collect();
        let updated = normalised(&after);
        let weights_kept = updated.is_none();
        let ln_weights = updated.or_else(|| normalised(&before)).expect("some candidate weighs something");
        Weighing { n_eff: resample::effective_number(&ln_weights), ln_likelihoods, ln_weights, weights_kept }
    }

    fn select(&self, state: &State<Self::Pose, N, V>, weighing: &Weighing, draws: &mut dyn Draws) -> Selection {
        let threshold = self.config().resample_threshold;
        resample::select(&weighing.ln_weights, weighing.n_eff, state.particles.len(), threshold, draws)
    }

    /// Writes the survivors: poses and weights, and maps updated by the measurements.
    fn update(
        &self,
        state: &mut State<Self::Pose, N, V>,
        measurements: &[Self::Measurement],
        weighing: &Weighing,
        selection: &Selection,
    ) {
        let (candidates, samples) = (state.current(), state.samples());
        let mut particles: Vec<Particle<Self::Pose, N, V>> = Vec::with_capacity(selection.survivors.len());
        for (i, (&survivor, &ln_weight)) in selection.survivors.iter().zip(&selection.ln_weights).enumerate() {
            let pose = candidates[survivor].pose;
            // Survivors are in order, so that copies of one are adjacent.
            let (map, moving) = if i > 0 && selection.survivors[i - 1] == survivor {
                (particles[i - 1].map.clone(), particles[i - 1].moving.clone())
            } else {
                let parent = &state.particles[survivor / samples];
                let moving = self.moving_now(&parent.moving, state.waited_s);
                self.updated_maps(&pose, &parent.map, &moving, measurements)
            };
            particles.push(Particle { pose, ln_weight, map, moving });
        }
        // If the heaviest candidate did not survive, the heaviest survivor is taken.
        let mut heaviest = 0;
        for (i, &survivor) in selection.survivors.iter().enumerate() {
            let best = selection.survivors[heaviest];
            if weighing.ln_weights[survivor] > weighing.ln_weights[best] {
                heaviest = i;
            }
        }
        *state = State { particles, candidates: None, waited_s: 0.0, heaviest };
    }
}
