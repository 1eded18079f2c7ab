//! Simulation of a log from a trajectory, landmarks and noise.

use super::car::{CAR, ROWS_PER_SECOND, drive};
use super::mover::{Mover, tracks};
use scphd_log::angle::wrap;
use scphd_log::log::{Log, Nominal, Odometry, Scan, Sensor, TruePose};
use scphd_log::noise::Noise;
use std::f64::consts::PI;

/// Number of odometry rows for each scan: scans at 10 Hz (5.3.1).
pub(super) const ROWS_PER_SCAN: usize = 2;

/// Errors of odometry and sensor. The view of the sensor is the full circle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Imperfection {
    /// Standard deviation of the encoder speed, independent in each row, m/s.
    pub speed_sigma_mps: f64,
    /// Standard deviation of the steering angle, independent in each row, rad.
    pub steering_sigma_rad: f64,
    /// Range up to which there are detections, m.
    pub range_max_m: f64,
    pub range_sigma_m: f64,
    pub bearing_sigma_rad: f64,
    /// p_D within the true range.
    pub detection_probability: f64,
    /// Mean number of false measurements a scan, uniform in range and bearing.
    pub clutter_per_scan: f64,
}

impl Imperfection {
    /// The errors of section 5.3.1.
    pub const OF_5_3_1: Self = Self {
        speed_sigma_mps: 1.0,
        steering_sigma_rad: 2.0 * PI / 180.0,
        range_max_m: 15.0,
        range_sigma_m: 0.25,
        bearing_sigma_rad: 0.5 * PI / 180.0,
        detection_probability: 0.95,
        clutter_per_scan: 20.0,
    };

    /// Range (m) and bearing (rad) of the detections from `pose`, each with the index of its landmark, or −1, in random order.
    pub fn scan(
        &self,
        pose: &[f64; 3],
        landmarks: impl Iterator<Item = [f64; 2]>,
        noise: &mut Noise,
    ) -> Vec<([f64; 2], i64)> {
        let [x, y, heading] = *pose;
        let mut detections = Vec::new();
        for (label, landmark) in (0..).zip(landmarks) {
            let (dx, dy) = (landmark[0] - x, landmark[1] - y);
            let range = (dx * dx + dy * dy).sqrt();
            if range <= self.range_max_m && noise.happens(self.detection_probability) {
                let bearing = libm::atan2(dy, dx) - heading;
                // A range is not negative.
                let range = (range + self.range_sigma_m * noise.normal()).abs();
                detections.push(([range, wrap(bearing + self.bearing_sigma_rad * noise.normal())], label));
            }
        }
        for _ in 0..noise.poisson(self.clutter_per_scan) {
            detections.push(([noise.between(0.0, self.range_max_m), noise.between(-PI, PI)], -1));
        }
        noise.shuffle(&mut detections);
        detections
    }
}

#[derive(Debug)]
pub(super) struct Simulation {
    pub name: &'static str,
    /// Controls of the true trajectory, row by row.
    pub controls: Vec<[f64; 2]>,
    pub landmarks: Vec<[f64; 2]>,
    pub movers: Vec<Mover>,
    pub imperfection: Imperfection,
}

impl Simulation {
    /// The log with the noise of `seed`, with truth at every scan.
    pub fn log(self, seed: u64) -> Log {
        let imperfection = self.imperfection;
        let path = drive(&self.controls);
        let mut noise = Noise::new(seed);
        let odometry = self
            .controls
            .iter()
            .enumerate()
            .map(|(row, [speed, steering])| Odometry {
                t_s: row as f64 / ROWS_PER_SECOND,
                control: [
                    speed + imperfection.speed_sigma_mps * noise.normal(),
                    steering + imperfection.steering_sigma_rad * noise.normal(),
                    0.0,
                ],
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
            .map(|(truth, pose)| {
                let moving = self.movers.iter().map(|mover| mover.at(truth.t_s));
                let seen = imperfection.scan(pose, self.landmarks.iter().copied().chain(moving), &mut noise);
                let (detections, labels) = seen.into_iter().unzip();
                Scan { t_s: truth.t_s, detections, labels, ..Scan::default() }
            })
            .collect();
        let times: Vec<f64> = truth.iter().map(|row| row.t_s).collect();
        let moving = tracks(&self.movers, self.landmarks.len(), &times);

        Log {
            name: self.name.to_owned(),
            initial_pose: path[0],
            vehicle: CAR,
            sensor: Sensor {
                range_max_m: imperfection.range_max_m,
                bearing_min_rad: -PI,
                bearing_max_rad: PI,
                ..Sensor::default()
            },
            nominal: Nominal {
                range_sigma_m: Some(imperfection.range_sigma_m),
                range_sigma_ratio: 0.0,
                bearing_sigma_rad: Some(imperfection.bearing_sigma_rad),
                speed_sigma_mps: Some(imperfection.speed_sigma_mps),
                rate_sigma_radps: None,
                steering_sigma_rad: Some(imperfection.steering_sigma_rad),
                detection_probability: Some(imperfection.detection_probability),
                clutter_per_scan: Some(imperfection.clutter_per_scan),
            },
            simulated: true,
            odometry,
            scans,
            truth,
            landmarks: self.landmarks,
            moving,
            ..Log::default()
        }
    }
}
