//! Built-in simulated scenarios.
//!
//! The map and the path of a scenario never change; its seed changes the noise, the missed detections and
//! the clutter. The same seed gives the same log, bit for bit, on every machine (see [`crate::noise`]).

use crate::angle::wrap;
use crate::log::{Log, Nominal, Odometry, Scan, Sensor, TruePose, Vehicle};
use crate::noise::Noise;
use std::f64::consts::PI;

/// Names of the scenarios, each with a line about it.
pub const SCENARIOS: &[(&str, &str)] = &[(
    "survey",
    "a car drives two laps of a rounded rectangle (29 x 23 m, 64 s) among 60 landmarks, 20 false measurements a scan",
)];

/// The scenario of that name.
#[must_use]
pub fn by_name(name: &str, seed: u64) -> Option<Log> {
    match name {
        "survey" => Some(survey(seed)),
        _ => None,
    }
}

/// Geometry of 5.3.1, m.
const WHEELBASE_M: f64 = 1.415;
const ENCODER_OFFSET_M: f64 = 0.380;
const SENSOR_FORWARD_M: f64 = 1.890;
const SENSOR_LEFT_M: f64 = 0.250;

const SPEED_MPS: f64 = 3.0;
const SPEED_SIGMA_MPS: f64 = 1.0;
const STEERING_SIGMA_RAD: f64 = 2.0 * PI / 180.0;

const RANGE_MAX_M: f64 = 15.0;
const RANGE_SIGMA_M: f64 = 0.25;
const BEARING_SIGMA_RAD: f64 = 0.5 * PI / 180.0;
const DETECTION_PROBABILITY: f64 = 0.95;
const CLUTTER_PER_SCAN: f64 = 20.0;

/// Odometry rows a second; every second of them comes with a scan.
const ROWS_PER_SECOND: f64 = 20.0;
const ROWS_PER_SCAN: usize = 2;

/// The lap in odometry rows: long side, corner, short side, corner, and the same again.
const LONG_ROWS: usize = 80;
const SHORT_ROWS: usize = 40;
const CORNER_ROWS: usize = 100;
const LAP_ROWS: usize = 2 * (LONG_ROWS + SHORT_ROWS) + 4 * CORNER_ROWS;
const LAPS: usize = 2;

const LANDMARKS: usize = 60;
const LANDMARK_SEED: u64 = 1;
/// Least and greatest distance of a landmark from the path of the sensor, m. The least is ten standard
/// deviations of the range, so that no measured range is negative.
const FROM_PATH_M: (f64, f64) = (2.5, 12.0);
/// Least distance between two landmarks, m.
const APART_M: f64 = 3.0;

/// An Ackermann vehicle with the geometry of 5.3.1 (a 1.890, b 0.250, H 0.380, L 1.415 m) drives two laps of a
/// rounded rectangle at 3 m/s.
///
/// Odometry at 20 Hz with white noise of 1 m/s and 2°; 641 scans at 10 Hz, all around to 15 m, with 0.25 m and
/// 0.5° of noise, p_D 0.95 within the true range and 20 false measurements a scan, uniform in range and
/// bearing. The order of a scan's measurements tells nothing. Truth at every scan.
#[must_use]
pub fn survey(seed: u64) -> Log {
    let vehicle = Vehicle::Ackermann {
        wheelbase_m: WHEELBASE_M,
        encoder_offset_m: ENCODER_OFFSET_M,
        sensor_forward_m: SENSOR_FORWARD_M,
        sensor_left_m: SENSOR_LEFT_M,
    };
    let controls: Vec<[f64; 2]> = (0..LAPS * LAP_ROWS).map(control).collect();
    let path = drive(&vehicle, &controls);
    let landmarks = landmarks(&path);

    let mut noise = Noise::new(seed);
    let odometry = controls
        .iter()
        .enumerate()
        .map(|(row, [speed, steering])| Odometry {
            t_s: row as f64 / ROWS_PER_SECOND,
            control: [speed + SPEED_SIGMA_MPS * noise.normal(), steering + STEERING_SIGMA_RAD * noise.normal()],
        })
        .collect();
    let seen_from = path.iter().enumerate().step_by(ROWS_PER_SCAN);
    let truth: Vec<TruePose> = seen_from
        .map(|(row, &[x, y, heading])| TruePose {
            t_s: row as f64 / ROWS_PER_SECOND,
            position: [x, y],
            heading_rad: Some(heading),
        })
        .collect();
    let scans = truth
        .iter()
        .zip(path.iter().step_by(ROWS_PER_SCAN))
        .map(|(truth, pose)| Scan { t_s: truth.t_s, detections: scan(pose, &landmarks, &mut noise) })
        .collect();

    Log {
        name: "survey".to_owned(),
        initial_pose: path[0],
        vehicle,
        sensor: Sensor { range_min_m: 0.0, range_max_m: RANGE_MAX_M, bearing_min_rad: -PI, bearing_max_rad: PI },
        nominal: Nominal {
            range_sigma_m: Some(RANGE_SIGMA_M),
            bearing_sigma_rad: Some(BEARING_SIGMA_RAD),
            speed_sigma_mps: Some(SPEED_SIGMA_MPS),
            rate_sigma_radps: None,
            steering_sigma_rad: Some(STEERING_SIGMA_RAD),
            detection_probability: Some(DETECTION_PROBABILITY),
            clutter_per_scan: Some(CLUTTER_PER_SCAN),
        },
        simulated: true,
        odometry,
        scans,
        truth,
        landmarks,
        moving: Vec::new(),
    }
}

/// Encoder speed (m/s) and steering angle (rad) that drive row `row` of the path exactly.
///
/// The rear axle's curvature is a raised cosine over each corner: it starts and ends at 0 without a kink and
/// adds up to a quarter turn, also when summed row by row, so that the lap closes.
fn control(row: usize) -> [f64; 2] {
    let half = LAP_ROWS / 2;
    let place = row % half;
    let corner_start = if place < LONG_ROWS + CORNER_ROWS { LONG_ROWS } else { LONG_ROWS + CORNER_ROWS + SHORT_ROWS };
    let length_m = CORNER_ROWS as f64 * SPEED_MPS / ROWS_PER_SECOND;
    let curvature = match place.checked_sub(corner_start) {
        Some(step) if step < CORNER_ROWS => {
            0.5 * PI / length_m * (1.0 - libm::cos(2.0 * PI * step as f64 / CORNER_ROWS as f64))
        }
        _ => 0.0,
    };
    // tan α = L κ; the encoder is H left of the axle's middle.
    let slope = WHEELBASE_M * curvature;
    [SPEED_MPS * (1.0 - slope * ENCODER_OFFSET_M / WHEELBASE_M), libm::atan(slope)]
}

/// Poses (x m, y m, heading rad) at the start of every row and after the last.
fn drive(vehicle: &Vehicle, controls: &[[f64; 2]]) -> Vec<[f64; 3]> {
    let mut path = vec![[0.0; 3]];
    let mut pose = path[0];
    for &control in controls {
        pose = vehicle.step(pose, control, 1.0 / ROWS_PER_SECOND);
        path.push(pose);
    }
    path
}

/// Landmarks (m) scattered on both sides of the path.
fn landmarks(path: &[[f64; 3]]) -> Vec<[f64; 2]> {
    let mut noise = Noise::new(LANDMARK_SEED);
    let (near, far) = FROM_PATH_M;
    let side = |k: usize| {
        let least = path.iter().map(|pose| pose[k]).fold(f64::INFINITY, f64::min);
        let most = path.iter().map(|pose| pose[k]).fold(f64::NEG_INFINITY, f64::max);
        (least - far, most + far)
    };
    let (width, height) = (side(0), side(1));
    let squared = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]);
    let mut landmarks: Vec<[f64; 2]> = Vec::with_capacity(LANDMARKS);
    while landmarks.len() < LANDMARKS {
        let place = [noise.between(width.0, width.1), noise.between(height.0, height.1)];
        let to_path = path.iter().map(|pose| squared(place, [pose[0], pose[1]])).fold(f64::INFINITY, f64::min);
        let alone = landmarks.iter().all(|&other| squared(place, other) >= APART_M * APART_M);
        if alone && (near * near..=far * far).contains(&to_path) {
            landmarks.push(place);
        }
    }
    landmarks
}

/// Range (m) and bearing (rad) of what the sensor reports from `pose`.
fn scan(pose: &[f64; 3], landmarks: &[[f64; 2]], noise: &mut Noise) -> Vec<[f64; 2]> {
    let [x, y, heading] = *pose;
    let mut detections = Vec::new();
    for landmark in landmarks {
        let (dx, dy) = (landmark[0] - x, landmark[1] - y);
        let range = (dx * dx + dy * dy).sqrt();
        if range <= RANGE_MAX_M && noise.happens(DETECTION_PROBABILITY) {
            let bearing = libm::atan2(dy, dx) - heading;
            detections
                .push([range + RANGE_SIGMA_M * noise.normal(), wrap(bearing + BEARING_SIGMA_RAD * noise.normal())]);
        }
    }
    for _ in 0..noise.poisson(CLUTTER_PER_SCAN) {
        detections.push([noise.between(0.0, RANGE_MAX_M), noise.between(-PI, PI)]);
    }
    noise.shuffle(&mut detections);
    detections
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::dead_reckoning;
    use crate::{log_folder, truth};

    #[test]
    fn names_lead_to_logs() {
        for (name, about) in SCENARIOS {
            assert_eq!(by_name(name, 1).unwrap().name, *name);
            assert!(!about.contains('\n'));
        }
        assert!(by_name("no such scenario", 1).is_none());
    }

    #[test]
    fn the_lap_closes_and_has_its_size() {
        let log = survey(1);
        assert_eq!((log.odometry.len(), log.scans.len(), log.truth.len()), (1280, 641, 641));
        let lap_scans = LAP_ROWS / ROWS_PER_SCAN;
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
    fn detections_are_of_landmarks_or_uniform_clutter_at_the_stated_rates() {
        let (mut in_range, mut detected, mut clutter, mut scans) = (0, 0, 0, 0);
        let (mut range_squares, mut bearing_squares) = (0.0, 0.0);
        for seed in 0..4 {
            let log = survey(seed);
            for scan in &log.scans {
                scans += 1;
                let here = truth::at(&log.truth, scan.t_s).unwrap();
                let mut unexplained = scan.detections.clone();
                for landmark in &log.landmarks {
                    let (dx, dy) = (landmark[0] - here.position[0], landmark[1] - here.position[1]);
                    let range = dx.hypot(dy);
                    if range > RANGE_MAX_M {
                        continue;
                    }
                    in_range += 1;
                    let bearing = dy.atan2(dx) - here.heading_rad.unwrap();
                    let off = |z: &[f64; 2]| [(z[0] - range) / RANGE_SIGMA_M, wrap(z[1] - bearing) / BEARING_SIGMA_RAD];
                    let size = |z: &[f64; 2]| off(z)[0].powi(2) + off(z)[1].powi(2);
                    let Some(best) =
                        (0..unexplained.len()).min_by(|&a, &b| size(&unexplained[a]).total_cmp(&size(&unexplained[b])))
                    else {
                        continue;
                    };
                    // The gate holds all but 1 in 3000.
                    if size(&unexplained[best]) < 16.0 {
                        let [r, b] = off(&unexplained.swap_remove(best));
                        range_squares += r * r;
                        bearing_squares += b * b;
                        detected += 1;
                    }
                }
                clutter += unexplained.len();
            }
        }
        let rate = f64::from(detected) / f64::from(in_range);
        let false_rate = clutter as f64 / f64::from(scans);
        let variances = [range_squares, bearing_squares].map(|sum: f64| sum / f64::from(detected));
        let per_scan = f64::from(in_range) / f64::from(scans);
        println!("{per_scan} in range, detected {rate}, clutter {false_rate}, variances {variances:?}");
        assert!((rate - 0.95).abs() < 0.004);
        assert!((false_rate - 20.0).abs() < 0.4);
        assert!(variances.iter().all(|v| (v - 1.0).abs() < 0.03));
        assert!((8.0..25.0).contains(&per_scan));
    }

    #[test]
    fn dead_reckoning_goes_astray_by_metres() {
        for seed in 0..4 {
            let log = survey(seed);
            let poses = dead_reckoning(&log);
            let errors: Vec<f64> = poses
                .iter()
                .zip(&log.truth)
                .map(|(pose, truth)| (pose[0] - truth.position[0]).hypot(pose[1] - truth.position[1]))
                .collect();
            let greatest = errors.iter().copied().fold(0.0, f64::max);
            println!("seed {seed}: greatest {greatest}, last {}", errors[640]);
            assert_eq!(errors[0], 0.0);
            assert!((0.5..15.0).contains(&greatest), "{greatest}");
        }
        // Without the noise it is the truth.
        let mut log = survey(0);
        for (row, odometry) in log.odometry.iter_mut().enumerate() {
            odometry.control = control(row);
        }
        for (pose, truth) in dead_reckoning(&log).iter().zip(&log.truth) {
            assert!((pose[0] - truth.position[0]).hypot(pose[1] - truth.position[1]) < 1e-9);
        }
    }

    #[test]
    fn the_seed_decides_the_noise_and_nothing_else() {
        let (log, same, other) = (survey(5), survey(5), survey(6));
        assert_eq!(log, same);
        assert_eq!((&log.truth, &log.landmarks), (&other.truth, &other.landmarks));
        assert_ne!(log.odometry, other.odometry);
        assert_ne!(log.scans, other.scans);
    }

    #[test]
    fn a_written_scenario_reads_back_the_same() {
        let dir = std::env::temp_dir().join(format!("scphd-survey-{}", std::process::id()));
        let log = survey(9);
        log_folder::write(&log, &dir).unwrap();
        let back = log_folder::read(&dir);
        std::fs::remove_dir_all(&dir).unwrap();
        assert_eq!(back.unwrap(), log);
    }
}
