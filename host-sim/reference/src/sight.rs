//! The data common to the likelihood and the update: a pose, the map of its particle, and a scan.

use super::config::Config;
use super::field_of_view::FieldOfView;
use super::gaussian::{Component, Vector};
use super::log_domain::log_sum_exp;
use super::pre_update::{PreUpdate, pre_update};
use super::sensor::Sensor;

/// Data common to the likelihood and the update of a pose.
#[derive(Debug)]
pub(super) struct Sight<'a, S> {
    /// Pose: x m, y m, heading rad.
    pub(super) pose: [f64; 3],
    /// The scan, m and rad.
    pub(super) measurements: &'a [Vector],
    pub(super) sensor: &'a S,
    /// κ, 1/(m·rad).
    pub(super) clutter_intensity: f64,
    /// The static part of the map.
    pub(super) still: PreUpdate<2>,
    /// The moving part, at the time of the scan.
    pub(super) moving: PreUpdate<4>,
    /// ln(κ + w_b + w_m), the intensity of a measurement without features.
    pub(super) ln_unexplained: f64,
    /// ln η_z of every measurement (4.51, 5.19 with one birth space for each kind):
    /// η_z = κ + w_b + w_m + Σ p_D w N(z; ẑ, S) over the components of both kinds in view.
    pub(super) ln_eta: Vec<f64>,
}

impl<'a, S: Sensor> Sight<'a, S> {
    pub(super) fn new(
        pose: [f64; 3],
        map: &[Component],
        moving: &[Component<4>],
        measurements: &'a [Vector],
        sensor: &'a S,
        field_of_view: &FieldOfView,
        config: &Config,
    ) -> Self {
        let still = pre_update(map, pose, measurements, sensor, field_of_view);
        let moving = pre_update(moving, pose, measurements, sensor, field_of_view);
        let ln_unexplained = (config.clutter_intensity + config.birth_intensity + config.moving.birth_intensity).ln();
        let ln_eta = (0..measurements.len())
            .map(|z| {
                let mut terms = vec![ln_unexplained];
                terms.extend(still.in_view.iter().map(|j| j.ln_detection(z)));
                terms.extend(moving.in_view.iter().map(|j| j.ln_detection(z)));
                log_sum_exp(&terms)
            })
            .collect();
        let clutter_intensity = config.clutter_intensity;
        Self { pose, measurements, sensor, clutter_intensity, still, moving, ln_unexplained, ln_eta }
    }
}
