//! The scenario of section 5.3.2.

use super::car::{Lobes, drive};
use super::landmarks::Scatter;
use super::simulation::{Imperfection, Simulation};
use scphd_log::log::Log;
use std::f64::consts::PI;

/// A trefoil that crosses itself, 44 × 41 m: 200 m in 40 s.
const WAY: Lobes = Lobes { rows: 800, speed_mps: 5.0, turns: 2.0, lobes: 3.0, depth: 1.5 };

/// At least three standard deviations of the range from the path, and from each other.
const SCATTER: Scatter = Scatter { count: 60, seed: 3, from_path_m: (3.0, 12.0), apart_m: 3.0, from_tracks_m: 0.0 };

const IMPERFECTION: Imperfection = Imperfection {
    speed_sigma_mps: 2.0,
    steering_sigma_rad: 5.0 * PI / 180.0,
    range_sigma_m: 1.0,
    bearing_sigma_rad: 2.0 * PI / 180.0,
    clutter_per_scan: 5.0,
    ..Imperfection::OF_5_3_1
};

/// The vehicle of 5.3.1 drives a trefoil at 5 m/s among 60 static landmarks, with the noise of 5.3.2: 2 m/s and 5° in the
/// odometry, 1 m and 2° in the measurements, p_D 0.95, 5 false measurements a scan. 401 scans.
pub fn thesis_compare(seed: u64) -> Log {
    let controls = WAY.controls(1);
    let landmarks = SCATTER.around(&drive(&controls), &[]);
    Simulation { name: "thesis-compare", controls, landmarks, movers: Vec::new(), imperfection: IMPERFECTION }.log(seed)
}
