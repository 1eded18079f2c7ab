//! The scenario with static landmarks only.

use super::car::{control as car_control, drive};
use super::landmarks::Scatter;
use super::simulation::{Imperfection, Simulation};
use scphd_log::log::{Fix, FixNoise, Log, PoseFix};
use scphd_log::noise::Noise;
use std::f64::consts::PI;

const SPEED_MPS: f64 = 3.0;

/// The lap in odometry rows: long side, corner, short side, corner, then the same again.
const LONG_ROWS: usize = 80;
const SHORT_ROWS: usize = 40;
const CORNER_ROWS: usize = 100;
const LAP_ROWS: usize = 2 * (LONG_ROWS + SHORT_ROWS) + 4 * CORNER_ROWS;
const LAPS: usize = 2;

/// The distance from the path is at least ten standard deviations of the range, so that no measured range is negative.
const SCATTER: Scatter = Scatter { count: 60, seed: 1, from_path_m: (2.5, 12.0), apart_m: 3.0, from_tracks_m: 0.0 };

/// An Ackermann vehicle with the geometry of 5.3.1 (a 1.890, b 0.250, H 0.380, L 1.415 m) drives two laps of a
/// rounded rectangle at 3 m/s.
///
/// Odometry at 20 Hz with white noise of 1 m/s and 2°; 641 scans at 10 Hz with a full circle of 15 m, noise of 0.25 m and 0.5°,
/// p_D 0.95 within the true range, and 20 false measurements a scan, uniform in range and bearing. The measurements of a scan are
/// in random order. Truth at every scan.
pub fn survey(seed: u64) -> Log {
    let (controls, landmarks) = way();
    let imperfection = Imperfection::OF_5_3_1;
    Simulation { name: "survey", controls, landmarks, movers: Vec::new(), imperfection }.log(seed)
}

/// Controls of the true trajectory, row by row, and the landmarks, m.
pub(super) fn way() -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
    let controls: Vec<[f64; 2]> = (0..LAPS * LAP_ROWS).map(control).collect();
    let landmarks = SCATTER.around(&drive(&controls), &[]);
    (controls, landmarks)
}

/// The same log with a position fix every 10 s, with 1 m of noise along each axis, as from a satellite receiver.
pub fn survey_fixes(seed: u64) -> Log {
    const EVERY_SCANS: usize = 100;
    const SIGMA_M: f64 = 1.0;
    let log = survey(seed);
    // A separate random number generator, so that everything else is as without fixes.
    let mut noise = Noise::new(seed ^ 0x5eed_f13e);
    let fixes = log.truth.iter().step_by(EVERY_SCANS).skip(1).map(|truth| {
        let place = truth.position.map(|at| at + SIGMA_M * noise.normal());
        Fix { t_s: truth.t_s, measured: PoseFix::Position(place) }
    });
    let fixes = fixes.collect();
    let fix_noise = FixNoise { position_sigma_m: Some(SIGMA_M), ..FixNoise::default() };
    Log { name: "survey-fixes".into(), fixes, fix_noise, ..log }
}

/// Encoder speed (m/s) and steering angle (rad) for exactly row `row` of the path.
///
/// The curvature of the rear axle's path is a raised cosine over each corner: it starts and ends smoothly at 0, and its integral
/// is a quarter turn, also when summed row by row, so that the lap is closed.
fn control(row: usize) -> [f64; 2] {
    let half = LAP_ROWS / 2;
    let place = row % half;
    let corner_start = if place < LONG_ROWS + CORNER_ROWS { LONG_ROWS } else { LONG_ROWS + CORNER_ROWS + SHORT_ROWS };
    let length_m = CORNER_ROWS as f64 * SPEED_MPS / super::car::ROWS_PER_SECOND;
    let curvature = match place.checked_sub(corner_start) {
        Some(step) if step < CORNER_ROWS => {
            0.5 * PI / length_m * (1.0 - libm::cos(2.0 * PI * step as f64 / CORNER_ROWS as f64))
        }
        _ => 0.0,
    };
    car_control(SPEED_MPS, curvature)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_log::angle::wrap;
    use scphd_log::vehicle::dead_reckoning;

    #[test]
    fn the_lap_is_closed_and_has_its_size() {
        let log = survey(1);
        assert_eq!((log.odometry.len(), log.scans.len(), log.truth.len()), (1280, 641, 641));
        let lap_scans = LAP_ROWS / 2;
        for (first, second) in log.truth.iter().zip(&log.truth[lap_scans..]) {
            for k in 0..2 {
                assert!((first.position[k] - second.position[k]).abs() < 1e-9);
            }
            let turned = wrap(first.heading_rad.unwrap() - second.heading_rad.unwrap());
            assert!(turned.abs() < 1e-9);
        }
        let extent = |k: usize| {
            let along = log.truth.iter().map(|row| row.position[k]);
            along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
        };
        assert!((extent(0) - 29.4).abs() < 0.1 && (extent(1) - 23.4).abs() < 0.1);
    }

    #[test]
    fn without_noise_dead_reckoning_is_the_truth() {
        let mut log = survey(0);
        for (row, odometry) in log.odometry.iter_mut().enumerate() {
            let [speed, steering] = control(row);
            odometry.control = [speed, steering, 0.0];
        }
        for (pose, truth) in dead_reckoning(&log).iter().zip(&log.truth) {
            assert!((pose[0] - truth.position[0]).hypot(pose[1] - truth.position[1]) < 1e-9);
        }
    }

    /// The digests of the filter over this log are committed.
    #[test]
    fn the_log_is_fixed_to_the_bit() {
        let log = survey(1);
        let all = log.scans.iter().flat_map(|scan| scan.detections.as_flattened());
        let hash =
            all.fold(0_u64, |hash, number| hash.rotate_left(5).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ number.to_bits());
        assert_eq!(hash, 0xdeb4_8fbe_6ccb_f90a);
    }
}
