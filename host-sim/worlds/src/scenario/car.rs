//! The vehicle of section 5.3.1 and its trajectories.

use scphd_log::log::Vehicle;
use std::f64::consts::PI;

/// Geometry of 5.3.1, m.
const WHEELBASE_M: f64 = 1.415;
const ENCODER_OFFSET_M: f64 = 0.380;
const SENSOR_FORWARD_M: f64 = 1.890;
const SENSOR_LEFT_M: f64 = 0.250;

/// Odometry rows a second (5.3.1).
pub(super) const ROWS_PER_SECOND: f64 = 20.0;

/// An Ackermann vehicle with a 1.890, b 0.250, H 0.380, L 1.415 m.
pub(super) const CAR: Vehicle = Vehicle::Ackermann {
    wheelbase_m: WHEELBASE_M,
    encoder_offset_m: ENCODER_OFFSET_M,
    sensor_forward_m: SENSOR_FORWARD_M,
    sensor_left_m: SENSOR_LEFT_M,
};

/// Encoder speed (m/s) and steering angle (rad) for which the centre of the rear axle moves at `speed_mps` with a curvature
/// (1/m).
pub(super) fn control(speed_mps: f64, curvature: f64) -> [f64; 2] {
    // tan α = L κ; the encoder is H left of the centre of the axle.
    let slope = WHEELBASE_M * curvature;
    [speed_mps * (1.0 - slope * ENCODER_OFFSET_M / WHEELBASE_M), libm::atan(slope)]
}

/// Poses (x m, y m, heading rad) of the sensor at the start of every row and after the last row.
pub(super) fn drive(controls: &[[f64; 2]]) -> Vec<[f64; 3]> {
    let mut path = vec![[0.0; 3]];
    let mut pose = path[0];
    for &[speed, steering] in controls {
        pose = CAR.step(pose, [speed, steering, 0.0], 1.0 / ROWS_PER_SECOND);
        path.push(pose);
    }
    path
}

/// A closed trajectory of `rows` rows whose curvature is a constant and one harmonic.
///
/// A shape of n-fold symmetry: `turns` turns in `lobes` equal parts. If `lobes` divides `rows` and does not divide `turns`, the
/// parts cancel also when summed row by row, so that the trajectory is closed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lobes {
    pub rows: usize,
    pub speed_mps: f64,
    pub turns: f64,
    pub lobes: f64,
    /// Amplitude of the harmonic in turns: added in the middle of a part and subtracted at its ends; negative for the opposite.
    pub depth: f64,
}

impl Lobes {
    /// The control of row `row`.
    pub fn control(&self, row: usize) -> [f64; 2] {
        let length_m = self.rows as f64 * self.speed_mps / ROWS_PER_SECOND;
        let place = (row % self.rows) as f64 / self.rows as f64;
        let turns = self.turns - self.depth * libm::cos(2.0 * PI * self.lobes * place);
        control(self.speed_mps, 2.0 * PI * turns / length_m)
    }

    /// The controls of `laps` laps.
    pub fn controls(&self, laps: usize) -> Vec<[f64; 2]> {
        (0..laps * self.rows).map(|row| self.control(row)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trajectory_of_lobes_is_closed_and_has_its_length() {
        for (turns, lobes, depth) in [(1.0, 3.0, 0.9), (2.0, 3.0, 1.5), (1.0, 2.0, 0.5)] {
            let way = Lobes { rows: 600, speed_mps: 4.0, turns, lobes, depth };
            let path = drive(&way.controls(1));
            let end = path[600];
            assert!(end[0].hypot(end[1]) < 1e-9 && end[2].abs() < 1e-9, "{end:?}");
            // The centre of the axle moves exactly by speed times time; the chords of the sensor's trajectory are close to that.
            let chords: f64 = path.windows(2).map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1])).sum();
            assert!((chords / 120.0 - 1.0).abs() < 0.05, "{chords}");
        }
    }
}
