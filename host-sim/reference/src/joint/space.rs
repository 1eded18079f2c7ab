//! An underwater vehicle with a stereo camera.

use super::dual::Dual;
use super::models::{Expected, Inverse, Models, Moved};
use crate::algebra::{apply, product, transformed};
use crate::space::{Control, Pose, Space, about, rotation};
use nalgebra::{DMatrix, DVector};

/// Least depth in front of either camera, m.
const LEAST_DEPTH_M: f64 = 1e-3;

/// The variables: position and yaw, and the position of a feature.
type Number = Dual<7>;

/// A pose is x, y, z m, yaw rad, yaw rate rad/s; roll and pitch, rad, are given.
fn pose_of(pose: &[f64]) -> Pose {
    let [x, y, z, yaw, yaw_rate, roll, pitch] = std::array::from_fn(|k| pose[k]);
    Pose { position: [x, y, z], yaw, yaw_rate, roll, pitch }
}

/// Rotates about the vertical.
fn turned<const N: usize>([x, y, z]: [Dual<N>; 3], by: Dual<N>) -> [Dual<N>; 3] {
    let (sine, cosine) = (by.sin(), by.cos());
    [x * cosine - y * sine, x * sine + y * cosine, z]
}

fn constants<const N: usize>(values: [f64; 3]) -> [Dual<N>; 3] {
    values.map(Dual::constant)
}

fn full<const R: usize, const C: usize>(matrix: &[[f64; C]; R]) -> DMatrix<f64> {
    DMatrix::from_fn(R, C, |row, column| matrix[row][column])
}

impl Space {
    /// The axes of a vehicle with yaw 0, in the map.
    fn tilted(pose: &[f64]) -> [[f64; 3]; 3] {
        product(&about(1, pose[6]), &about(0, pose[5]))
    }
}

impl Models for Space {
    type Control = Control;

    const POSE: usize = 5;
    const FEATURE: usize = 3;

    fn moved(&self, pose: &[f64], control: &Control, dt: f64) -> Moved {
        let [x, y, z, yaw, rate] = Dual::<5>::variables(std::array::from_fn(|k| pose[k]));
        let tilt = Self::tilted(pose);
        let step = turned(constants(apply(&tilt, control.velocity).map(|v| v * dt)), yaw);
        let mut place = [x + step[0], y + step[1], z + step[2]];
        // The covariance by the error of the velocity, for a vehicle with yaw 0.
        let raise = (self.velocity_interval_s / dt).max(1.0);
        let ahead = transformed(&tilt, &control.covariance).map(|row| row.map(|c| c * dt * dt * raise));
        let mut spread = transformed(&about(2, pose[3]), &ahead);
        if let Some([reading, sigma]) = control.z {
            // The position conditioned on a measured third coordinate.
            let variance = ahead[2][2] + sigma * sigma;
            let gain = turned(constants(ahead.map(|row| row[2] / variance)), yaw);
            let off = Dual::constant(reading) - place[2];
            place = std::array::from_fn(|k| place[k] + gain[k] * off);
            let with_z = spread[2];
            for (row, gain) in spread.iter_mut().zip(gain) {
                (0..3).for_each(|column| row[column] -= gain.value * with_z[column]);
            }
        }
        let variance = self.yaw_acceleration_sigma.powi(2);
        let (acceleration, left, share) = match control.yaw_rate {
            Some([reading, sigma]) => {
                let gain = variance * dt * dt / (variance * dt * dt + sigma * sigma);
                ((Dual::constant(reading) - rate) * (gain / dt), variance * (1.0 - gain), 1.0)
            }
            None => (Dual::constant(0.0), variance, 0.5),
        };
        let [x, y, z] = place;
        let end = [x, y, z, yaw + rate * dt + acceleration * (share * dt * dt), rate + acceleration * dt];
        let mut noise = DMatrix::zeros(5, 5);
        noise.view_mut((0, 0), (3, 3)).copy_from(&full(&spread));
        // A random acceleration changes the yaw and the yaw rate.
        let by_draw = DVector::from_vec(vec![0.0, 0.0, 0.0, share * dt * dt, dt]);
        noise += left * &by_draw * by_draw.transpose();
        let transition = DMatrix::from_fn(5, 5, |row, column| end[row].by[column]);
        Moved { pose: end.iter().map(|number| number.value).chain(control.tilt).collect(), transition, noise }
    }

    fn expected(&self, pose: &[f64], feature: &[f64]) -> Option<Expected> {
        let [x, y, z, yaw, mx, my, mz] =
            Number::variables([pose[0], pose[1], pose[2], pose[3], feature[0], feature[1], feature[2]]);
        let ahead = turned([mx - x, my - y, mz - z], -yaw);
        let tilt = Self::tilted(pose);
        let sum = |factors: [f64; 3], of: &[Number; 3]| of[0] * factors[0] + of[1] * factors[1] + of[2] * factors[2];
        let point: [Number; 3] = std::array::from_fn(|k| sum([tilt[0][k], tilt[1][k], tilt[2][k]], &ahead));
        let mut pixels = Vec::with_capacity(4);
        let mut depths = Vec::with_capacity(2);
        for camera in &self.cameras {
            let [x, y, depth] = camera.map(|[a, b, c, shift]| sum([a, b, c], &point) + Number::constant(shift));
            if depth.value.is_nan() || depth.value <= LEAST_DEPTH_M {
                return None;
            }
            pixels.extend([x / depth, y / depth]);
            depths.push(depth.value);
        }
        let values: [f64; 4] = std::array::from_fn(|k| pixels[k].value);
        Some(Expected {
            measurement: DVector::from_column_slice(&values),
            // The pixels do not depend on the yaw rate.
            by_pose: DMatrix::from_fn(4, 5, |row, column| if column < 4 { pixels[row].by[column] } else { 0.0 }),
            by_feature: DMatrix::from_fn(4, 3, |row, column| pixels[row].by[4 + column]),
            detection: self.detection_probability(values, depths[0]),
        })
    }

    fn inverse(&self, pose: &[f64], measurement: &[f64]) -> Option<Inverse> {
        let (point, by_measurement) = self.triangulated(std::array::from_fn(|k| measurement[k]))?;
        let turned = rotation(&pose_of(pose));
        let place = apply(&turned, point);
        Some(Inverse {
            feature: DVector::from_fn(3, |k, _| pose[k] + place[k]),
            by_measurement: full(&product(&turned, &by_measurement)),
        })
    }

    fn innovation(&self, measurement: &[f64], expected: &DVector<f64>) -> DVector<f64> {
        DVector::from_column_slice(measurement) - expected
    }

    fn noise(&self) -> DMatrix<f64> {
        full(&self.noise)
    }

    /// Occlusion is not modelled for cameras.
    fn occludes(&self, _measurement: &[f64], _expected: &DVector<f64>) -> bool {
        false
    }

    fn clutter_intensity(&self) -> f64 {
        self.config.clutter_intensity
    }
}
