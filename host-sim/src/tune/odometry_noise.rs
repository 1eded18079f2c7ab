//! The noise of the odometry, from how far the scans move the pose.

use crate::angle::wrap;
use crate::log::Vehicle;
use crate::settings::VehicleSettings;

/// Sums over all scans: in a filter whose noise is right, what the scans correct has the variance that the motion between
/// them has added.
#[derive(Debug, Default)]
pub struct OdometryNoise {
    /// Σ of the variances that the speed's noise has added along the vehicle, m².
    along: f64,
    /// Σ of the variances that the speed's noise and the second control's have added to the heading, rad².
    turned: [f64; 2],
    /// Σ of the squared corrections along the vehicle (m²) and of its heading (rad²).
    corrected: [f64; 2],
    corrections: usize,
}

impl OdometryNoise {
    /// Adds a prediction.
    pub fn predict(&mut self, vehicle: &Vehicle, noise: &VehicleSettings, control: [f64; 2], dt_s: f64) {
        let [speed, turn] = control;
        // An error that lasts for a while adds up over it.
        let lasting = dt_s * dt_s.max(noise.noise_interval_s);
        let variance = |constant: f64, ratio: f64, value: f64| constant.powi(2) + (ratio * value).powi(2);
        let of_speed = variance(noise.speed_sigma_mps, noise.speed_sigma_ratio, speed) * lasting;
        let of_turn = variance(noise.turn_sigma, noise.turn_sigma_ratio, turn) * lasting;
        // ∂ heading rate / ∂ control.
        let [by_speed, by_turn] = match *vehicle {
            Vehicle::Ackermann { wheelbase_m, .. } => {
                [turn.tan() / wheelbase_m, speed / (wheelbase_m * turn.cos().powi(2))]
            }
            Vehicle::Unicycle | Vehicle::UnicycleArc => [0.0, 1.0],
        };
        self.along += of_speed;
        self.turned[0] += of_speed * by_speed * by_speed;
        self.turned[1] += of_turn * by_turn * by_turn;
    }

    /// Adds the correction of a scan.
    pub fn correct(&mut self, before: [f64; 3], after: [f64; 3]) {
        let (sin, cos) = before[2].sin_cos();
        let along = cos * (after[0] - before[0]) + sin * (after[1] - before[1]);
        self.corrected[0] += along * along;
        self.corrected[1] += wrap(after[2] - before[2]).powi(2);
        self.corrections += 1;
    }

    /// Factors by which the standard deviations of speed and second control fall short.
    pub fn ratios(&self) -> [Option<f64>; 2] {
        let speed = (self.along > 0.0).then(|| self.corrected[0] / self.along);
        let [by_speed, by_turn] = self.turned;
        let rest = (self.corrected[1] - speed.unwrap_or(0.0) * by_speed).max(0.0);
        [speed, (by_turn > 0.0).then(|| rest / by_turn)].map(|squared| squared.map(f64::sqrt))
    }

    /// Scans that went in.
    pub fn corrections(&self) -> usize {
        self.corrections
    }
}
