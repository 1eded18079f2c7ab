//! Noise of the odometry.

use nalgebra::Vector3;
use scphd_log::log::{Log, Vehicle};

/// Standard deviations of speed and turn if a log does not state them: a constant (m/s; rad or rad/s), a relative part, and the
/// duration of an error, s. Round numbers, not chosen on any log.
const UNSTATED_CONSTANT: f64 = 0.02;
const UNSTATED_SHARE: f64 = 0.1;
const UNSTATED_LASTS_S: f64 = 0.5;

#[derive(Debug, Clone, Copy)]
pub(super) struct OdometryNoise {
    speed: Option<f64>,
    turn: Option<f64>,
    moves_aside: bool,
}

impl OdometryNoise {
    /// The noise that a log states for its vehicle.
    pub(super) fn of(log: &Log) -> Self {
        let nominal = &log.nominal;
        let turn = match log.vehicle {
            Vehicle::Ackermann { .. } => nominal.steering_sigma_rad,
            Vehicle::Unicycle | Vehicle::UnicycleArc | Vehicle::Holonomic => nominal.rate_sigma_radps,
        };
        Self { speed: nominal.speed_sigma_mps, turn, moves_aside: log.vehicle == Vehicle::Holonomic }
    }

    /// Variances of the controls over `dt_s`. For an error that lasts longer than the step, the variance is greater by the ratio
    /// of the two times, so that the accumulated variance is right.
    pub(super) fn variances(&self, control: [f64; 3], dt_s: f64) -> Vector3<f64> {
        let lasting = (UNSTATED_LASTS_S / dt_s).max(1.0);
        let unstated = |control: f64| lasting * (UNSTATED_CONSTANT + UNSTATED_SHARE * control.abs()).powi(2);
        let variance = |stated: Option<f64>, control| stated.map_or_else(|| unstated(control), |sigma| sigma * sigma);
        let [ahead, turn, left] = control;
        let of_speed = variance(self.speed, ahead.hypot(left));
        Vector3::new(of_speed, variance(self.turn, turn), if self.moves_aside { of_speed } else { 0.0 })
    }
}
