//! A yard with walls and round posts, and a rotating lidar, simulated beam by beam on a moving vehicle.
#![allow(dead_code)]

use scphd_lidar::{Packet, Reading, Sweep};
use std::f64::consts::TAU;

/// Random numbers that are the same on every machine.
pub struct Draws(u64);

impl Draws {
    pub fn seeded(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x1234_5678_9abc_def1)
    }

    /// A uniform number from 0 to 1.
    pub fn uniform(&mut self) -> f64 {
        // splitmix64
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        let (radius, angle) = ((-2.0 * (1.0 - self.uniform()).ln()).sqrt(), TAU * self.uniform());
        radius * angle.cos()
    }
}

/// The simulated yard.
pub struct World {
    /// Axes of the posts, m.
    pub posts: Vec<[f64; 2]>,
    pub radius_m: f64,
    /// Intensity of posts; that of walls is 90.
    pub intensity: u8,
    /// Half sides of the rectangle of the walls, m.
    pub walls_m: [f64; 2],
}

impl World {
    /// Random posts, at least 1 m from each other and from the walls, where `is_free` is true.
    pub fn random(draws: &mut Draws, posts: usize, radius_m: f64, is_free: impl Fn([f64; 2]) -> bool) -> Self {
        let walls_m = [9.0, 7.0];
        let mut world = Self { posts: Vec::new(), radius_m, intensity: 90, walls_m };
        while world.posts.len() < posts {
            let place = walls_m.map(|half| (half - 1.0) * (2.0 * draws.uniform() - 1.0));
            let apart = |post: &[f64; 2]| (post[0] - place[0]).hypot(post[1] - place[1]) > 1.0;
            if is_free(place) && world.posts.iter().all(apart) {
                world.posts.push(place);
            }
        }
        world
    }

    /// Length of a ray, m, and the post at its end, if any.
    pub fn ray(&self, [x, y]: [f64; 2], direction_rad: f64) -> (f64, Option<usize>) {
        let (dx, dy) = (direction_rad.cos(), direction_rad.sin());
        let wall = |at: f64, step: f64, half: f64| {
            if step.abs() < 1e-12 { f64::INFINITY } else { (half.copysign(step) - at) / step }
        };
        let mut nearest = (wall(x, dx, self.walls_m[0]).min(wall(y, dy, self.walls_m[1])), None);
        for (post, [px, py]) in self.posts.iter().enumerate() {
            let (along, aside) = ((px - x) * dx + (py - y) * dy, (py - y) * dx - (px - x) * dy);
            if along > 0.0 && aside.abs() < self.radius_m {
                let range = along - (self.radius_m * self.radius_m - aside * aside).sqrt();
                if range < nearest.0 {
                    nearest = (range, Some(post));
                }
            }
        }
        nearest
    }

    /// Whether nothing occludes a part of a post, or is so near its edge that an adjacent beam would hit it.
    pub fn is_in_sight(&self, from: [f64; 2], post: usize) -> bool {
        let [dx, dy] = [self.posts[post][0] - from[0], self.posts[post][1] - from[1]];
        let (bearing, half) = (dy.atan2(dx), (self.radius_m / dx.hypot(dy)).asin());
        let range = dx.hypot(dy);
        (-20..=20).all(|k| {
            let aside = f64::from(k) / 20.0 * (half + 3.5 * STEP_RAD);
            let (reached, met) = self.ray(from, bearing + aside);
            met == Some(post) || reached > range
        })
    }
}

/// Angle between beams at 10 Hz, rad.
pub const STEP_RAD: f64 = 0.8 * TAU / 360.0;
/// Points per second.
pub const RATE_HZ: f64 = 4500.0;
/// Standard deviation of a range, m.
pub const SIGMA_M: f64 = 0.01;
/// Share of beams with a return.
pub const RETURNED: f64 = 0.99;
/// Greatest range of the lidar, m.
const REACH_M: f64 = 12.0;

/// The lidar, at 10 Hz within a percent.
pub struct Lidar {
    pub time_s: f64,
    /// Direction clockwise from the arrow, degrees.
    angle_deg: f64,
    pub draws: Draws,
}

impl Lidar {
    pub fn started(mut draws: Draws) -> Self {
        Self { time_s: 0.0, angle_deg: 360.0 * draws.uniform(), draws }
    }

    /// The next packet, with the pose of the vehicle (x, y, m; heading, rad) at the time of each beam.
    pub fn packet(&mut self, world: &World, pose: impl Fn(f64) -> [f64; 3]) -> Packet {
        let step = 0.8 * (1.0 + 0.01 * (0.37 * self.time_s).sin());
        let cdeg = |angle: f64| ((100.0 * angle).round() as u32 % 36_000) as u16;
        let start_cdeg = cdeg(self.angle_deg);
        let readings = core::array::from_fn(|_| {
            let [x, y, heading] = pose(self.time_s);
            let (range, post) = world.ray([x, y], heading - self.angle_deg.to_radians());
            let noisy = range + SIGMA_M * self.draws.normal();
            let returns = self.draws.uniform() < RETURNED && noisy < REACH_M;
            self.angle_deg += step;
            self.time_s += 1.0 / RATE_HZ;
            let intensity = if post.is_some() { world.intensity } else { 90 };
            if returns { Reading { range_mm: (1000.0 * noisy).round() as u16, intensity } } else { Reading::default() }
        });
        let end_cdeg = cdeg(self.angle_deg - step);
        self.angle_deg %= 360.0;
        let speed_degps = (step * RATE_HZ).round() as u16;
        Packet { speed_degps, start_cdeg, readings, end_cdeg, time_ms: ((1000.0 * self.time_s) as u64 % 30_000) as u16 }
    }
}

/// The angle wrapped to [−π, π].
pub fn wrap(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// A scan by another lidar, with the pose of the vehicle at the time of each beam and the noise of the lidar above; a missing
/// return is `empty_m`.
pub fn scan(
    world: &World,
    draws: &mut Draws,
    sweep: &Sweep,
    beams: usize,
    empty_m: f32,
    pose: impl Fn(f64) -> [f64; 3],
) -> Vec<f32> {
    let time = |beam: usize| f64::from(sweep.duration_s) * beam as f64 / (beams - 1) as f64;
    let beam = |beam: usize| {
        let [x, y, heading] = pose(time(beam));
        let bearing = f64::from(sweep.start_rad) + f64::from(sweep.increment_rad) * beam as f64;
        let noisy = world.ray([x, y], heading + bearing).0 + SIGMA_M * draws.normal();
        if draws.uniform() < RETURNED && noisy < REACH_M { noisy as f32 } else { empty_m }
    };
    (0..beams).map(beam).collect()
}
