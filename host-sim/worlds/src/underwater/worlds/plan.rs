//! Plan of a world, before measurements are simulated.

use super::ground::{Feature, Ground};
use super::optics::Optics;
use super::way::{self, Clock, Course, Vehicle};
use crate::scenario::worlds::stream;
use libm::{exp, log, sin};
use nalgebra::Vector3;
use scphd_log::noise::Noise;
use std::f64::consts::PI;

/// Least and greatest size of a world, m.
const SIZES_M: [f64; 2] = [4.0, 40.0];
/// Range of durations of the drive, s.
const DURATION_S: [f64; 2] = [150.0, 240.0];
/// Range of the mean number of features in a frame; greatest and least number of features.
const SHOWN: [f64; 2] = [6.0, 14.0];
const MOST_FEATURES: usize = 160;
const LEAST_FEATURES: usize = 30;
/// Widths and heights of images, px.
const SIZES_PX: [[f64; 2]; 4] = [[640.0, 480.0], [800.0, 600.0], [1024.0, 768.0], [1280.0, 960.0]];

/// Task of the vehicle in a world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Task {
    /// Two crossed lawnmowers over relief.
    Lawnmower,
    /// Circles around a structure.
    Orbit,
    /// Loops over relief, up and down.
    Loops,
}

/// Iron that deflects the compass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Iron {
    pub place: [f64; 2],
    pub pull_rad: f64,
}

#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub size_m: f64,
    pub optics: Optics,
    pub row_s: f64,
    pub rows_per_scan: usize,
    pub rows_per_velocity: usize,
    pub way: Vec<Vehicle>,
    pub features: Vec<Feature>,
    pub irons: Vec<Iron>,
    pub speed_mps: f64,
    pub pixel_sigma: f64,
    pub velocity_sigma_mps: f64,
    pub yaw_rate_sigma_radps: f64,
    pub z_sigma_m: f64,
    pub tilt_sigma_rad: f64,
    pub detection_probability: f64,
    /// Mean number of independent false pairs a frame.
    pub clutter_per_scan: f64,
}

/// Trajectory, ground and camera of a world, before features are added.
struct Drive {
    course: Course,
    ground: Ground,
    optics: Optics,
}

impl Plan {
    /// A world with good instruments, whose log has their data sheets.
    pub fn data_sheet(seed: u64) -> Self {
        let mut plan = Self::drawn(&mut stream(seed, 21));
        let mut noise = stream(seed, 22);
        plan.velocity_sigma_mps = noise.between(0.01, 0.05) * plan.speed_mps;
        plan.yaw_rate_sigma_radps = noise.between(0.003, 0.01);
        plan.z_sigma_m = noise.between(0.0005, 0.002) * plan.size_m;
        plan.tilt_sigma_rad = noise.between(0.2, 0.5) * PI / 180.0;
        plan.detection_probability = 0.85;
        plan.clutter_per_scan = exp(noise.between(log(0.2), log(3.0)));
        plan
    }

    /// A world with poor instruments and all errors stated.
    pub fn exact(seed: u64) -> Self {
        let mut plan = Self::drawn(&mut stream(seed, 23));
        let mut noise = stream(seed, 24);
        plan.velocity_sigma_mps = noise.between(0.1, 0.3) * plan.speed_mps;
        plan.yaw_rate_sigma_radps = noise.between(0.02, 0.06);
        plan.z_sigma_m = noise.between(0.001, 0.004) * plan.size_m;
        plan.detection_probability = noise.between(0.7, 0.95);
        plan.clutter_per_scan = noise.between(3.0, 10.0);
        plan
    }

    fn drawn(noise: &mut Noise) -> Self {
        let size_m = exp(noise.between(log(SIZES_M[0]), log(SIZES_M[1])));
        let task = match noise.uniform() {
            share if share < 0.4 => Task::Lawnmower,
            share if share < 0.7 => Task::Orbit,
            _ => Task::Loops,
        };
        // 5 to 20 rows a second, 1 to 10 frames, 2 to 5 velocities: intervals are rounded down to rows, so that rates may be up
        // to twice as high.
        let rows_per_second = exp(noise.between(log(5.0), log(20.0)));
        let frames = exp(noise.between(0.0, log(rows_per_second.min(10.0))));
        let velocities = noise.between(2.0, 5.0);
        let rows_per = |rate: f64| ((rows_per_second / rate) as usize).max(1);
        let row_s = 1.0 / rows_per_second;
        let rows = (noise.between(DURATION_S[0], DURATION_S[1]) * rows_per_second) as usize;
        let clock = Clock { rows: rows + 1, row_s, size_m };
        let pixel_sigma = noise.between(0.7, 2.0);
        let Drive { course, ground, optics } = Drive::drawn(task, clock, pixel_sigma, noise);
        let way = way::driven(&course, row_s, noise);
        let speed_mps = way.iter().map(|vehicle| vehicle.velocity_mps.norm()).sum::<f64>() / way.len() as f64;
        let irons = (0..3)
            .map(|_| {
                let [x, y] = [(); 2].map(|()| noise.between(-0.5, 0.5) * size_m);
                Iron { place: [x, y], pull_rad: noise.between(5.0, 15.0) * PI / 180.0 }
            })
            .collect();
        let features = planted(&ground, &optics, &way, noise);
        let rows_per_scan = rows_per(frames);
        Self {
            size_m,
            optics,
            row_s,
            rows_per_scan,
            rows_per_velocity: rows_per(velocities),
            way,
            features,
            irons,
            speed_mps,
            pixel_sigma,
            velocity_sigma_mps: 0.0,
            yaw_rate_sigma_radps: 0.0,
            z_sigma_m: 0.0,
            tilt_sigma_rad: 0.0,
            detection_probability: 1.0,
            clutter_per_scan: 0.0,
        }
    }

    pub fn time(&self, row: usize) -> f64 {
        row as f64 * self.row_s
    }

    /// Greatest change of a velocity in a second, along any axis, as a random walk, (m/s)/√s.
    pub fn velocity_walk(&self) -> f64 {
        let second = (1.0 / self.row_s) as usize;
        let changes = self.way.iter().zip(self.way.iter().skip(second));
        changes.map(|(from, to)| (to.velocity_mps - from.velocity_mps).amax()).fold(0.0, f64::max)
    }
}

impl Drive {
    fn drawn(task: Task, clock: Clock, pixel_sigma: f64, noise: &mut Noise) -> Self {
        let size_m = clock.size_m;
        let duration = clock.rows as f64 * clock.row_s;
        let degrees = PI / 180.0;
        let down_rad = match task {
            Task::Lawnmower if noise.happens(0.5) => 0.5 * PI,
            Task::Lawnmower => noise.between(45.0, 70.0) * degrees,
            Task::Orbit => noise.between(0.0, 25.0) * degrees,
            Task::Loops if noise.happens(0.3) => noise.between(10.0, 25.0) * degrees,
            Task::Loops => noise.between(40.0, 90.0) * degrees,
        };
        let floor_m = -noise.between(5.0, 30.0) - size_m;
        if task == Task::Orbit {
            let (inner, radius_m) = (noise.between(0.12, 0.2) * size_m, noise.between(0.38, 0.48) * size_m);
            let tall_m = noise.between(0.3, 0.6) * size_m;
            let heights = [0.3, 0.8].map(|share| floor_m + share * tall_m);
            let course = way::orbit(clock, radius_m, heights, noise);
            let ground = Ground::structure(size_m, floor_m, inner, tall_m, noise);
            let mut optics = optics_of(radius_m - inner, down_rad, pixel_sigma, size_m, noise);
            // At most the distance of the centre of the structure.
            optics.depth_m[1] = optics.depth_m[1].min(radius_m);
            return Self { course, ground, optics };
        }
        // A height above the floor at which the camera sees it within half of the world.
        let above_m = (noise.between(0.15, 0.3) * size_m).min(0.5 * size_m * sin(down_rad));
        let ground = Ground::relief(size_m, floor_m, 0.15 * above_m, noise);
        let (places, times, swing) = if task == Task::Lawnmower {
            (way::lawnmower(size_m, noise), 1.15, 0.05)
        } else {
            (way::loops(size_m, noise), noise.between(2.0, 3.0), noise.between(0.15, 0.3))
        };
        let speed_mps = times * way::length_m(&places) / duration;
        let pace = noise.between(0.08, 0.15);
        let height = |t_s: f64, _place: [f64; 2]| floor_m + above_m * (1.0 + swing * sin(pace * t_s));
        let course = way::steered(clock, &places, speed_mps, height);
        let optics = optics_of(above_m / sin(down_rad), down_rad, pixel_sigma, size_m, noise);
        Self { course, ground, optics }
    }
}

/// A camera for features at about `depth_m`.
fn optics_of(depth_m: f64, down_rad: f64, pixel_sigma: f64, size_m: f64, noise: &mut Noise) -> Optics {
    let size_px = SIZES_PX[(noise.uniform() * SIZES_PX.len() as f64) as usize];
    let focal_px = noise.between(0.7, 1.2) * size_px[0];
    let disparity = noise.between(0.04, 0.1) * size_px[0];
    Optics {
        focal_px,
        baseline_m: disparity * depth_m / focal_px,
        size_px,
        depth_m: [0.4 * depth_m, 1.7 * depth_m],
        row_tolerance_px: 6.0 * pixel_sigma,
        down_rad,
        place_m: Vector3::new(noise.between(-0.01, 0.03), noise.between(-0.01, 0.01), noise.between(-0.02, 0.0))
            * size_m,
    }
}

/// Enough features for the wanted number in a frame.
fn planted(ground: &Ground, optics: &Optics, way: &[Vehicle], noise: &mut Noise) -> Vec<Feature> {
    let mut features: Vec<Feature> = (0..MOST_FEATURES).map(|_| ground.feature(noise)).collect();
    let projections = optics.projections();
    let looked: Vec<&Vehicle> = way.iter().step_by((way.len() / 100).max(1)).collect();
    let seen_by = |vehicle: &Vehicle| {
        let turned = vehicle.rotation();
        let seen = |feature: &&Feature| {
            optics.pair(&projections, &turned.tr_mul(&(feature.position - vehicle.position))).is_some()
        };
        features.iter().filter(seen).count()
    };
    let shown = looked.iter().map(|vehicle| seen_by(vehicle)).sum::<usize>() as f64 / looked.len() as f64;
    let wanted = noise.between(SHOWN[0], SHOWN[1]) / shown.max(1e-3) * MOST_FEATURES as f64;
    features.truncate((wanted as usize).clamp(LEAST_FEATURES, MOST_FEATURES));
    features
}
