//! A simulated world: landmarks, targets and a sensor on a circle.

use scphd_log::angle::wrap;
use scphd_log::noise::Noise;
use std::f64::consts::{PI, TAU};

const SCANS_PER_SECOND: f64 = 10.0;

/// Number of false measurements in a scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Clutter {
    /// Poisson distribution with this mean.
    Mean(f64),
    /// Up to this number of measurements, together with detections.
    UpTo(usize),
}

/// Landmarks, targets and the sensor, which sees in all directions, with uniform clutter.
#[derive(Debug, Clone, PartialEq)]
pub struct World {
    /// Positions of the landmarks, m.
    pub landmarks: Vec<[f64; 2]>,
    /// Positions (m) and velocities (m/s) of the targets, which turn back at the sensor's range.
    pub targets: Vec<[[f64; 2]; 2]>,
    /// Radius of the sensor's path around the origin, m; 0: the sensor does not move.
    pub way_radius_m: f64,
    /// Speed of the sensor, m/s.
    pub speed_mps: f64,
    /// Range of the sensor, m.
    pub range_max_m: f64,
    /// p_D.
    pub detection: f64,
    /// False measurements.
    pub clutter: Clutter,
}

impl World {
    /// Standard deviation of a range, m.
    pub const RANGE_SIGMA_M: f64 = 0.25;
    /// Standard deviation of a bearing, rad.
    pub const BEARING_SIGMA_RAD: f64 = 0.5 * PI / 180.0;

    /// `count` landmarks in a square around the origin, at least `apart_m` from each other.
    pub fn scattered(count: usize, side_m: f64, apart_m: f64, seed: u64) -> Vec<[f64; 2]> {
        let mut noise = Noise::new(seed);
        let mut places: Vec<[f64; 2]> = Vec::with_capacity(count);
        while places.len() < count {
            let mut coordinate = || noise.between(-0.5 * side_m, 0.5 * side_m);
            let place = [coordinate(), coordinate()];
            if places.iter().all(|other| distance(*other, place) >= apart_m) {
                places.push(place);
            }
        }
        places
    }

    /// λ, the mean number of false measurements.
    pub fn clutter_mean(&self) -> f64 {
        match self.clutter {
            Clutter::Mean(mean) => mean,
            Clutter::UpTo(all) => (all as f64 - self.detection * self.in_view() as f64).max(0.1),
        }
    }

    /// Number of landmarks and targets in view from the origin.
    pub fn in_view(&self) -> usize {
        let places = self.landmarks.iter().chain(self.targets.iter().map(|[place, _]| place));
        places.filter(|place| distance(**place, [0.0; 2]) <= self.range_max_m).count()
    }

    /// The pose (x m, y m, heading rad) after this number of scans.
    fn pose(&self, scans: u32) -> [f64; 3] {
        if self.way_radius_m == 0.0 {
            return [0.0; 3];
        }
        let turned = f64::from(scans) / SCANS_PER_SECOND * self.speed_mps / self.way_radius_m;
        let (sine, cosine) = turned.sin_cos();
        [self.way_radius_m * cosine, self.way_radius_m * sine, wrap(turned + 0.5 * PI)]
    }
}

/// The inputs of a filter at a time.
#[derive(Debug, Clone, PartialEq)]
pub struct Input {
    /// True pose at the scan: x m, y m, heading rad.
    pub pose: [f64; 3],
    /// Speed, m/s, and turn rate, rad/s, since the last scan.
    pub control: [f64; 2],
    /// Time since the last scan, s.
    pub dt_s: f64,
    /// Range (m) and bearing (rad) of every measurement.
    pub measurements: Vec<[f64; 2]>,
}

/// A sequence of scans in a world.
#[derive(Debug)]
pub struct Course {
    world: World,
    noise: Noise,
    scans: u32,
}

impl Course {
    /// Starts with the noise of `seed`.
    pub fn new(world: World, seed: u64) -> Self {
        Self { world, noise: Noise::new(seed), scans: 0 }
    }

    pub fn world(&self) -> &World {
        &self.world
    }

    pub fn start(&self) -> [f64; 3] {
        self.world.pose(0)
    }

    /// The next scan and the control before it.
    pub fn advance(&mut self) -> Input {
        let dt_s = 1.0 / SCANS_PER_SECOND;
        self.scans = self.scans.wrapping_add(1);
        let range_max_m = self.world.range_max_m;
        for [place, velocity] in &mut self.world.targets {
            let outward = place[0] * velocity[0] + place[1] * velocity[1] > 0.0;
            if outward && distance(*place, [0.0; 2]) > 0.95 * range_max_m {
                *velocity = velocity.map(|v| -v);
            }
            *place = [place[0] + velocity[0] * dt_s, place[1] + velocity[1] * dt_s];
        }
        let pose = self.world.pose(self.scans);
        let measurements = self.measure(pose);
        let World { way_radius_m, speed_mps, .. } = self.world;
        let control = if way_radius_m > 0.0 { [speed_mps, speed_mps / way_radius_m] } else { [0.0; 2] };
        Input { pose, control, dt_s, measurements }
    }

    fn measure(&mut self, [x, y, heading]: [f64; 3]) -> Vec<[f64; 2]> {
        let Self { world, noise, .. } = self;
        let mut measurements = Vec::new();
        for place in world.landmarks.iter().chain(world.targets.iter().map(|[place, _]| place)) {
            let range = distance(*place, [x, y]);
            if range <= world.range_max_m && noise.happens(world.detection) {
                let bearing = (place[1] - y).atan2(place[0] - x) - heading;
                let range = (range + World::RANGE_SIGMA_M * noise.normal()).abs();
                measurements.push([range, wrap(bearing + World::BEARING_SIGMA_RAD * noise.normal())]);
            }
        }
        let clutter = match world.clutter {
            Clutter::Mean(mean) => noise.poisson(mean),
            Clutter::UpTo(all) => all.saturating_sub(measurements.len()),
        };
        for _ in 0..clutter {
            measurements.push([noise.between(0.0, world.range_max_m), noise.between(-PI, -PI + TAU)]);
        }
        noise.shuffle(&mut measurements);
        if let Clutter::UpTo(all) = world.clutter {
            measurements.truncate(all);
        }
        measurements
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
