//! Plan of a world, before measurements are simulated.

use super::stream::stream;
use crate::scenario::mover::Mover;
use libm::{atan, atan2, cos, exp, log, sin};
use scphd_log::angle::wrap;
use scphd_log::log::{Mounting, Sensor, Vehicle};
use scphd_log::noise::Noise;
use std::f64::consts::PI;

const ROWS_PER_SECOND: f64 = 10.0;
/// Side of the square that contains a world, m.
const EXTENTS_M: [f64; 3] = [12.0, 36.0, 96.0];

#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub extent_m: f64,
    pub vehicle: Vehicle,
    pub sensor: Sensor,
    /// True controls, row by row.
    pub controls: Vec<[f64; 2]>,
    pub landmarks: Vec<[f64; 2]>,
    pub movers: Vec<Mover>,
    pub rows_per_scan: usize,
    pub start: [f64; 3],
    pub range_sigma_m: f64,
    pub bearing_sigma_rad: f64,
    pub detection_probability: f64,
    /// Mean number of independent false measurements a scan.
    pub clutter_per_scan: f64,
    /// White noise of the two controls, independent in each row.
    pub speed_sigma_mps: f64,
    pub turn_sigma: f64,
}

impl Plan {
    /// A world with good sensors: few misses, few false detections, white odometry noise of some per cent.
    pub fn data_sheet(seed: u64) -> Self {
        let mut noise = stream(seed, 1);
        let mut plan = Self::drawn(&mut noise);
        plan.detection_probability = noise.between(0.9, 0.99);
        plan.clutter_per_scan = noise.between(0.05, 0.4);
        plan.speed_sigma_mps = 0.05 * plan.speed();
        plan.turn_sigma = noise.between(0.005, 0.02);
        plan
    }

    /// A world with poor sensors and all errors stated.
    pub fn exact(seed: u64) -> Self {
        let mut noise = stream(seed, 2);
        let mut plan = Self::drawn(&mut noise);
        plan.detection_probability = noise.between(0.7, 0.98);
        plan.clutter_per_scan = noise.between(3.0, 10.0);
        plan.speed_sigma_mps = noise.between(0.1, 0.4) * plan.speed();
        plan.turn_sigma = noise.between(0.02, 0.08);
        plan
    }

    /// The same world with the sensor ahead of or behind the pose, within 5 % of the world's size, a little to a side, and
    /// rotated by up to a right angle.
    pub fn mounted(mut self, seed: u64) -> Self {
        let mut noise = stream(seed, 11);
        self.sensor.mounting = Mounting {
            forward_m: noise.between(-0.05, 0.05) * self.extent_m,
            left_m: noise.between(-0.02, 0.02) * self.extent_m,
            yaw_rad: noise.between(-0.5, 0.5) * PI,
        };
        self
    }

    /// The same world with three to seven objects that move on circles, at 0.1 to 1.5 times the vehicle's speed.
    pub fn with_movers(mut self, seed: u64) -> Self {
        let mut noise = stream(seed, 12);
        let count = 3 + (noise.uniform() * 5.0) as usize;
        let half = 0.35 * self.extent_m;
        let mover = |_| {
            let way = if noise.happens(0.5) { 1.0 } else { -1.0 };
            Mover {
                centre_m: [noise.between(-half, half), noise.between(-half, half)],
                radius_m: noise.between(0.06, 0.2) * self.extent_m,
                speed_mps: way * exp(noise.between(log(0.1), log(1.5))) * self.speed(),
                phase_rad: noise.between(0.0, 2.0 * PI),
            }
        };
        self.movers = (0..count).map(mover).collect();
        self
    }

    /// Mean speed, m/s: the size of the world in 24 s.
    fn speed(&self) -> f64 {
        self.extent_m / 24.0
    }

    fn drawn(noise: &mut Noise) -> Self {
        let extent = EXTENTS_M[(noise.uniform() * EXTENTS_M.len() as f64) as usize];
        let range_max_m = noise.between(0.25, 0.6) * extent;
        let view = if noise.happens(0.3) { 2.0 * PI } else { noise.between(2.4, 2.0 * PI) };
        let vehicle = if noise.happens(0.5) {
            Vehicle::Ackermann {
                wheelbase_m: 0.03 * extent,
                encoder_offset_m: 0.008 * extent,
                sensor_forward_m: noise.between(0.0, 0.04) * extent,
                sensor_left_m: noise.between(-0.01, 0.01) * extent,
            }
        } else {
            Vehicle::UnicycleArc
        };
        let mut plan = Self {
            extent_m: extent,
            vehicle,
            sensor: Sensor {
                range_min_m: 0.0,
                range_max_m,
                bearing_min_rad: -view / 2.0,
                bearing_max_rad: view / 2.0,
                mounting: Mounting::NONE,
            },
            controls: Vec::new(),
            landmarks: Vec::new(),
            movers: Vec::new(),
            rows_per_scan: 2 + (noise.uniform() * 4.0) as usize,
            start: [0.0; 3],
            range_sigma_m: noise.between(0.003, 0.012) * range_max_m,
            bearing_sigma_rad: noise.between(0.004, 0.025),
            detection_probability: 1.0,
            clutter_per_scan: 0.0,
            speed_sigma_mps: 0.0,
            turn_sigma: 0.0,
        };
        plan.drive(noise);
        plan.plant(noise);
        plan
    }

    /// Some laps through six to nine corners, with a speed that varies by a fifth.
    fn drive(&mut self, noise: &mut Noise) {
        let corners = 6 + (noise.uniform() * 4.0) as usize;
        let places: Vec<[f64; 2]> = (0..corners)
            .map(|k| {
                let angle = 2.0 * PI * (k as f64 + noise.between(-0.3, 0.3)) / corners as f64;
                let radius = noise.between(0.22, 0.45) * self.extent_m;
                [radius * cos(angle), radius * sin(angle)]
            })
            .collect();
        let towards = |from: [f64; 2], to: [f64; 2]| atan2(to[1] - from[1], to[0] - from[0]);
        self.start = [places[0][0], places[0][1], towards(places[0], places[1])];
        let rows = (noise.between(240.0, 300.0) * ROWS_PER_SECOND) as usize;
        let (speed, sway) = (self.speed(), noise.between(20.0, 60.0));
        // The least radius of turns is 6 % of the world's size.
        let sharpest = 1.0 / (0.06 * self.extent_m);
        let (mut pose, mut next) = (self.start, 1);
        for row in 0..rows {
            let place = places[next % corners];
            if (place[0] - pose[0]).hypot(place[1] - pose[1]) < 0.08 * self.extent_m {
                next += 1;
            }
            let error = wrap(towards([pose[0], pose[1]], places[next % corners]) - pose[2]);
            let speed = speed * (1.0 + 0.2 * sin(2.0 * PI * row as f64 / (sway * ROWS_PER_SECOND)));
            let curvature = (4.0 * error / (0.2 * self.extent_m)).clamp(-sharpest, sharpest);
            let control = self.control(speed, curvature);
            self.controls.push(control);
            pose = self.vehicle.step(pose, [control[0], control[1], 0.0], 1.0 / ROWS_PER_SECOND);
        }
    }

    /// The control for `speed` and a curvature, 1/m.
    fn control(&self, speed: f64, curvature: f64) -> [f64; 2] {
        match self.vehicle {
            Vehicle::Ackermann { wheelbase_m, encoder_offset_m, .. } => {
                [speed * (1.0 - curvature * encoder_offset_m), atan(wheelbase_m * curvature)]
            }
            Vehicle::Unicycle | Vehicle::UnicycleArc | Vehicle::Holonomic => [speed, speed * curvature],
        }
    }

    /// Adds landmarks at a distance from each other and from the path.
    fn plant(&mut self, noise: &mut Noise) {
        let wanted = 15 + (noise.uniform() * 31.0) as usize;
        let path = self.path();
        let half = 0.52 * self.extent_m;
        let far = |place: [f64; 2], from: [f64; 2], share: f64| {
            (place[0] - from[0]).hypot(place[1] - from[1]) > share * self.extent_m
        };
        let mut landmarks: Vec<[f64; 2]> = Vec::new();
        // There is space for far more; the bound limits the time after a change of the shares.
        for _ in 0..10_000 {
            if landmarks.len() == wanted {
                break;
            }
            let place = [noise.between(-half, half), noise.between(-half, half)];
            let free = landmarks.iter().all(|&other| far(place, other, 0.04))
                && path.iter().all(|&[x, y, _]| far(place, [x, y], 0.03));
            if free {
                landmarks.push(place);
            }
        }
        self.landmarks = landmarks;
    }

    pub fn time(&self, row: usize) -> f64 {
        row as f64 / ROWS_PER_SECOND
    }

    /// Poses of the sensor at the start of every row and after the last row.
    pub fn path(&self) -> Vec<[f64; 3]> {
        let mut pose = self.start;
        let mut path = vec![pose];
        for &[speed, turn] in &self.controls {
            pose = self.vehicle.step(pose, [speed, turn, 0.0], 1.0 / ROWS_PER_SECOND);
            path.push(pose);
        }
        path
    }
}
