//! Vehicles in the plane with a range-bearing sensor.

use super::dual::Dual;
use super::models::{Expected, Inverse, Models, Moved};
use crate::Vehicle;
use crate::angle::wrap;
use crate::{ControlNoise, FieldOfView, Motion, RangeBearing};
use nalgebra::{DMatrix, DVector};

/// Greatest turn in a step for which sin(a)/a is computed by the first two terms of its series, which are then exact in double
/// precision, rad.
const SERIES_RAD: f64 = 1e-4;

/// Number of standard deviations by which an occluding object must be nearer, and within which its direction must agree.
const HIDING_SIGMAS: f64 = 3.0;

/// Motion and sensor in the plane. A pose is x m, y m, heading rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Planar {
    pub motion: Motion,
    /// Mounting of the sensor relative to the pose: ahead m, to the left m, turned to the left rad.
    pub mounting: [f64; 3],
    pub sensor: RangeBearing,
    /// Field of view with the probability of detection.
    pub field_of_view: FieldOfView,
    /// κ, 1/(m·rad).
    pub clutter_intensity: f64,
}

/// The variables: pose, and three others, which are the control, or the two of a position or measurement.
type Number = Dual<6>;

/// Derivatives with respect to the pose, and to the three other variables.
fn derivatives<const R: usize>(of: &[Number; R]) -> (DMatrix<f64>, DMatrix<f64>) {
    let part = |from: usize, count: usize| DMatrix::from_fn(R, count, |row, column| of[row].by[from + column]);
    (part(0, 3), part(3, 3))
}

impl Planar {
    fn step(&self, [x, y, heading, speed, second, left]: [Number; 6], dt: f64) -> [Number; 3] {
        let ahead = |distance: Number, direction: Number| (distance * direction.cos(), distance * direction.sin());
        let ((dx, dy), turn) = match self.motion.vehicle {
            Vehicle::Ackermann { wheelbase_m, encoder_offset_m, sensor_forward_m, sensor_left_m } => {
                let tangent = second.tan() * (1.0 / wheelbase_m);
                let centre_speed = speed / (Number::constant(1.0) - tangent * encoder_offset_m);
                let rate = centre_speed * tangent;
                // A point ahead and to the left moves with the vehicle and around it.
                let (forward, left) = (centre_speed - rate * sensor_left_m, rate * sensor_forward_m);
                let (sine, cosine) = (heading.sin(), heading.cos());
                let velocity = (forward * cosine - left * sine, forward * sine + left * cosine);
                ((velocity.0 * dt, velocity.1 * dt), rate * dt)
            }
            Vehicle::Unicycle => (ahead(speed * dt, heading), second * dt),
            Vehicle::UnicycleArc => {
                // The chord of the arc.
                let (turn, half) = (second * dt, second * (dt / 2.0));
                let series = turn.value.abs() < SERIES_RAD;
                let share = if series { Number::constant(1.0) - half * half * (1.0 / 6.0) } else { half.sinc() };
                (ahead(speed * dt * share, heading + half), turn)
            }
            Vehicle::Holonomic => {
                let (turn, half) = (second * dt, second * (dt / 2.0));
                let series = turn.value.abs() < SERIES_RAD;
                let share = if series { Number::constant(1.0) - half * half * (1.0 / 6.0) } else { half.sinc() };
                let along = heading + half;
                let (east, north) = (along.cos() * share * dt, along.sin() * share * dt);
                ((speed * east - left * north, speed * north + left * east), turn)
            }
        };
        [x + dx, y + dy, heading + turn]
    }

    /// The pose of the sensor.
    fn seat(&self, [x, y, heading]: [Number; 3]) -> [Number; 3] {
        let [forward, left, yaw] = self.mounting;
        let (sine, cosine) = (heading.sin(), heading.cos());
        [x + cosine * forward - sine * left, y + sine * forward + cosine * left, heading + Number::constant(yaw)]
    }
}

impl Models for Planar {
    /// Speed in m/s, then steering angle in rad or turn rate in rad/s, then speed to the left in m/s.
    type Control = [f64; 3];

    const POSE: usize = 3;
    const FEATURE: usize = 2;

    fn moved(&self, pose: &[f64], control: &[f64; 3], dt: f64) -> Moved {
        let end = self.step(Dual::variables([pose[0], pose[1], pose[2], control[0], control[1], control[2]]), dt);
        let (transition, by_control) = derivatives(&end);
        let ControlNoise { speed_sigma_mps, second_sigma, speed_ratio, second_ratio, interval_s } = self.motion.noise;
        // Errors that last are modelled as a random walk that does not depend on the step.
        let lasting = if interval_s > 0.0 { interval_s / dt } else { 1.0 };
        let variance = |sigma: f64, ratio: f64, control: f64| lasting * (sigma.powi(2) + (ratio * control).powi(2));
        let of_speed = variance(speed_sigma_mps, speed_ratio, control[0].hypot(control[2]));
        let variances = DVector::from_vec(vec![
            of_speed,
            variance(second_sigma, second_ratio, control[1]),
            if self.motion.vehicle == Vehicle::Holonomic { of_speed } else { 0.0 },
        ]);
        let noise = &by_control * DMatrix::from_diagonal(&variances) * by_control.transpose();
        Moved { pose: end.map(|number| number.value).to_vec(), transition, noise }
    }

    fn expected(&self, pose: &[f64], feature: &[f64]) -> Option<Expected> {
        let [x, y, heading, east, north, _] = Dual::variables([pose[0], pose[1], pose[2], feature[0], feature[1], 0.0]);
        let [x, y, heading] = self.seat([x, y, heading]);
        let (dx, dy) = (east - x, north - y);
        let range = (dx * dx + dy * dy).sqrt();
        if range.value.is_nan() || range.value <= 0.0 {
            return None;
        }
        let bearing = dy.atan2(dx) - heading;
        let (by_pose, by_feature) = derivatives(&[range, bearing]);
        let by_feature = by_feature.columns(0, 2).into_owned();
        let seat = [x, y, heading].map(|number| number.value);
        Some(Expected {
            measurement: DVector::from_vec(vec![range.value, wrap(bearing.value)]),
            by_pose,
            by_feature,
            detection: self.field_of_view.detection_probability([feature[0], feature[1]], seat),
        })
    }

    fn inverse(&self, pose: &[f64], measurement: &[f64]) -> Option<Inverse> {
        if measurement[0].is_nan() || measurement[0] <= 0.0 {
            return None;
        }
        let [x, y, heading, range, bearing, _] =
            Dual::variables([pose[0], pose[1], pose[2], measurement[0], measurement[1], 0.0]);
        let [x, y, heading] = self.seat([x, y, heading]);
        let direction = heading + bearing;
        let feature = [x + range * direction.cos(), y + range * direction.sin()];
        let (_, by_measurement) = derivatives(&feature);
        let by_measurement = by_measurement.columns(0, 2).into_owned();
        Some(Inverse { feature: DVector::from_vec(feature.map(|number| number.value).to_vec()), by_measurement })
    }

    fn innovation(&self, measurement: &[f64], expected: &DVector<f64>) -> DVector<f64> {
        DVector::from_vec(vec![measurement[0] - expected[0], wrap(measurement[1] - expected[1])])
    }

    fn noise(&self) -> DMatrix<f64> {
        let RangeBearing { range_sigma_m, bearing_sigma_rad, .. } = self.sensor;
        DMatrix::from_diagonal(&DVector::from_vec(vec![range_sigma_m.powi(2), bearing_sigma_rad.powi(2)]))
    }

    fn noise_at(&self, expected: &[f64]) -> DMatrix<f64> {
        let mut noise = self.noise();
        noise[(0, 0)] += (self.sensor.range_sigma_ratio * expected[0]).powi(2);
        noise
    }

    fn occludes(&self, measurement: &[f64], expected: &DVector<f64>) -> bool {
        let off = self.innovation(measurement, expected);
        let RangeBearing { range_sigma_m, bearing_sigma_rad, .. } = self.sensor;
        -off[0] > HIDING_SIGMAS * range_sigma_m && off[1].abs() < HIDING_SIGMAS * bearing_sigma_rad
    }

    fn clutter_intensity(&self) -> f64 {
        self.clutter_intensity
    }
}
