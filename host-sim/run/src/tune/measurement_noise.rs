//! Measurement noise, from the residuals of one scan after fitting the pose.

use super::pairs::Pair;
use nalgebra::{DMatrix, DVector};

/// Sums over all scans with at least two well known features.
///
/// The pose is fitted to prediction and innovations. The residuals do not contain the error of the pose, and have the variance
/// R_kk (1 − h) for a coordinate with the leverage h.
#[derive(Debug, Default)]
pub struct MeasurementNoise {
    /// Σ of squared residuals divided by R_kk, for every coordinate.
    squares: Vec<f64>,
    /// Σ (1 − h).
    freedoms: Vec<f64>,
    residuals: usize,
}

impl MeasurementNoise {
    /// Adds the residuals of a scan, with the covariance of the predicted pose.
    pub fn scan(&mut self, pairs: &[Pair], predicted: &DMatrix<f64>) {
        let known: Vec<&Pair> = pairs.iter().filter(|pair| pair.well_known).collect();
        if known.len() < 2 {
            return;
        }
        let Some(mut information) = predicted.clone().try_inverse() else { return };
        let mut weighted = DVector::zeros(predicted.nrows());
        for pair in &known {
            let Some(weights) = pair.noise.clone().try_inverse() else { return };
            let gain = pair.by_pose.transpose() * &weights;
            information += &gain * &pair.by_pose;
            weighted += gain * &pair.innovation;
        }
        let Some(covariance) = information.try_inverse() else { return };
        let correction = &covariance * weighted;
        for pair in &known {
            let noise = &pair.noise;
            self.squares.resize(noise.nrows(), 0.0);
            self.freedoms.resize(noise.nrows(), 0.0);
            let residual = &pair.innovation - &pair.by_pose * &correction;
            let fitted = &pair.by_pose * &covariance * pair.by_pose.transpose();
            for k in 0..noise.nrows() {
                self.squares[k] += residual[k] * residual[k] / noise[(k, k)];
                self.freedoms[k] += 1.0 - fitted[(k, k)] / noise[(k, k)];
            }
            self.residuals += 1;
        }
    }

    /// The factor by which the standard deviations of these coordinates are too small.
    pub fn ratio(&self, coordinates: &[usize]) -> Option<f64> {
        let sum = |of: &[f64]| coordinates.iter().filter_map(|&k| of.get(k)).sum::<f64>();
        let freedoms = sum(&self.freedoms);
        (freedoms > 1.0).then(|| (sum(&self.squares) / freedoms).sqrt())
    }

    pub fn residuals(&self) -> usize {
        self.residuals
    }
}
