//! The scenarios of section 5.3.1: static and moving landmarks, which the measurements do not distinguish.

use super::car::{Lobes, ROWS_PER_SECOND, drive};
use super::landmarks::Scatter;
use super::mover::Mover;
use super::simulation::{Imperfection, Simulation};
use scphd_log::log::Log;

/// A rounded triangle, 39 × 37 m: 120 m in 30 s.
const WAY: Lobes = Lobes { rows: 600, speed_mps: 4.0, turns: 1.0, lobes: 3.0, depth: 0.9 };
/// At least ten standard deviations of the range from the path; distances are those that a moving landmark covers in a second or
/// two.
const SCATTER: Scatter = Scatter { count: 45, seed: 2, from_path_m: (2.5, 12.0), apart_m: 3.0, from_tracks_m: 1.5 };

const fn mover(x_m: f64, y_m: f64, radius_m: f64, speed_mps: f64, phase_rad: f64) -> Mover {
    Mover { centre_m: [x_m, y_m], radius_m, speed_mps, phase_rad }
}

/// Each crosses the path, is in view for at least two fifths of the time, and stays some metres from the vehicle.
const MOVERS: [Mover; 6] = [
    mover(-11.0, 31.0, 12.0, -0.8, 0.4),
    mover(-8.0, 9.0, 24.0, 1.1, 0.6),
    mover(-9.0, 20.0, 11.0, 1.4, 1.0),
    mover(-9.0, 24.0, 19.0, 1.7, 4.9),
    mover(-3.0, 7.0, 12.0, 2.0, 6.2),
    mover(-6.0, 22.0, 18.0, 2.3, 0.5),
];

/// The vehicle of 5.3.1 drives a loop at 4 m/s among 45 static and 6 moving landmarks (0.8 to 2.3 m/s), with the noise, the
/// missed detections and the clutter of 5.3.1. 301 scans.
pub fn thesis_dynamic(seed: u64) -> Log {
    simulation("thesis-dynamic", 1).log(seed)
}

/// The loop of `thesis_dynamic` twice, with these errors of odometry and sensor.
pub(super) fn two_laps(name: &'static str, imperfection: Imperfection) -> Simulation {
    Simulation { imperfection, ..simulation(name, 2) }
}

fn simulation(name: &'static str, laps: usize) -> Simulation {
    let controls = WAY.controls(laps);
    let rows = 0..=controls.len();
    let tracks: Vec<[f64; 2]> = rows
        .step_by(4)
        .flat_map(|row| MOVERS.iter().map(move |mover| mover.at(row as f64 / ROWS_PER_SECOND)))
        .collect();
    // All laps are the same.
    let landmarks = SCATTER.around(&drive(&WAY.controls(1)), &tracks);
    Simulation { name, controls, landmarks, movers: MOVERS.to_vec(), imperfection: Imperfection::OF_5_3_1 }
}
