//! Vehicle motion: the effect of a control on a pose, and the noise of the control.

use super::angle::wrap;
use super::draws::Draws;
use crate::Vehicle;

/// Greatest turn in a step for which v/ω of the arc is replaced by its series, rad.
const STRAIGHT_RAD: f64 = 1e-4;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlNoise {
    pub speed_sigma_mps: f64,
    /// Standard deviation of the second control: steering angle (rad) or turn rate (rad/s).
    pub second_sigma: f64,
    /// Relative standard deviation of the speed; adds in quadrature.
    pub speed_ratio: f64,
    /// Relative standard deviation of the second control; adds in quadrature.
    pub second_ratio: f64,
    /// τ, correlation time of an odometry error, s; 0: independent errors of the samples.
    pub interval_s: f64,
}

impl ControlNoise {
    /// Factor for the standard deviation of a sample: √(τ/dt) for τ > 0, so that a random walk with steps of `dt` has the
    /// variance of errors that are constant over τ each.
    fn scale(&self, dt: f64) -> f64 {
        if self.interval_s > 0.0 { (self.interval_s / dt).sqrt() } else { 1.0 }
    }
}

/// The transition π of the parent process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    pub vehicle: Vehicle,
    pub noise: ControlNoise,
}

impl Motion {
    /// Draws a sample of the transition (5.12): two normal numbers, first for the speed, then for the steering angle or turn
    /// rate; for a holonomic vehicle another one between them, for the speed to the left. Pose in m, m, rad; `dt` in s, above 0.
    pub fn sample(&self, pose: [f64; 3], control: &[f64; 3], dt: f64, draws: &mut dyn Draws) -> [f64; 3] {
        let scale = self.noise.scale(dt);
        let ControlNoise { speed_sigma_mps, second_sigma, speed_ratio, second_ratio, .. } = self.noise;
        let of_speed = speed_sigma_mps.hypot(speed_ratio * control[0].hypot(control[2])) * scale;
        let speed = control[0] + of_speed * draws.normal();
        let aside = self.vehicle == Vehicle::Holonomic;
        let left = if aside { control[2] + of_speed * draws.normal() } else { 0.0 };
        let second = control[1] + second_sigma.hypot(second_ratio * control[1]) * scale * draws.normal();
        if self.noise.interval_s > 0.0 {
            let errors = [speed - control[0], second - control[1], left - control[2]];
            return self.displaced(pose, control, errors, dt);
        }
        self.step(pose, &[speed, second, left], dt)
    }

    /// The pose with errors of a control to first order, because an error that lasts is one of the displacement. By central
    /// differences, whose error is far below any noise.
    fn displaced(&self, pose: [f64; 3], control: &[f64; 3], errors: [f64; 3], dt: f64) -> [f64; 3] {
        const STEP: f64 = 1e-5;
        let mut end = self.step(pose, control, dt);
        for (k, error) in errors.into_iter().enumerate() {
            let nudged = |by: f64| {
                let mut control = *control;
                control[k] += by;
                self.step(pose, &control, dt)
            };
            let (ahead, behind) = (nudged(STEP), nudged(-STEP));
            for row in 0..3 {
                let change = ahead[row] - behind[row];
                end[row] += error * if row == 2 { wrap(change) } else { change } / (2.0 * STEP);
            }
        }
        [end[0], end[1], wrap(end[2])]
    }

    /// Predicts a pose (m, m, rad) by a control without noise over `dt` seconds (5.25–5.27, with the sign of the x row
    /// corrected).
    pub fn step(&self, pose: [f64; 3], control: &[f64; 3], dt: f64) -> [f64; 3] {
        let [x, y, heading] = pose;
        let (sin, cos) = heading.sin_cos();
        let [speed, second, left] = *control;
        let (dx, dy, turn) = match self.vehicle {
            Vehicle::Ackermann { wheelbase_m, encoder_offset_m, sensor_forward_m: a, sensor_left_m: b } => {
                let centre_speed = speed / (1.0 - second.tan() * encoder_offset_m / wheelbase_m);
                let rate = centre_speed / wheelbase_m * second.tan();
                (
                    dt * (centre_speed * cos - rate * (a * sin + b * cos)),
                    dt * (centre_speed * sin + rate * (a * cos - b * sin)),
                    dt * rate,
                )
            }
            Vehicle::Unicycle => (speed * dt * cos, speed * dt * sin, second * dt),
            Vehicle::UnicycleArc => {
                let turn = second * dt;
                let (dx, dy) = if turn.abs() < STRAIGHT_RAD {
                    let middle = heading + turn / 2.0;
                    (speed * dt * middle.cos(), speed * dt * middle.sin())
                } else {
                    let radius = speed / second;
                    let end = heading + turn;
                    (radius * (end.sin() - sin), radius * (cos - end.cos()))
                };
                (dx, dy, turn)
            }
            Vehicle::Holonomic => {
                // The chord of the arc: its length is that of the arc times sin(a)/a, its direction the mean one.
                let half = second * dt / 2.0;
                let share = if half == 0.0 { 1.0 } else { half.sin() / half };
                let (s, c) = (heading + half).sin_cos();
                (dt * share * (speed * c - left * s), dt * share * (speed * s + left * c), second * dt)
            }
        };
        [x + dx, y + dy, wrap(heading + turn)]
    }
}
