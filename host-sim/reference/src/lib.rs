//! The recursion of `docs/recursion.md` in double precision, written from appendix A of the thesis (C. S. Lee, *SLAM using Single
//! Cluster PHD Filters*, Girona 2014) as simply as possible: on the heap, with all pairs of components and measurements.
//!
//! The filter is compared with it; therefore it shares only that page with the filter, and uses other formulas where possible.
//! Every step can be run separately, on a [`State`] copied from another filter and with that filter's random numbers.
//!
//! ```
//! use scphd_reference::*;
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
//!         remembering: Remembering::NOTHING,
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
//!     sensor: RangeBearing { range_sigma_m: 0.25, range_sigma_ratio: 0.0, bearing_sigma_rad: 0.01 },
//!     field_of_view,
//! };
//! let mut draws = OwnDraws::new(1);
//! let mut state = reference.initial([0.0; 3]);
//! for _ in 0..5 {
//!     reference.predict(&mut state, &[1.0, 0.0, 0.0], 0.1, &mut draws);
//!     reference.scan(&mut state, &[[5.0, 0.3]], &mut draws);
//! }
//! assert_eq!(reference.estimate(&state).features.len(), 1);
//! ```

mod algebra;
mod angle;
mod config;
mod draws;
mod extract;
mod field_of_view;
mod gaussian;
pub mod joint;
mod likelihood;
mod log_domain;
mod motion;
mod moving;
mod pre_update;
mod predict;
mod recursion;
mod reduce;
mod resample;
mod sensor;
mod sight;
pub mod space;
mod state;
mod update;
mod vehicle;

#[cfg(test)]
mod oracles;
#[cfg(test)]
mod tests;

pub use config::{Config, Likelihood, MovingConfig, Remembering, ScanOutcome, Weighing};
pub use draws::{Draws, OwnDraws};
pub use extract::Estimate;
pub use field_of_view::FieldOfView;
pub use gaussian::{Component, Matrix, Vector};
pub use motion::{ControlNoise, Motion};
pub use recursion::Recursion;
pub use resample::Selection;
pub use sensor::{RangeBearing, Sensor};
pub use state::{Candidate, Particle, State};
pub use vehicle::Vehicle;

use sight::Sight;

/// The filter: parameters and models. Its state is in [`State`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference {
    pub config: Config,
    pub motion: Motion,
    /// Mounting of the sensor relative to the pose: ahead m, to the left m, turned to the left rad.
    pub mounting: [f64; 3],
    pub sensor: RangeBearing,
    /// Field of view with the probability of detection.
    pub field_of_view: FieldOfView,
}

impl Reference {
    /// The initial state: N equal particles at a pose (m, m, rad), with empty maps.
    pub fn initial(&self, pose: [f64; 3]) -> State {
        State::new(self.config.particles, pose)
    }

    /// The estimated pose and map (5.2.7), the moving part at the time of the last prediction.
    pub fn estimate(&self, state: &State) -> Estimate {
        let least_weights = [self.config.extraction_weight, self.config.moving.extraction_weight];
        extract::estimate(
            state,
            &self.moving_now(&state.particles[state.heaviest].moving, state.waited_s),
            least_weights,
        )
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

impl Recursion<2, 4> for Reference {
    /// x m, y m, heading rad.
    type Pose = [f64; 3];
    /// Speed in m/s, then steering angle in rad or turn rate in rad/s, then speed to the left in m/s.
    type Control = [f64; 3];
    /// Range m, bearing rad.
    type Measurement = Vector;

    fn config(&self) -> &Config {
        &self.config
    }

    fn moved(&self, pose: &[f64; 3], control: &[f64; 3], dt: f64, draws: &mut dyn Draws) -> [f64; 3] {
        self.motion.sample(*pose, control, dt, draws)
    }

    fn moving_now(&self, moving: &[Component<4>], waited_s: f64) -> Vec<Component<4>> {
        moving::predicted(moving, waited_s, &self.config)
    }

    fn ln_likelihood(
        &self,
        pose: &[f64; 3],
        map: &[Component],
        moving: &[Component<4>],
        measurements: &[Vector],
    ) -> f64 {
        likelihood::ln_likelihood(self.config.likelihood, &self.sight(*pose, map, moving, measurements))
    }

    fn updated_maps(
        &self,
        pose: &[f64; 3],
        map: &[Component],
        moving: &[Component<4>],
        measurements: &[Vector],
    ) -> (Vec<Component>, Vec<Component<4>>) {
        let sight = self.sight(*pose, map, moving, measurements);
        let born = |intensity| update::born(&sight, &self.field_of_view, intensity);
        let MovingConfig { birth_intensity, velocity_sigma_mps, .. } = self.config.moving;
        let births = born(self.config.birth_intensity);
        let moving_births = born(birth_intensity).set_in_motion(velocity_sigma_mps);

        let Sight { still, moving, ln_eta, .. } = sight;
        let persisting = update::persisting(&still, &ln_eta, self.config.remembering, self.config.prune_weight);
        // Moving features may have disappeared.
        let moving_persisting = update::persisting(&moving, &ln_eta, Remembering::NOTHING, self.config.prune_weight);
        (
            update::after_scan(still.out_of_view, persisting, births, &self.config),
            update::after_scan(moving.out_of_view, moving_persisting, moving_births, &self.config),
        )
    }

    fn estimated(&self, state: &State) -> [f64; 3] {
        self.estimate(state).pose
    }
}
