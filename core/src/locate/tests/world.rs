//! Random places, and drives through them.

use crate::*;
use nalgebra::{SVector, Vector2};
use std::boxed::Box;
use std::vec::Vec;

pub(super) const FEATURES: usize = 96;
type Joint = JointState<PlanarPose<f32>, Vector2<f32>, FEATURES, { joint_numbers(3, 2, FEATURES) }, 64>;
pub(super) type Slam<'s> = JointSlam<'s, Unicycle<f32>, Vector2<f32>>;
pub(super) type Radar = Detector<Sensing<RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>>>;
pub(super) type Map = Vec<Component<Vector2<f32>>>;

/// Seconds between two rows of odometry.
const ROW_S: f64 = 0.1;

/// A place, and what drives in it.
#[derive(Debug, Clone)]
pub(super) struct World {
    pub(super) extent_m: f64,
    pub(super) landmarks: Vec<[f64; 2]>,
    range_m: f64,
    half_view_rad: f64,
    detection: f64,
    clutter: f64,
    range_sigma_m: f64,
    bearing_sigma_rad: f64,
    speed_sigma_mps: f64,
    turn_sigma_radps: f64,
    rows_per_scan: usize,
}

/// A vehicle on its way from corner to corner.
pub(super) struct Drive<'w> {
    world: &'w World,
    pub(super) pose: PlanarPose<f64>,
    corner: [f64; 2],
    draws: Noise,
}

fn between(draws: &mut Noise, low: f64, high: f64) -> f64 {
    low + (high - low) * draws.uniform::<f64>()
}

fn somewhere(draws: &mut Noise, extent: f64) -> [f64; 2] {
    [0; 2].map(|_| extent * draws.uniform::<f64>())
}

impl World {
    /// 12, 36 or 96 m wide, 15 to 45 landmarks, a view of 6 to 40 % of it, p_D from 0.7 to 0.95, up to five false detections a scan. The
    /// vehicle crosses it in 24 s, and a scan comes with as many rows of odometry as `rows` says, ten of which are a second.
    pub(super) fn of(seed: u64, rows: [f64; 2]) -> Self {
        let mut draws = Noise::seeded(seed);
        let extent_m = [12.0, 36.0, 96.0][(3.0 * draws.uniform::<f64>()) as usize];
        let landmarks = between(&mut draws, 15.0, 45.99) as usize;
        let view = if draws.uniform::<f64>() < 0.3 { 1.0 } else { between(&mut draws, 0.38, 1.0) };
        let share = between(&mut draws, 0.06, 0.4);
        let half_view_rad = view * core::f64::consts::PI;
        let range_m = extent_m * (share / half_view_rad).sqrt();
        Self {
            extent_m,
            landmarks: (0..landmarks).map(|_| somewhere(&mut draws, extent_m)).collect(),
            range_m,
            half_view_rad,
            detection: between(&mut draws, 0.7, 0.95),
            clutter: between(&mut draws, 0.1, 5.0),
            range_sigma_m: range_m * between(&mut draws, 0.003, 0.012),
            bearing_sigma_rad: between(&mut draws, 0.004, 0.025),
            speed_sigma_mps: extent_m / 24.0 * between(&mut draws, 0.05, 0.2),
            turn_sigma_radps: between(&mut draws, 0.005, 0.05),
            rows_per_scan: between(&mut draws, rows[0], rows[1] + 0.99) as usize,
        }
    }

    /// The same place with a share of its landmarks gone, and as many new ones.
    pub(super) fn changed(&self, seed: u64, share: f64) -> Self {
        let mut draws = Noise::seeded(seed ^ 0x5eed);
        let mut changed = self.clone();
        for landmark in &mut changed.landmarks {
            let place = somewhere(&mut draws, self.extent_m);
            if draws.uniform::<f64>() < share {
                *landmark = place;
            }
        }
        changed
    }

    /// The same vehicle in another place.
    pub(super) fn elsewhere(&self, seed: u64) -> Self {
        self.changed(seed ^ 0x0ff, 1.1)
    }

    pub(super) fn radar(&self) -> Radar {
        let window = RangeBearingWindow::new(RangeBearingLimits {
            bearing_half_width_rad: self.half_view_rad as f32,
            bearing_edge_rad: if self.half_view_rad < core::f64::consts::PI { 0.03 } else { 0.0 },
            range_edge_m: 0.03 * self.range_m as f32,
            ..RangeBearingLimits::full_circle(self.range_m as f32, self.detection as f32)
        })
        .unwrap();
        let sensing = Sensing::range_bearing(
            [self.range_sigma_m as f32, self.bearing_sigma_rad as f32],
            window,
            self.clutter as f32,
        )
        .unwrap();
        Detector::new(sensing, Births::of_static(0.3 / window.measure())).unwrap()
    }

    pub(super) fn drive(&self, seed: u64) -> Drive<'_> {
        let mut draws = Noise::seeded(seed ^ 0xd71e);
        let [x, y] = somewhere(&mut draws, 0.8 * self.extent_m).map(|at| at + 0.1 * self.extent_m);
        let pose = PlanarPose::new(x, y, wrap(core::f64::consts::TAU * draws.uniform::<f64>()));
        let corner = somewhere(&mut draws, self.extent_m);
        Drive { world: self, pose, corner, draws }
    }

    /// The map that the filter makes on a drive of so many seconds.
    pub(super) fn mapped(&self, seed: u64, seconds: f64) -> Map {
        let mut room = room();
        let mut slam = slam(self, &mut room);
        let mut drive = self.drive(seed);
        slam.reset(single(&drive.pose)).unwrap();
        for _ in 0..(seconds / ROW_S) as usize / self.rows_per_scan {
            drive.scan(&mut slam, Slam::scan);
        }
        slam.features().collect()
    }
}

pub(super) fn single(pose: &PlanarPose<f64>) -> PlanarPose<f32> {
    PlanarPose::new(pose.x_m as f32, pose.y_m as f32, pose.heading_rad as f32)
}

pub(super) fn room() -> Box<Joint> {
    Box::new(Joint::new())
}

pub(super) fn slam<'s>(world: &World, room: &'s mut Joint) -> Slam<'s> {
    let noise = ControlNoise {
        interval_s: ROW_S as f32,
        ..ControlNoise::white(world.speed_sigma_mps as f32, world.turn_sigma_radps as f32)
    };
    JointSlam::new(Unicycle::new(Step::Arc, noise).unwrap(), JointConfig::strict(), room).unwrap()
}

/// What a filter does with a scan.
pub(super) type Take<'s> = fn(&mut Slam<'s>, &Radar, &[SVector<f32, 2>]) -> Result<JointReport<f32>, ScanError>;

impl Drive<'_> {
    /// Puts the vehicle down somewhere else.
    pub(super) fn kidnap(&mut self) {
        let extent = self.world.extent_m;
        let [x, y] = somewhere(&mut self.draws, 0.8 * extent).map(|at| at + 0.1 * extent);
        self.pose = PlanarPose::new(x, y, wrap(core::f64::consts::TAU * self.draws.uniform::<f64>()));
    }

    /// Drives to the next scan.
    pub(super) fn scan<'s>(&mut self, slam: &mut Slam<'s>, take: Take<'s>) {
        let world = self.world;
        let exact = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
        for _ in 0..world.rows_per_scan {
            let control = self.control();
            self.pose = exact.propagate(&self.pose, &control, ROW_S);
            let told = UnicycleControl {
                speed_mps: (control.speed_mps + world.speed_sigma_mps * self.draws.normal::<f64>()) as f32,
                rate_radps: (control.rate_radps + world.turn_sigma_radps * self.draws.normal::<f64>()) as f32,
            };
            slam.predict(&told, ROW_S as f32).unwrap();
        }
        let seen = self.detections();
        take(slam, &world.radar(), &seen).unwrap();
    }

    /// Towards the corner, in turns that are not too sharp.
    fn control(&mut self) -> UnicycleControl<f64> {
        let world = self.world;
        let speed = world.extent_m / 24.0;
        let to_corner = |pose: &PlanarPose<f64>, [x, y]: [f64; 2]| (x - pose.x_m, y - pose.y_m);
        let (mut dx, mut dy) = to_corner(&self.pose, self.corner);
        if dx.hypot(dy) < 0.15 * world.extent_m {
            self.corner = somewhere(&mut self.draws, 0.8 * world.extent_m).map(|at| at + 0.1 * world.extent_m);
            (dx, dy) = to_corner(&self.pose, self.corner);
        }
        let aside = wrap(dy.atan2(dx) - self.pose.heading_rad);
        UnicycleControl { speed_mps: speed, rate_radps: (2.0 * aside).clamp(-0.5, 0.5) }
    }

    fn detections(&mut self) -> Vec<SVector<f32, 2>> {
        let (world, pose) = (self.world, self.pose);
        let mut seen = Vec::new();
        for [x, y] in &world.landmarks {
            let (dx, dy) = (x - pose.x_m, y - pose.y_m);
            let (range, bearing) = (dx.hypot(dy), wrap(dy.atan2(dx) - pose.heading_rad));
            let detected = self.draws.uniform::<f64>() < world.detection;
            let noise = [self.draws.normal::<f64>(), self.draws.normal::<f64>()];
            if detected && range < world.range_m && bearing.abs() < world.half_view_rad {
                let range = (range + world.range_sigma_m * noise[0]).abs().max(1e-3);
                seen.push(Vector2::new(range as f32, wrap(bearing + world.bearing_sigma_rad * noise[1]) as f32));
            }
        }
        // Poisson, by the times between events.
        let mut until = -self.draws.uniform::<f64>().max(1e-12).ln();
        while until < world.clutter {
            let range = (world.range_m * self.draws.uniform::<f64>()).max(1e-3);
            let bearing = world.half_view_rad * (2.0 * self.draws.uniform::<f64>() - 1.0);
            seen.push(Vector2::new(range as f32, bearing as f32));
            until -= self.draws.uniform::<f64>().max(1e-12).ln();
        }
        seen.truncate(64);
        seen
    }
}
