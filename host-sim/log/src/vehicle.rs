//! Motion of the vehicles in f64, for dead reckoning and simulation.
//!
//! Sines and cosines are those of `libm`, so that a simulated log is the same on every machine.

use crate::angle::wrap;
use crate::events::{Event, events};
use crate::log::{Log, Vehicle};
use libm::{cos, sin, tan};
use scphd::errors::Implausible;
use scphd::settings::Plausible;

/// Greatest speed of a vehicle that maps landmarks, m/s: 360 km/h.
pub const FASTEST_MPS: f64 = 100.0;

/// Greatest turn (rad) in a step for which the exact arc is replaced by its chord; see `docs/recursion.md`.
const STRAIGHT_RAD: f64 = 1e-4;

impl Vehicle {
    /// The pose after `dt_s` seconds of `control` from `pose` (x m, y m, heading rad), without noise.
    ///
    /// `control` is encoder speed (m/s) and steering angle (rad) for the Ackermann vehicle (5.25–5.27, with the sign of the x row
    /// corrected), speed (m/s) and turn rate (rad/s) for the unicycles, and for a holonomic vehicle also the speed to the left
    /// (m/s). The returned heading is in (−π, π].
    pub fn step(&self, pose: [f64; 3], control: [f64; 3], dt_s: f64) -> [f64; 3] {
        let [x, y, heading] = pose;
        match *self {
            Self::Ackermann { wheelbase_m, encoder_offset_m, sensor_forward_m: a, sensor_left_m: b } => {
                let [encoder_speed, steering, _] = control;
                let slope = tan(steering);
                let speed = encoder_speed / (1.0 - slope * encoder_offset_m / wheelbase_m);
                let rate = speed / wheelbase_m * slope;
                let (s, c) = (sin(heading), cos(heading));
                [
                    x + dt_s * (speed * c - rate * (a * s + b * c)),
                    y + dt_s * (speed * s + rate * (a * c - b * s)),
                    wrap(heading + dt_s * rate),
                ]
            }
            Self::Unicycle => {
                let [speed, rate, _] = control;
                [x + dt_s * speed * cos(heading), y + dt_s * speed * sin(heading), wrap(heading + dt_s * rate)]
            }
            Self::UnicycleArc => {
                let [speed, rate, _] = control;
                let turn = rate * dt_s;
                let end = heading + turn;
                let (dx, dy) = if turn.abs() < STRAIGHT_RAD {
                    let middle = heading + 0.5 * turn;
                    (speed * dt_s * cos(middle), speed * dt_s * sin(middle))
                } else {
                    let radius = speed / rate;
                    (radius * (sin(end) - sin(heading)), radius * (cos(heading) - cos(end)))
                };
                [x + dx, y + dy, wrap(end)]
            }
            Self::Holonomic => {
                let [ahead, rate, left] = control;
                // The motion to the left is an arc too, that of a vehicle rotated by a right angle.
                let arc = |speed, heading| Self::UnicycleArc.step([0.0, 0.0, heading], [speed, rate, 0.0], dt_s);
                let ([dx, dy, _], [to_left, back, _]) = (arc(ahead, heading), arc(left, heading));
                [x + dx - back, y + dy + to_left, wrap(heading + rate * dt_s)]
            }
        }
    }
}

impl Vehicle {
    /// The implausible quantity in a row of odometry, by the default limits of all filters; `None` if there is none.
    pub fn implausible(&self, control: [f64; 3], dt_s: f64) -> Option<Implausible> {
        let limits = Plausible::<f64>::default();
        let [speed, turn] = match *self {
            Self::Ackermann { wheelbase_m, encoder_offset_m, .. } => {
                let [encoder_speed, steering, _] = control;
                let slope = tan(steering);
                let speed = encoder_speed / (1.0 - slope * encoder_offset_m / wheelbase_m);
                [speed, speed / wheelbase_m * slope]
            }
            Self::Unicycle | Self::UnicycleArc => [control[0], control[1]],
            Self::Holonomic => [libm::hypot(control[0], control[2]), control[1]],
        };
        // Written so that NaN is implausible.
        if !(dt_s <= limits.step_max_s) {
            Some(Implausible::Step)
        } else if !(speed.abs() <= limits.speed_max_mps) {
            Some(Implausible::Speed)
        } else if !(turn.abs() <= limits.turn_rate_max_radps) {
            Some(Implausible::TurnRate)
        } else {
            None
        }
    }
}

/// The pose (x m, y m, heading rad) at each scan of `log` by dead reckoning.
pub fn dead_reckoning(log: &Log) -> Vec<[f64; 3]> {
    let mut pose = log.initial_pose;
    let mut poses = Vec::with_capacity(log.scans.len());
    for event in events(log) {
        match event {
            Event::Predict { control, dt_s, .. } => pose = log.vehicle.step(pose, control, dt_s),
            Event::Scan { .. } => poses.push(pose),
            Event::Fix { .. } => {}
        }
    }
    poses
}

/// The trajectory by dead reckoning, at any time.
#[derive(Debug)]
pub struct Way<'a> {
    log: &'a Log,
    /// The pose at every row.
    poses: Vec<[f64; 3]>,
}

impl<'a> Way<'a> {
    pub fn of(log: &'a Log) -> Self {
        let mut poses = Vec::with_capacity(log.odometry.len());
        let mut pose = log.initial_pose;
        for (place, row) in log.odometry.iter().enumerate() {
            if let Some(before) = place.checked_sub(1).map(|before| &log.odometry[before]) {
                pose = log.vehicle.step(pose, before.control, row.t_s - before.t_s);
            }
            poses.push(pose);
        }
        Self { log, poses }
    }

    /// The pose at a time, s. The vehicle is at rest before the first row, and continues by the last row after it.
    pub fn at(&self, t_s: f64) -> [f64; 3] {
        let rows = self.log.odometry.partition_point(|row| row.t_s <= t_s);
        let Some(place) = rows.checked_sub(1) else { return self.log.initial_pose };
        let row = &self.log.odometry[place];
        self.log.vehicle.step(self.poses[place], row.control, t_s - row.t_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    const CAR: Vehicle =
        Vehicle::Ackermann { wheelbase_m: 2.83, encoder_offset_m: 0.76, sensor_forward_m: 3.78, sensor_left_m: 0.5 };

    fn close(a: [f64; 3], b: [f64; 3], tolerance: f64) {
        for k in 0..3 {
            assert!((a[k] - b[k]).abs() < tolerance, "{a:?} is not {b:?}");
        }
    }

    #[test]
    fn all_vehicles_drive_straight() {
        for vehicle in [CAR, Vehicle::Unicycle, Vehicle::UnicycleArc, Vehicle::Holonomic] {
            let pose = vehicle.step([1.0, 2.0, FRAC_PI_2], [3.0, 0.0, 0.0], 0.5);
            close(pose, [1.0, 3.5, FRAC_PI_2], 1e-15);
        }
    }

    #[test]
    fn the_exact_arc_closes_its_circle_in_one_and_in_many_steps() {
        let start = [1.0, 2.0, 0.3];
        close(Vehicle::UnicycleArc.step(start, [2.0, 0.5, 0.0], 4.0 * PI), start, 1e-14);
        let half = Vehicle::UnicycleArc.step([0.0; 3], [2.0, 0.5, 0.0], 2.0 * PI);
        close(half, [0.0, 8.0, PI], 1e-14);
        let mut pose = start;
        for _ in 0..1000 {
            pose = Vehicle::UnicycleArc.step(pose, [2.0, 0.5, 0.0], 4.0 * PI / 1000.0);
        }
        close(pose, start, 1e-11);
    }

    #[test]
    fn chord_and_arc_agree_at_the_limit() {
        let at = |turn: f64| Vehicle::UnicycleArc.step([0.0, 0.0, 1.0], [10.0, turn, 0.0], 1.0);
        close(at(0.999_999 * STRAIGHT_RAD), at(1.000_001 * STRAIGHT_RAD), 1e-8);
        // The chord is longer than that of the arc by the relative difference (ω dt)²/24.
        let turn = 0.999 * STRAIGHT_RAD;
        let exact = 10.0 * 2.0 / turn * (0.5 * turn).sin();
        let [x, y, _] = at(turn);
        assert!((x.hypot(y) - exact).abs() < 10.0 * turn * turn / 23.0);
    }

    #[test]
    fn the_ackermann_sensor_moves_as_a_point_of_the_rigid_body() {
        let (steering, dt) = (0.2_f64, 1e-5);
        let (encoder_speed, heading) = (2.0, 0.7_f64);
        // At the encoder, H left of the centre of the axle, the speed is v_c − θ̇ H.
        let speed = encoder_speed / (1.0 - steering.tan() * 0.76 / 2.83);
        let rate = speed * steering.tan() / 2.83;
        assert!((speed - rate * 0.76 - encoder_speed).abs() < 1e-12);
        let sensor =
            |x: f64, y: f64, h: f64| [x + 3.78 * h.cos() - 0.5 * h.sin(), y + 3.78 * h.sin() + 0.5 * h.cos(), h];
        let axle = Vehicle::UnicycleArc.step([0.0, 0.0, heading], [speed, rate, 0.0], dt);
        let moved = CAR.step(sensor(0.0, 0.0, heading), [encoder_speed, steering, 0.0], dt);
        // The Euler step differs from the exact motion by O(dt²).
        close(moved, sensor(axle[0], axle[1], axle[2]), 5.0 * dt * dt);
    }

    /// Compared with small straight steps.
    #[test]
    fn a_holonomic_vehicle_goes_any_way_while_it_turns() {
        let (control, steps) = ([1.5, 0.8, -0.7], 20_000);
        let whole = Vehicle::Holonomic.step([1.0, 2.0, 0.3], control, 2.0);
        let (mut x, mut y, mut heading, dt) = (1.0, 2.0, 0.3_f64, 2.0 / f64::from(steps));
        for _ in 0..steps {
            let (s, c) = (heading + 0.5 * dt * control[1]).sin_cos();
            x += dt * (control[0] * c - control[2] * s);
            y += dt * (control[0] * s + control[2] * c);
            heading += dt * control[1];
        }
        close(whole, [x, y, heading], 1e-8);
    }

    #[test]
    fn the_heading_wraps() {
        let pose = Vehicle::Unicycle.step([0.0, 0.0, 3.0], [0.0, 1.0, 0.0], 1.0);
        close(pose, [0.0, 0.0, 4.0 - 2.0 * PI], 1e-15);
    }
}
