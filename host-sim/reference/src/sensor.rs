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
    /// Standard deviation of the range, m.
    pub range_sigma_m: f64,
    /// Standard deviation of the range divided by the range; adds in quadrature.
    pub range_sigma_ratio: f64,
    /// Standard deviation of the bearing, rad.
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
    use std::f64::consts::PI;

    const SENSOR: RangeBearing = RangeBearing { range_sigma_m: 0.25, range_sigma_ratio: 0.0, bearing_sigma_rad: 0.01 };
    const STEP: f64 = 1e-6;

    /// Central differences of `function` along each coordinate, as columns.
    fn central_differences(function: impl Fn(Vector) -> Vector, at: Vector) -> Matrix {
        let mut jacobian = [[0.0; 2]; 2];
        for column in 0..2 {
            let (mut ahead, mut behind) = (at, at);
            ahead[column] += STEP;
            behind[column] -= STEP;
            let (ahead, behind) = (function(ahead), function(behind));
            for row in 0..2 {
                jacobian[row][column] = (ahead[row] - behind[row]) / (2.0 * STEP);
            }
        }
        jacobian
    }

    fn close(a: &Matrix, b: &Matrix, bound: f64) {
        for row in 0..2 {
            for column in 0..2 {
                let difference = (a[row][column] - b[row][column]).abs();
                assert!(difference < bound, "{a:?} against {b:?}");
            }
        }
    }

    fn grid() -> impl Iterator<Item = (Vector, [f64; 3])> {
        // Irregular steps of ranges and angles, so that no bearing is at ±π.
        (1..8).flat_map(|i| {
            (-7..8).flat_map(move |j| {
                (-3..4).map(move |k| {
                    let measurement = [1.7 * f64::from(i), 0.41 * f64::from(j)];
                    (measurement, [3.0, -2.0, 0.83 * f64::from(k)])
                })
            })
        })
    }

    #[test]
    fn jacobian_of_h() {
        for (measurement, pose) in grid() {
            let (position, _) = SENSOR.inverse(measurement, pose).expect("range above 0");
            let (_, jacobian) = SENSOR.predicted(position, pose).expect("in front");
            let numeric = central_differences(|m| range_bearing(m, pose), position);
            close(&jacobian, &numeric, 1e-8);
        }
    }

    #[test]
    fn covariance_of_the_inverse() {
        for (measurement, pose) in grid() {
            let position = |z: Vector| SENSOR.inverse(z, pose).expect("range above 0").0;
            let (_, covariance) = SENSOR.inverse(measurement, pose).expect("range above 0");
            let jacobian = central_differences(position, measurement);
            close(&covariance, &transformed(&jacobian, &SENSOR.noise(measurement)), 1e-9);
        }
    }

    #[test]
    fn the_inverse_inverts_h() {
        for (measurement, pose) in grid() {
            let (position, _) = SENSOR.inverse(measurement, pose).expect("range above 0");
            let (back, _) = SENSOR.predicted(position, pose).expect("in front");
            let difference = SENSOR.innovation(measurement, back);
            assert!(difference[0].abs() < 1e-13 && difference[1].abs() < 1e-13);
        }
    }

    #[test]
    fn noise_grows_with_the_predicted_range() {
        let sensor = RangeBearing { range_sigma_ratio: 0.05, ..SENSOR };
        close(&sensor.noise([20.0, 0.3]), &[[0.0625 + 1.0, 0.0], [0.0, 1e-4]], 1e-15);
    }

    #[test]
    fn the_innovation_is_wrapped() {
        let difference = SENSOR.innovation([5.0, PI - 0.1], [5.0, -PI + 0.1]);
        assert!((difference[1] + 0.2).abs() < 1e-14);
    }

    #[test]
    fn no_prediction_at_the_sensor_and_no_birth_without_range() {
        assert!(SENSOR.predicted([3.0, -2.0], [3.0, -2.0, 0.5]).is_none());
        for range in [0.0, -1.0, f64::NAN] {
            assert!(SENSOR.inverse([range, 0.2], [0.0; 3]).is_none());
        }
    }
}
