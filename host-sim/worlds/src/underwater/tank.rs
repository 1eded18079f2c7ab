//! The scenario `girona-tank`: a survey of a test tank's floor, as in section 7.2.4.
//!
//! A tank of 8 × 8 × 5 m. The vehicle surveys the floor from a height of about two metres with two crossed lawnmowers, so that
//! every strip of the second crosses all of the first. Parameters beyond those of the thesis and its Table 7.1:
//!
//! * camera: 800 × 600 px, focal length 890 px, baseline 0.2 m, 0.3 m ahead of the vehicle's origin, looking down;
//! * floor: 800 point features on relief of up to half a metre; half of them are stable (detected in 85 to 95 % of the frames
//!   that show them), the others are detected in 20 to 70 %;
//! * false keypoints are pairs of a matcher, which accepts disparities of depths from 0.8 to 3.5 m and row differences of up to
//!   13 px;
//! * Doppler log: five readings a second, one in a hundred an outlier of a metre a second or so, no bottom lock between 40 and
//!   43 s and between 85 and 88 s; pressure sensor: σ 0.02 m; gyroscope: σ 0.02 rad/s; roll and pitch: σ 0.2°;
//! * compass: walls with magnets deflect it by up to 15°, in addition to 1° of noise.

use super::stereo::{self, Projections};
use nalgebra::{Matrix3, Vector3};
use scphd::models::{projection, rotation};
use scphd_log::angle::wrap;
use scphd_log::log::{Scan, TruePose};
use scphd_log::noise::Noise;
use scphd_log::underwater::{Camera, Instruments, Landmark, Log, Nominal};
use std::f64::consts::PI;

/// Side of the tank, m.
pub const SIDE_M: f64 = 8.0;
/// z of the floor, m; the surface is at 0.
pub const FLOOR_M: f64 = -5.0;
/// z of the vehicle, m.
const CRUISE_M: f64 = -2.9;
/// Rate of the frames, and of the rows of the instruments, Hz.
const RATE_HZ: f64 = 10.0;
/// Least and greatest speed, m/s, and acceleration, m/s².
const SPEED_MPS: [f64; 2] = [0.08, 0.6];
const ACCELERATION_MPS2: f64 = 0.2;
/// Greatest yaw rate, rad/s, and angular acceleration, rad/s².
const TURN_RADPS: f64 = 0.6;
const ANGULAR_ACCELERATION_RADPS2: f64 = 0.6;
/// Coordinates of the lines of a lawnmower, m, and of their ends.
const LINES_M: [f64; 5] = [1.6, 2.8, 4.0, 5.2, 6.4];
const ENDS_M: [f64; 2] = [1.5, 6.5];
/// Distance within which a way point is reached, m.
const REACHED_M: f64 = 0.15;

const LANDMARKS: usize = 800;
const FOCAL_PX: f64 = 890.0;
const BASELINE_M: f64 = 0.2;
const SIZE_PX: [f64; 2] = [800.0, 600.0];
const DEPTH_M: [f64; 2] = [0.8, 3.5];
const ROW_TOLERANCE_PX: f64 = 13.0;
const PIXEL_SIGMA: f64 = 3.0;
const CLUTTER: f64 = 20.0;

const DVL_SIGMA_MPS: f64 = 0.1;
const DVL_ROWS: usize = 2;
const DVL_OUTLIER_SHARE: f64 = 0.01;
/// Intervals without bottom lock of the Doppler log, s.
const UNLOCKED_S: [[f64; 2]; 2] = [[40.0, 43.0], [85.0, 88.0]];
const Z_SIGMA_M: f64 = 0.02;
const GYRO_SIGMA_RADPS: f64 = 0.02;
const TILT_SIGMA_RAD: f64 = 0.2 * PI / 180.0;
const COMPASS_SIGMA_RAD: f64 = PI / 180.0;
/// Deflection of the compass by a wall where the vehicle is nearest to it, rad, and the distance over which it decays, m.
const PULL_RAD: f64 = 15.0 * PI / 180.0;
const PULL_NEAR_M: f64 = 1.4;
const PULL_FADE_M: f64 = 0.8;

/// A state of the true vehicle.
#[derive(Debug, Clone, Copy)]
struct Vehicle {
    position: Vector3<f64>,
    yaw_rad: f64,
    roll_rad: f64,
    pitch_rad: f64,
    /// Velocity and yaw rate until the next row.
    velocity_mps: Vector3<f64>,
    yaw_rate_radps: f64,
}

impl Vehicle {
    fn rotation(&self) -> Matrix3<f64> {
        rotation(self.roll_rad, self.pitch_rad, self.yaw_rad)
    }
}

/// The way points of both lawnmowers.
fn way_points() -> Vec<[f64; 2]> {
    let [near, far] = ENDS_M;
    let line = |(index, &place): (usize, &f64)| {
        if index % 2 == 0 { [[near, place], [far, place]] } else { [[far, place], [near, place]] }
    };
    let along: Vec<[f64; 2]> = LINES_M.iter().enumerate().flat_map(line).collect();
    // It ends in a far corner; from there a second one crosses it, back to the first corner.
    let across = along.iter().map(|&[x, y]| [SIDE_M - y, SIDE_M - x]);
    along.iter().copied().chain(across).collect()
}

/// The true trajectory, row by row, which is the same for all seeds.
fn way() -> Vec<Vehicle> {
    let points = way_points();
    let dt = 1.0 / RATE_HZ;
    let mut vehicle = Vehicle {
        position: Vector3::new(points[0][0], points[0][1], CRUISE_M),
        yaw_rad: 0.0,
        roll_rad: 0.0,
        pitch_rad: 0.0,
        velocity_mps: Vector3::zeros(),
        yaw_rate_radps: 0.0,
    };
    let (mut way, mut next, mut speed, mut rate) = (Vec::new(), 1, SPEED_MPS[0], 0.0);
    while next < points.len() {
        let t = way.len() as f64 * dt;
        let [dx, dy] = [points[next][0] - vehicle.position.x, points[next][1] - vehicle.position.y];
        let (turn, distance) = (wrap(libm::atan2(dy, dx) - vehicle.yaw_rad), libm::hypot(dx, dy));
        // The speed from which the vehicle can stop in time with half of its deceleration.
        let wanted = libm::copysign(libm::sqrt(ANGULAR_ACCELERATION_RADPS2 * turn.abs()).min(TURN_RADPS), turn);
        let change = ANGULAR_ACCELERATION_RADPS2 * dt;
        let next_rate = rate + (wanted - rate).clamp(-change, change);
        vehicle.yaw_rate_radps = 0.5 * (rate + next_rate);
        rate = next_rate;
        let ahead = libm::sqrt(ACCELERATION_MPS2 * distance).min(SPEED_MPS[1]) * libm::cos(turn).max(0.0);
        let change = ACCELERATION_MPS2 * dt;
        speed += (ahead.max(SPEED_MPS[0]) - speed).clamp(-change, change);
        let sway = 0.04 * libm::sin(0.8 * t);
        let climb = 0.3 * (CRUISE_M + 0.15 * libm::sin(0.11 * t) - vehicle.position.z);
        vehicle.roll_rad = 0.03 * libm::sin(1.1 * t);
        vehicle.pitch_rad = 0.03 * libm::sin(0.9 * t + 1.0);
        // The climb is in the map's frame; the velocity is converted to the vehicle's frame.
        let level = rotation(vehicle.roll_rad, vehicle.pitch_rad, 0.0);
        vehicle.velocity_mps = level.transpose() * Vector3::new(speed, sway, climb);
        way.push(vehicle);
        let moved = vehicle.rotation() * vehicle.velocity_mps * dt;
        vehicle.position += moved;
        vehicle.yaw_rad = wrap(vehicle.yaw_rad + vehicle.yaw_rate_radps * dt);
        if distance < REACHED_M {
            next += 1;
        }
    }
    way
}

/// The features of the floor, which are the same for all seeds.
fn landmarks() -> Vec<Landmark> {
    let mut noise = Noise::new(7007);
    let height = |x: f64, y: f64| {
        let swell = 0.12 * libm::sin(1.3 * x + 0.4) * libm::cos(0.9 * y);
        // Two blocks stand on the floor.
        let block = |[cx, cy]: [f64; 2]| (x - cx).abs() < 0.5 && (y - cy).abs() < 0.4;
        swell + if block([2.6, 3.1]) || block([5.6, 5.0]) { 0.4 } else { 0.0 }
    };
    (0..LANDMARKS)
        .map(|index| {
            let (x, y) = (noise.between(0.0, SIDE_M), noise.between(0.0, SIDE_M));
            let detectability = if index % 2 == 0 { noise.between(0.85, 0.95) } else { noise.between(0.2, 0.7) };
            Landmark { position: [x, y, FLOOR_M + height(x, y) + 0.02 * noise.normal()], detectability }
        })
        .collect()
}

/// Deflection of the compass by the walls, rad. A wall attracts the needle, so that the error changes its sign with the side of
/// the wall.
fn pull(vehicle: &Vehicle) -> f64 {
    let (x, y) = (vehicle.position.x, vehicle.position.y);
    let walls = [(x, PI), (SIDE_M - x, 0.0), (y, -0.5 * PI), (SIDE_M - y, 0.5 * PI)];
    let pull: f64 = walls
        .iter()
        .map(|&(distance, direction)| {
            let strength = libm::exp(-(distance - PULL_NEAR_M).max(0.0) / PULL_FADE_M);
            strength * libm::sin(direction - vehicle.yaw_rad)
        })
        .sum();
    PULL_RAD * pull.clamp(-1.0, 1.0)
}

fn camera() -> Projections {
    let calibration = Matrix3::new(FOCAL_PX, 0.0, 400.0, 0.0, FOCAL_PX, 300.0, 0.0, 0.0, 1.0);
    // The top of the image is ahead.
    let down = Matrix3::new(0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0);
    [0.5, -0.5].map(|side| projection(&calibration, &down, &Vector3::new(0.3, side * BASELINE_M, -0.1)))
}

fn keypoints(vehicle: &Vehicle, landmarks: &[Landmark], noise: &mut Noise) -> Vec<[f64; 4]> {
    let (cameras, turned) = (camera(), vehicle.rotation());
    let mut keypoints = Vec::new();
    for landmark in landmarks {
        let point = turned.tr_mul(&(Vector3::from(landmark.position) - vehicle.position));
        let shown = stereo::pair(&cameras, SIZE_PX, DEPTH_M, &point);
        if let Some(shown) = shown.filter(|_| noise.happens(landmark.detectability)) {
            let pair = shown.map(|pixel| pixel + PIXEL_SIGMA * noise.normal());
            // The matcher does not accept a greater row difference.
            if (pair[1] - pair[3]).abs() <= ROW_TOLERANCE_PX {
                keypoints.push(pair);
            }
        }
    }
    let disparity = DEPTH_M.map(|depth| FOCAL_PX * BASELINE_M / depth);
    for _ in 0..noise.poisson(CLUTTER) {
        let (u, v) = (noise.between(0.0, SIZE_PX[0]), noise.between(0.0, SIZE_PX[1]));
        let row = v + noise.between(-ROW_TOLERANCE_PX, ROW_TOLERANCE_PX);
        keypoints.push([u, v, u - noise.between(disparity[1], disparity[0]), row]);
    }
    noise.shuffle(&mut keypoints);
    keypoints
}

fn instruments(t_s: f64, row: usize, vehicle: &Vehicle, noise: &mut Noise) -> Instruments {
    let unlocked = UNLOCKED_S.iter().any(|&[from, to]| (from..to).contains(&t_s));
    let mut measured = vehicle.velocity_mps.map(|v| v + DVL_SIGMA_MPS * noise.normal());
    if noise.happens(DVL_OUTLIER_SHARE) {
        measured += Vector3::from_fn(|_, _| noise.normal());
    }
    Instruments {
        t_s,
        roll_rad: vehicle.roll_rad + TILT_SIGMA_RAD * noise.normal(),
        pitch_rad: vehicle.pitch_rad + TILT_SIGMA_RAD * noise.normal(),
        yaw_rad: wrap(vehicle.yaw_rad + pull(vehicle) + COMPASS_SIGMA_RAD * noise.normal()),
        yaw_rate_radps: vehicle.yaw_rate_radps + GYRO_SIGMA_RADPS * noise.normal(),
        yaw_rate_sigma_radps: None,
        velocity_mps: (row.is_multiple_of(DVL_ROWS) && !unlocked).then(|| measured.into()),
        z_m: Some(vehicle.position.z + Z_SIGMA_M * noise.normal()),
    }
}

/// The log with the noise of `seed`.
pub fn girona_tank(seed: u64) -> Log {
    let (way, landmarks, mut noise) = (way(), landmarks(), Noise::new(seed));
    let time = |row: usize| row as f64 / RATE_HZ;
    let start = way[0];
    Log {
        name: "girona-tank".into(),
        camera: Camera {
            projections: stereo::rows(&camera()),
            size_px: SIZE_PX,
            pixel_sigmas: [PIXEL_SIGMA; 4],
            // A wrong tilt moves the pixels of both images together.
            common_sigmas: [FOCAL_PX * TILT_SIGMA_RAD; 2],
            depth_m: DEPTH_M,
            focal_baseline: FOCAL_PX * BASELINE_M,
            row_tolerance_px: ROW_TOLERANCE_PX,
        },
        nominal: Nominal {
            velocity_sigma_mps: DVL_SIGMA_MPS,
            velocity_walk_mps_rts: 0.1,
            z_sigma_m: Z_SIGMA_M,
            yaw_rate_sigma_radps: GYRO_SIGMA_RADPS,
            yaw_acceleration_sigma_radps2: 0.6,
            detection_probability: 0.85,
            clutter_per_scan: CLUTTER,
        },
        start: (start.position.into(), start.yaw_rad),
        instruments: way.iter().enumerate().map(|(row, v)| instruments(time(row), row, v, &mut noise)).collect(),
        simulated: true,
        scans: way
            .iter()
            .enumerate()
            .map(|(row, v)| Scan {
                sensor: 0,
                t_s: time(row),
                detections: keypoints(v, &landmarks, &mut noise),
                labels: Vec::new(),
            })
            .collect(),
        truth: way
            .iter()
            .enumerate()
            .map(|(row, v)| TruePose { t_s: time(row), position: v.position.into(), heading_rad: Some(v.yaw_rad) })
            .collect(),
        landmarks,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_survey_stays_in_the_tank_above_the_floor_and_returns() {
        let way = way();
        assert!(way.len() > 900 && way.len() < 2500, "{}", way.len());
        for vehicle in &way {
            let [x, y, z] = vehicle.position.into();
            assert!((1.0..=7.0).contains(&x) && (1.0..=7.0).contains(&y) && (-3.3..=-2.5).contains(&z), "{x} {y} {z}");
        }
        // Every line of the second lawnmower crosses the first.
        let last = way.last().unwrap().position;
        let first = way[0].position;
        assert!((last - first).xy().norm() < 1.0, "{first} {last}");
    }

    #[test]
    fn the_log_has_the_chosen_parameters() {
        let (log, same) = (girona_tank(3), girona_tank(3));
        assert_eq!(log, same);
        assert_ne!(log.scans, girona_tank(4).scans);
        let detections = log.scans.iter().map(|scan| scan.detections.len()).sum::<usize>() as f64;
        let a_frame = detections / log.scans.len() as f64;
        assert!((32.0..50.0).contains(&a_frame), "{a_frame}");
        let stable = log.stable().count();
        assert!((LANDMARKS * 6 / 10..LANDMARKS * 8 / 10).contains(&stable), "{stable}");
        let bottom = log.instruments.iter().filter(|row| row.velocity_mps.is_some()).count();
        assert!(bottom * 2 < log.instruments.len() && bottom * 5 > log.instruments.len() * 2);
        // The error of the compass is up to 15°, and more than 5° in much of the survey.
        let truth = log.truth.iter().map(|row| row.heading_rad.unwrap());
        let off = |(row, yaw_rad): (&Instruments, f64)| wrap(row.yaw_rad - yaw_rad).abs().to_degrees();
        let errors: Vec<f64> = log.instruments.iter().zip(truth).map(off).collect();
        let worst = errors.iter().copied().fold(0.0, f64::max);
        assert!((12.0..20.0).contains(&worst), "{worst}");
        assert!(errors.iter().filter(|&&error| error > 5.0).count() * 10 > errors.len());
    }

    #[test]
    fn the_rows_of_the_instruments_give_the_trajectory() {
        let way = way();
        for pair in way.windows(2) {
            let moved = pair[0].position + pair[0].rotation() * pair[0].velocity_mps / RATE_HZ;
            assert!((moved - pair[1].position).norm() < 1e-12);
        }
        assert!(landmarks().iter().all(|l| (FLOOR_M - 0.3..FLOOR_M + 0.7).contains(&l.position[2])));
    }
}
