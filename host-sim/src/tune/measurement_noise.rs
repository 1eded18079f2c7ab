//! The noise of range and bearing, from what is left of the innovations of one scan once the pose has been fitted to them.

use super::pairs::Pair;
use nalgebra::{Matrix3, Vector3};
use scphd::{RangeBearing, Sensor};

/// Sums over all scans with two well known features or more.
///
/// The pose that suits prediction and scan best is fitted to the innovations. What remains is free of the pose's error, and of
/// variance R_kk (1 − h) for a coordinate whose leverage in the fit is h.
#[derive(Debug, Default)]
pub struct MeasurementNoise {
    /// Σ of squared residuals, m² and rad².
    squares: [f64; 2],
    /// Σ (1 − h).
    freedoms: [f64; 2],
    residuals: usize,
}

impl MeasurementNoise {
    /// Adds the residuals of a scan.
    pub fn scan(&mut self, pairs: &[Pair], pose_covariance: &[[f64; 3]; 3], sensor: &RangeBearing<f64>) {
        let known: Vec<&Pair> = pairs.iter().filter(|pair| pair.well_known).collect();
        if known.len() < 2 {
            return;
        }
        let Some(weights) = sensor.noise().to_matrix().try_inverse() else { return };
        let predicted = Matrix3::from_fn(|row, column| pose_covariance[row][column]);
        let Some(mut information) = predicted.try_inverse() else { return };
        let mut weighted = Vector3::zeros();
        for pair in &known {
            let gain = pair.by_pose.transpose() * weights;
            information += gain * pair.by_pose;
            weighted += gain * pair.innovation;
        }
        let Some(covariance) = information.try_inverse() else { return };
        let correction = covariance * weighted;
        for pair in &known {
            let residual = pair.innovation - pair.by_pose * correction;
            let fitted = pair.by_pose * covariance * pair.by_pose.transpose() * weights;
            for k in 0..2 {
                self.squares[k] += residual[k] * residual[k];
                self.freedoms[k] += 1.0 - fitted[(k, k)];
            }
            self.residuals += 1;
        }
    }

    /// Standard deviations of range (m) and bearing (rad).
    pub fn sigmas(&self) -> [Option<f64>; 2] {
        [0, 1].map(|k| (self.freedoms[k] > 1.0).then(|| (self.squares[k] / self.freedoms[k]).sqrt()))
    }

    /// Innovations that went in.
    pub fn residuals(&self) -> usize {
        self.residuals
    }
}
