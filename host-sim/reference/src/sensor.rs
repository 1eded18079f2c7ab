//! Measurement models: h, its derivative, its inverse.

use super::algebra::transformed;
use super::angle::wrap;
use super::gaussian::{Matrix, Vector};

/// A measurement of a feature for a Kalman update: prediction, linearisation, noise.
pub trait Sensor {
    /// ẑ = h(m, x) and H = ∂h/∂m at feature position m (m) and pose x (m, m, rad); `None` if the feature cannot be observed.
    fn predicted(&self, mean: Vector, pose: [f64; 3]) -> Option<(Vector, Matrix)>;

    /// z ⊖ ẑ: the difference of two measurements.
    fn innovation(&self, measurement: Vector, predicted: Vector) -> Vector;

    /// R, the covariance of the measurement noise, of a measurement with this prediction.
    fn noise(&self, predicted: Vector) -> Matrix;
}

/// Range (m) and bearing (rad, 0 straight ahead, growing to the left).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeBearing {
    pub range_sigma_m: f64,
    /// Standard deviation of the range divided by the range; adds in quadrature.
    pub range_sigma_ratio: f64,
    pub bearing_sigma_rad: f64,
}

/// h(m, x), range in m and bearing in rad (5.28 with the heading subtracted, wrapped).
pub(super) fn range_bearing(position: Vector, pose: [f64; 3]) -> Vector {
    let (dx, dy) = (position[0] - pose[0], position[1] - pose[1]);
    [(dx * dx + dy * dy).sqrt(), wrap(dy.atan2(dx) - pose[2])]
}

impl Sensor for RangeBearing {
    fn predicted(&self, mean: Vector, pose: [f64; 3]) -> Option<(Vector, Matrix)> {
        let predicted = range_bearing(mean, pose);
        let range = predicted[0];
        if range.is_nan() || range <= 0.0 {
            return None;
        }
        let (dx, dy) = (mean[0] - pose[0], mean[1] - pose[1]);
        let jacobian = [[dx / range, dy / range], [-dy / (range * range), dx / (range * range)]];
        Some((predicted, jacobian))
    }

    fn innovation(&self, measurement: Vector, predicted: Vector) -> Vector {
        [measurement[0] - predicted[0], wrap(measurement[1] - predicted[1])]
    }

    fn noise(&self, predicted: Vector) -> Matrix {
        let range_variance = self.range_sigma_m.powi(2) + (self.range_sigma_ratio * predicted[0]).powi(2);
        [[range_variance, 0.0], [0.0, self.bearing_sigma_rad.powi(2)]]
    }
}

impl RangeBearing {
    /// The position of the feature of a measurement (m, rad) taken at a pose (m, m, rad): h⁻¹(z, x) in m, and its covariance R* =
    /// H* R H*ᵀ in m² (5.9, 5.10). `None` unless the range is above 0.
    pub fn inverse(&self, measurement: Vector, pose: [f64; 3]) -> Option<(Vector, Matrix)> {
        let range = measurement[0];
        if range.is_nan() || range <= 0.0 {
            return None;
        }
        let (sin, cos) = (pose[2] + measurement[1]).sin_cos();
        let position = [pose[0] + range * cos, pose[1] + range * sin];
        let jacobian = [[cos, -range * sin], [sin, range * cos]];
        Some((position, transformed(&jacobian, &self.noise(measurement))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SENSOR: RangeBearing = RangeBearing { range_sigma_m: 0.25, range_sigma_ratio: 0.0, bearing_sigma_rad: 0.01 };

    #[test]
    fn no_prediction_at_the_sensor_and_no_birth_without_range() {
        assert!(SENSOR.predicted([3.0, -2.0], [3.0, -2.0, 0.5]).is_none());
        for range in [0.0, -1.0, f64::NAN] {
            assert!(SENSOR.inverse([range, 0.2], [0.0; 3]).is_none());
        }
    }
}
