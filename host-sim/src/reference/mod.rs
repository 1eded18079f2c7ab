//! The recursion of `docs/recursion.md` in full precision, written from appendix A of the thesis (C. S. Lee,
//! *SLAM using Single Cluster PHD Filters*, Girona 2014) as plainly as possible: `f64`, the heap, every
//! component against every measurement.
//!
//! It is what the filter is measured against, so it shares nothing with it but that page, and where
//! there is a choice of formula it takes another one. Every step can be run alone, on a [`State`] copied
//! from any other filter and on that filter's random numbers.
//!
//! ```
//! use scphd_sim::log::Vehicle;
//! use scphd_sim::reference::*;
//! use scphd_sim::settings::Likelihood;
//!
//! let field_of_view = FieldOfView {
//!     range_min_m: 0.0,
//!     range_max_m: 15.0,
//!     range_edge_m: 0.0,
//!     bearing_center_rad: 0.0,
//!     bearing_half_width_rad: std::f64::consts::PI,
//!     bearing_edge_rad: 0.0,
//!     p_near: 0.95,
//!     p_far: 0.95,
//! };
//! let reference = Reference {
//!     config: Config {
//!         particles: 8,
//!         samples: 2,
//!         birth_intensity: 0.01,
//!         clutter_intensity: field_of_view.clutter_intensity(5.0),
//!         resample_threshold: 0.5,
//!         prune_weight: 1e-5,
//!         merge_distance: 4.0,
//!         max_components: 100,
//!         extraction_weight: 0.0,
//!         likelihood: Likelihood::SingleCluster,
//!         moving: MovingConfig {
//!             birth_intensity: 0.0,
//!             velocity_sigma_mps: 1.0,
//!             acceleration_psd: 0.1,
//!             lifetime_s: 100.0,
//!             spread_max_m: 3.0,
//!             extraction_weight: 0.0,
//!         },
//!     },
//!     motion: Motion {
//!         vehicle: Vehicle::Unicycle,
//!         noise: ControlNoise { speed_sigma_mps: 0.1, second_sigma: 0.01, speed_ratio: 0.0, second_ratio: 0.0, interval_s: 0.0 },
//!     },
//!     mounting: [0.0; 3],
//!     sensor: RangeBearing { range_sigma_m: 0.25, bearing_sigma_rad: 0.01 },
//!     field_of_view,
//! };
//! let mut draws = OwnDraws::new(1);
//! let mut state = reference.initial([0.0; 3]);
//! for _ in 0..5 {
//!     reference.predict(&mut state, &[1.0, 0.0], 0.1, &mut draws);
//!     reference.scan(&mut state, &[[5.0, 0.3]], &mut draws);
//! }
//! assert_eq!(reference.estimate(&state).features.len(), 1);
//! ```

mod algebra;
mod angle;
mod draws;
mod extract;
mod field_of_view;
mod gaussian;
mod likelihood;
mod log_domain;
mod motion;
mod moving;
mod pre_update;
mod predict;
mod reduce;
mod resample;
mod sensor;
mod sight;
pub mod space;
mod state;
mod update;

#[cfg(test)]
mod oracles;
#[cfg(test)]
mod tests;

pub use draws::{Draws, OwnDraws};
pub use extract::Estimate;
pub use field_of_view::FieldOfView;
pub use gaussian::{Component, Matrix, Vector};
pub use motion::{ControlNoise, Motion};
pub use moving::MovingConfig;
pub use resample::Selection;
pub use sensor::{RangeBearing, Sensor};
pub use state::{Candidate, Particle, State};

use crate::settings::Likelihood;
use log_domain::normalised;
use sight::Sight;

/// Parameters of the recursion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    /// N, number of particles.
    pub particles: usize,
    /// M, candidates drawn for each particle between scans.
    pub samples: usize,
    /// w_b, intensity of births on a measurement, 1/(m·rad).
    pub birth_intensity: f64,
    /// κ, intensity of false measurements, 1/(m·rad).
    pub clutter_intensity: f64,
    /// The candidates are resampled where N_eff is below this fraction of their number.
    pub resample_threshold: f64,
    /// Components lighter than this are dropped.
    pub prune_weight: f64,
    /// Squared Mahalanobis distance up to which components are merged.
    pub merge_distance: f64,
    /// How many components of each kind the reduction leaves in view at most, for each particle; births that wait for the
    /// next scan are not counted.
    pub max_components: usize,
    /// Components lighter than this are no estimated features.
    pub extraction_weight: f64,
    /// The particle likelihood.
    pub likelihood: Likelihood,
    /// Moving features.
    pub moving: MovingConfig,
}

/// What the measurements say about each candidate.
#[derive(Debug, Clone, PartialEq)]
pub struct Weighing {
    /// ln L of each candidate (4.52, or that of the other likelihood), without the clutter rate λ.
    pub ln_likelihoods: Vec<f64>,
    /// ln ζ of each candidate after the scan, normalised (5.23).
    pub ln_weights: Vec<f64>,
    /// N_eff = 1/Σ ζ².
    pub n_eff: f64,
    /// Whether every ζ L was zero, so that the weights stayed as they were.
    pub weights_kept: bool,
}

/// What a scan did.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanOutcome {
    /// The weighing of the candidates.
    pub weighing: Weighing,
    /// The selection among them.
    pub selection: Selection,
}

/// The filter: parameters and models. What changes is in [`State`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference {
    /// Parameters of the recursion.
    pub config: Config,
    /// Motion of the vehicle.
    pub motion: Motion,
    /// Where the sensor sits, seen from where the pose is: ahead m, to the left m, turned to the left rad.
    pub mounting: [f64; 3],
    /// Measurement model.
    pub sensor: RangeBearing,
    /// Where features are detected, and how likely.
    pub field_of_view: FieldOfView,
}

impl Reference {
    /// The state before anything happened: N equal particles at a pose (m, m, rad), empty maps.
    pub fn initial(&self, pose: [f64; 3]) -> State {
        State::new(self.config.particles, pose)
    }

    /// Predicts over `dt` seconds (0 or more) under a control: speed in m/s, then steering angle in rad
    /// or turn rate in rad/s (5.11–5.13).
    pub fn predict(&self, state: &mut State, control: &[f64; 2], dt: f64, draws: &mut dyn Draws) {
        predict::predict(state, self.config.samples, &self.motion, control, dt, draws);
    }

    /// One scan of measurements (m, rad): [`weigh`](Self::weigh), [`select`](Self::select),
    /// [`update`](Self::update).
    pub fn scan(&self, state: &mut State, measurements: &[Vector], draws: &mut dyn Draws) -> ScanOutcome {
        let weighing = self.weigh(state, measurements);
        let selection = self.select(state, &weighing, draws);
        self.update(state, measurements, &weighing, &selection);
        ScanOutcome { weighing, selection }
    }

    /// Weighs every candidate against the measurements (4.52, 5.23). A map is read, never written; the moving parts
    /// are read as they are at the time of the last prediction.
    pub fn weigh(&self, state: &State, measurements: &[Vector]) -> Weighing {
        let (candidates, samples) = (state.current(), state.samples());
        let moving: Vec<_> = (0..state.particles.len()).map(|i| self.moving_now(state, i)).collect();
        let ln_likelihoods: Vec<f64> = candidates
            .iter()
            .enumerate()
            .map(|(c, candidate)| (candidate.pose, c / samples))
            .map(|(pose, i)| self.ln_likelihood(pose, &state.particles[i].map, &moving[i], measurements))
            .collect();
        let before: Vec<f64> = candidates.iter().map(|c| c.ln_weight).collect();
        let after: Vec<f64> = before.iter().zip(&ln_likelihoods).map(|(w, l)| w + l).collect();
        let updated = normalised(&after);
        let weights_kept = updated.is_none();
        let ln_weights = updated.or_else(|| normalised(&before)).expect("some candidate weighs something");
        Weighing { n_eff: resample::effective_number(&ln_weights), ln_likelihoods, ln_weights, weights_kept }
    }

    /// Selects the candidates that go on.
    pub fn select(&self, state: &State, weighing: &Weighing, draws: &mut dyn Draws) -> Selection {
        resample::select(
            &weighing.ln_weights,
            weighing.n_eff,
            state.particles.len(),
            self.config.resample_threshold,
            draws,
        )
    }

    /// Writes the survivors: their poses and weights, and their maps updated by the measurements.
    pub fn update(&self, state: &mut State, measurements: &[Vector], weighing: &Weighing, selection: &Selection) {
        let (candidates, samples) = (state.current(), state.samples());
        let mut particles: Vec<Particle> = Vec::with_capacity(selection.survivors.len());
        for (i, (&survivor, &ln_weight)) in selection.survivors.iter().zip(&selection.ln_weights).enumerate() {
            let pose = candidates[survivor].pose;
            // Survivors come in order, so copies of one stand next to each other.
            let (map, moving) = if i > 0 && selection.survivors[i - 1] == survivor {
                (particles[i - 1].map.clone(), particles[i - 1].moving.clone())
            } else {
                let parent = survivor / samples;
                let moving = self.moving_now(state, parent);
                self.updated_maps(pose, &state.particles[parent].map, &moving, measurements)
            };
            particles.push(Particle { pose, ln_weight, map, moving });
        }
        // The heaviest candidate itself may not have gone on: then the heaviest that did.
        let mut heaviest = 0;
        for (i, &survivor) in selection.survivors.iter().enumerate() {
            let best = selection.survivors[heaviest];
            if weighing.ln_weights[survivor] > weighing.ln_weights[best] {
                heaviest = i;
            }
        }
        *state = State { particles, candidates: None, waited_s: 0.0, heaviest };
    }

    /// The moving part of a particle's map at the time of the last prediction.
    pub fn moving_now(&self, state: &State, particle: usize) -> Vec<Component<4>> {
        moving::predicted(&state.particles[particle].moving, state.waited_s, &self.config)
    }

    /// ln L of one pose (m, m, rad) with the two parts of a map, without the clutter rate λ.
    pub fn ln_likelihood(
        &self,
        pose: [f64; 3],
        map: &[Component],
        moving: &[Component<4>],
        measurements: &[Vector],
    ) -> f64 {
        likelihood::ln_likelihood(self.config.likelihood, &self.sight(pose, map, moving, measurements))
    }

    /// The two parts of a map updated by the measurements from one pose and reduced (5.17–5.22, appendix A). Of each
    /// part, components out of view come first, untouched; the reduced ones follow, heaviest first; then come the births
    /// on unexplained measurements, in the measurements' order, which wait for the next scan to be reduced.
    pub fn updated_maps(
        &self,
        pose: [f64; 3],
        map: &[Component],
        moving: &[Component<4>],
        measurements: &[Vector],
    ) -> (Vec<Component>, Vec<Component<4>>) {
        let sight = self.sight(pose, map, moving, measurements);
        let born = |intensity| update::born(&sight, &self.field_of_view, intensity);
        let MovingConfig { birth_intensity, velocity_sigma_mps, .. } = self.config.moving;
        let births = born(self.config.birth_intensity);
        let moving_births = born(birth_intensity).set_in_motion(velocity_sigma_mps);

        let Sight { still, moving, ln_eta, .. } = sight;
        let (persisting, moving_persisting) =
            (update::persisting(&still, &ln_eta), update::persisting(&moving, &ln_eta));
        (
            update::after_scan(still.out_of_view, persisting, births, &self.config),
            update::after_scan(moving.out_of_view, moving_persisting, moving_births, &self.config),
        )
    }

    /// Pose and map as the state has them (5.2.7), the moving part at the time of the last prediction.
    pub fn estimate(&self, state: &State) -> Estimate {
        let least_weights = [self.config.extraction_weight, self.config.moving.extraction_weight];
        extract::estimate(state, &self.moving_now(state, state.heaviest), least_weights)
    }

    /// The pose of the sensor of a vehicle at `pose`.
    fn seat(&self, [x, y, heading]: [f64; 3]) -> [f64; 3] {
        let [forward, left, yaw] = self.mounting;
        let (sin, cos) = heading.sin_cos();
        [x + forward * cos - left * sin, y + forward * sin + left * cos, heading + yaw]
    }

    fn sight<'a>(
        &'a self,
        pose: [f64; 3],
        map: &[Component],
        moving: &[Component<4>],
        measurements: &'a [Vector],
    ) -> Sight<'a, RangeBearing> {
        Sight::new(self.seat(pose), map, moving, measurements, &self.sensor, &self.field_of_view, &self.config)
    }
}
