//! The scenario of a car with two sensors.

use super::car::{CAR, ROWS_PER_SECOND, drive};
use super::survey::way;
use scphd_log::angle::wrap;
use scphd_log::log::{Log, Mounting, NamedSensor, Nominal, Odometry, Scan, Sensor, TruePose};
use scphd_log::noise::Noise;
use std::f64::consts::PI;

const SPEED_SIGMA_MPS: f64 = 0.3;
const STEERING_SIGMA_RAD: f64 = PI / 180.0;

/// A sensor with its scan times: index of the first row of odometry with a scan, and number of rows between scans.
struct Eye {
    name: &'static str,
    sensor: Sensor,
    sigmas: [f64; 2],
    detection_probability: f64,
    clutter_per_scan: f64,
    rows: [usize; 2],
}

/// At the pose, in front.
const LIDAR: Eye = Eye {
    name: "lidar",
    sensor: Sensor {
        range_min_m: 0.0,
        range_max_m: 15.0,
        bearing_min_rad: -1.6,
        bearing_max_rad: 1.6,
        mounting: Mounting::NONE,
    },
    sigmas: [0.1, 0.25 * PI / 180.0],
    detection_probability: 0.95,
    clutter_per_scan: 5.0,
    rows: [0, 2],
};

/// At the back, with the view backwards.
const RADAR: Eye = Eye {
    name: "radar",
    sensor: Sensor {
        range_min_m: 1.0,
        range_max_m: 25.0,
        bearing_min_rad: -0.9,
        bearing_max_rad: 0.9,
        mounting: Mounting { forward_m: -2.4, left_m: -0.25, yaw_rad: PI },
    },
    sigmas: [0.4, 1.5 * PI / 180.0],
    detection_probability: 0.85,
    clutter_per_scan: 3.0,
    rows: [3, 5],
};

impl Eye {
    /// Whether there is a scan at this row.
    fn is_due(&self, row: usize) -> bool {
        row.checked_sub(self.rows[0]).is_some_and(|since| since.is_multiple_of(self.rows[1]))
    }

    /// Range (m) and bearing (rad) of the detections from a vehicle at `pose`, in random order.
    fn scan(&self, pose: [f64; 3], landmarks: &[[f64; 2]], noise: &mut Noise) -> Vec<[f64; 2]> {
        let Sensor { range_min_m, range_max_m, bearing_min_rad, bearing_max_rad, mounting } = self.sensor;
        let [x, y, heading] = mounting.seat(pose);
        let mut detections = Vec::new();
        for [at_x, at_y] in landmarks {
            let (dx, dy) = (at_x - x, at_y - y);
            let (range, bearing) = (libm::hypot(dx, dy), wrap(libm::atan2(dy, dx) - heading));
            let in_view =
                (range_min_m..=range_max_m).contains(&range) && (bearing_min_rad..=bearing_max_rad).contains(&bearing);
            if in_view && noise.happens(self.detection_probability) {
                let range = (range + self.sigmas[0] * noise.normal()).abs();
                detections.push([range, wrap(bearing + self.sigmas[1] * noise.normal())]);
            }
        }
        for _ in 0..noise.poisson(self.clutter_per_scan) {
            let range = noise.between(range_min_m, range_max_m);
            detections.push([range, noise.between(bearing_min_rad, bearing_max_rad)]);
        }
        noise.shuffle(&mut detections);
        detections
    }

    fn nominal(&self) -> Nominal {
        Nominal {
            range_sigma_m: Some(self.sigmas[0]),
            range_sigma_ratio: 0.0,
            bearing_sigma_rad: Some(self.sigmas[1]),
            speed_sigma_mps: Some(SPEED_SIGMA_MPS),
            rate_sigma_radps: None,
            steering_sigma_rad: Some(STEERING_SIGMA_RAD),
            detection_probability: Some(self.detection_probability),
            clutter_per_scan: Some(self.clutter_per_scan),
        }
    }
}

/// The car of `survey` on its trajectory, with a lidar in front (10 Hz, 15 m, 92° to each side) and a radar at the back with its
/// view backwards (4 Hz, 25 m, 52° to each side, four times the noise in range and six times in bearing). Truth at every scan of
/// either.
pub fn two_sensors(seed: u64) -> Log {
    let (controls, landmarks) = way();
    let path = drive(&controls);
    let mut noise = Noise::new(seed);
    let time = |row: usize| row as f64 / ROWS_PER_SECOND;
    let odometry = controls.iter().enumerate().map(|(row, [speed, steering])| Odometry {
        t_s: time(row),
        control: [speed + SPEED_SIGMA_MPS * noise.normal(), steering + STEERING_SIGMA_RAD * noise.normal(), 0.0],
    });
    let odometry = odometry.collect();
    let (mut scans, mut truth) = (Vec::new(), Vec::new());
    for (row, &pose) in path.iter().enumerate() {
        for (sensor, eye) in [LIDAR, RADAR].iter().enumerate().filter(|(_, eye)| eye.is_due(row)) {
            let detections = eye.scan(pose, &landmarks, &mut noise);
            scans.push(Scan { t_s: time(row), sensor, detections, labels: Vec::new() });
            truth.push(TruePose { t_s: time(row), position: [pose[0], pose[1]], heading_rad: Some(pose[2]) });
        }
    }
    Log {
        name: "two-sensors".into(),
        initial_pose: path[0],
        vehicle: CAR,
        sensor: LIDAR.sensor,
        sensor_name: LIDAR.name.into(),
        nominal: LIDAR.nominal(),
        others: vec![NamedSensor { name: RADAR.name.into(), sensor: RADAR.sensor, nominal: RADAR.nominal() }],
        simulated: true,
        odometry,
        scans,
        truth,
        landmarks,
        ..Log::default()
    }
}
