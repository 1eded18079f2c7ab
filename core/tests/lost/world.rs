//! Worlds to be carried away in, and worlds full of trouble.

use scphd::Component;
use scphd::models::{RangeBearingLimits, RangeBearingWindow};
use scphd::numerics::nalgebra::Vector2;
use scphd::numerics::{Noise, Symmetric};
use std::f64::consts::{PI, TAU};

/// Time between scans, s.
pub const DT_S: f64 = 0.2;

/// A sensor and how full of landmarks its world is.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    pub range_m: f64,
    /// Half of the view.
    pub half_width_rad: f64,
    /// p_D.
    pub detection: f64,
    /// False measurements a scan.
    pub clutter: f64,
    /// Landmarks a square metre.
    pub density: f64,
}

impl Setting {
    pub const ALL: [Self; 5] = [
        Self { range_m: 15.0, half_width_rad: PI, detection: 0.9, clutter: 2.0, density: 0.017 },
        Self { range_m: 10.0, half_width_rad: PI, detection: 0.8, clutter: 5.0, density: 0.03 },
        Self { range_m: 20.0, half_width_rad: PI, detection: 0.95, clutter: 10.0, density: 0.016 },
        Self { range_m: 18.0, half_width_rad: PI / 2.0, detection: 0.9, clutter: 2.0, density: 0.02 },
        Self { range_m: 12.0, half_width_rad: PI, detection: 0.7, clutter: 1.0, density: 0.02 },
    ];

    /// The view as the filter is told.
    pub fn stated_window(&self) -> RangeBearingWindow<f32> {
        let limits = RangeBearingLimits::full_circle(self.range_m as f32, self.detection as f32);
        RangeBearingWindow::new(RangeBearingLimits { bearing_half_width_rad: self.half_width_rad as f32, ..limits })
            .unwrap()
    }
}

/// What the filter is not told.
#[derive(Debug, Clone, Copy)]
pub struct Trouble {
    pub name: &'static str,
    /// p_D over what is stated.
    pub detection: f64,
    /// Mean time that a landmark stays in sight, s; 0: none hides.
    pub visible_s: f64,
    /// Mean time that it stays hidden, s.
    pub occluded_s: f64,
    /// Share of the scans in bursts of clutter, ten times as much, at most 40. Each lasts 4 s in the mean.
    pub bursts: f64,
    /// The same with part of the view blocked: a sector, in the mean half of all.
    pub blocked: f64,
    /// Whether the vehicle leaves what has landmarks, to return.
    pub leaves: bool,
}

impl Trouble {
    /// None.
    pub const NONE: Self = Self {
        name: "no trouble",
        detection: 1.0,
        visible_s: 0.0,
        occluded_s: 0.0,
        bursts: 0.0,
        blocked: 0.0,
        leaves: false,
    };
    pub const ALL: [Self; 8] = [
        Self::NONE,
        Self { name: "p_D is two thirds of what is stated", detection: 0.67, ..Self::NONE },
        Self { name: "landmarks hide", visible_s: 8.0, occluded_s: 3.0, ..Self::NONE },
        Self { name: "bursts of clutter", bursts: 0.2, ..Self::NONE },
        Self { name: "the view is blocked", blocked: 0.2, ..Self::NONE },
        Self { name: "bursts, and blocked, now and then at once", bursts: 0.2, blocked: 0.2, ..Self::NONE },
        Self { name: "rounds through where there is nothing", leaves: true, ..Self::NONE },
        Self {
            name: "p_D, hiding and rounds",
            detection: 0.67,
            visible_s: 15.0,
            occluded_s: 3.0,
            leaves: true,
            ..Self::NONE
        },
    ];

    /// Whether clutter may burst while the view is blocked.
    pub fn is_double(&self) -> bool {
        self.bursts > 0.0 && self.blocked > 0.0
    }
}

/// A landmark, and whether something hides it.
#[derive(Debug, Clone, Copy)]
struct Landmark {
    at: [f64; 2],
    hidden: bool,
}

/// A world with the vehicle in it.
pub struct World {
    pub setting: Setting,
    trouble: Trouble,
    landmarks: Vec<Landmark>,
    pose: [f64; 3],
    draws: Noise,
    scans: usize,
    burst: bool,
    /// The middle and half the width of what is blocked.
    blocked: Option<[f64; 2]>,
}

/// Landmarks lie in a square of twice this, m; the vehicle goes round a circle in it.
const HALF_SIZE_M: f64 = 34.0;
const SPEED_MPS: f64 = 1.5;
const CIRCLE_M: f64 = 8.0;
/// Landmarks keep this distance, m.
const APART_M: f64 = 1.5;

impl World {
    /// Landmarks as the seed has it; the vehicle stands at zero.
    pub fn new(setting: Setting, trouble: Trouble, seed: u64) -> Self {
        let mut draws = Noise::seeded(seed);
        let count = (setting.density * 4.0 * HALF_SIZE_M * HALF_SIZE_M) as usize;
        let mut landmarks: Vec<Landmark> = Vec::new();
        while landmarks.len() < count {
            let at = [0; 2].map(|_| HALF_SIZE_M * (2.0 * draws.uniform::<f64>() - 1.0));
            let near = |held: &Landmark| (held.at[0] - at[0]).hypot(held.at[1] - at[1]) < APART_M;
            if !landmarks.iter().any(near) {
                landmarks.push(Landmark { at, hidden: false });
            }
        }
        // The filter starts from zero; the circle lies around the middle.
        landmarks.iter_mut().for_each(|landmark| landmark.at[1] += CIRCLE_M);
        Self { setting, trouble, landmarks, pose: [0.0; 3], draws, scans: 0, burst: false, blocked: None }
    }

    /// Another trouble from now on.
    #[allow(dead_code)]
    pub fn set_trouble(&mut self, trouble: Trouble) {
        self.trouble = trouble;
    }

    /// A number below this one.
    pub fn pick(&mut self, below: usize) -> usize {
        (self.draws.uniform::<f64>() * below as f64) as usize
    }

    /// Moves on; what odometry says of it.
    pub fn go(&mut self) -> [f64; 2] {
        self.scans += 1;
        // A round of 180 m in 40 s, half of it where there is nothing.
        let out = self.trouble.leaves && (self.scans / 200) % 2 == 1;
        let (speed, rate) = if out { (4.5, TAU / 40.0) } else { (SPEED_MPS, SPEED_MPS / CIRCLE_M) };
        let (true_speed, true_rate) = (speed + 0.1 * self.normal(), rate + 0.03 * self.normal());
        let heading = self.pose[2] + 0.5 * true_rate * DT_S;
        self.pose[0] += true_speed * DT_S * heading.cos();
        self.pose[1] += true_speed * DT_S * heading.sin();
        self.pose[2] += true_rate * DT_S;
        [speed, rate]
    }

    /// Three to ten metres away, turned anyhow.
    pub fn carry_away(&mut self) {
        let (by, course) = (3.0 + 7.0 * self.draws.uniform::<f64>(), TAU * self.draws.uniform::<f64>());
        self.pose[0] += by * course.cos();
        self.pose[1] += by * course.sin();
        self.pose[2] += TAU * self.draws.uniform::<f64>();
    }

    /// Where the vehicle is.
    pub fn pose(&self) -> [f64; 3] {
        self.pose
    }

    /// All landmarks, surveyed to five centimetres.
    pub fn map(&self) -> Vec<Component<Vector2<f32>>> {
        let component = |(label, landmark): (usize, &Landmark)| Component {
            label: label as u32,
            ln_weight: 0.0,
            mean: Vector2::new(landmark.at[0] as f32, landmark.at[1] as f32),
            covariance: Symmetric::from_diagonal([0.0025; 2]),
        };
        self.landmarks.iter().enumerate().map(component).collect()
    }

    /// How far the vehicle is from there.
    pub fn distance(&self, x_m: f32, y_m: f32) -> f64 {
        (f64::from(x_m) - self.pose[0]).hypot(f64::from(y_m) - self.pose[1])
    }

    /// A scan.
    pub fn look(&mut self) -> Vec<Vector2<f32>> {
        self.bother();
        let Setting { range_m, half_width_rad, detection, clutter, .. } = self.setting;
        let mut scan = Vec::new();
        for index in 0..self.landmarks.len() {
            let Landmark { at, hidden } = self.landmarks[index];
            let [x, y] = [at[0] - self.pose[0], at[1] - self.pose[1]];
            let (range, bearing) = (x.hypot(y), wrap(y.atan2(x) - self.pose[2]));
            let blocked = self.blocked.is_some_and(|[middle, half]| wrap(bearing - middle).abs() < half);
            let in_view = range < range_m && bearing.abs() < half_width_rad && !hidden && !blocked;
            if in_view && self.draws.uniform::<f64>() < detection * self.trouble.detection {
                let (off, aside) = (0.1 * self.normal(), 0.015 * self.normal());
                scan.push(Vector2::new((range + off) as f32, wrap(bearing + aside) as f32));
            }
        }
        let rate = if self.burst { 10.0_f64.min(40.0 / clutter) * clutter } else { clutter };
        for _ in 0..self.poisson(rate) {
            let range = range_m * self.draws.uniform::<f64>();
            let bearing = half_width_rad * (2.0 * self.draws.uniform::<f64>() - 1.0);
            scan.push(Vector2::new(range as f32, bearing as f32));
        }
        scan.truncate(super::MEASUREMENTS);
        scan
    }

    /// What hides, bursts and blocks comes and goes.
    fn bother(&mut self) {
        let Trouble { visible_s, occluded_s, bursts, blocked, .. } = self.trouble;
        for index in 0..self.landmarks.len() {
            let stays_s = if self.landmarks[index].hidden { occluded_s } else { visible_s };
            if stays_s > 0.0 && self.draws.uniform::<f64>() < DT_S / stays_s {
                self.landmarks[index].hidden ^= true;
            }
        }
        let ends = DT_S / 4.0;
        let begins = |share: f64| ends * share / (1.0 - share);
        if self.draws.uniform::<f64>() < if self.burst { ends } else { begins(bursts) } {
            self.burst = !self.burst;
        }
        if self.draws.uniform::<f64>() < if self.blocked.is_some() { ends } else { begins(blocked) } {
            let (middle, half) = (TAU * self.draws.uniform::<f64>(), PI * self.draws.uniform::<f64>());
            self.blocked = if self.blocked.is_some() { None } else { Some([middle, half]) };
        }
    }

    fn normal(&mut self) -> f64 {
        self.draws.normal()
    }

    fn poisson(&mut self, rate: f64) -> usize {
        let (mut left, mut count) = (-rate, 0);
        loop {
            left -= self.draws.uniform::<f64>().max(1e-300).ln();
            if left >= 0.0 {
                return count;
            }
            count += 1;
        }
    }
}

fn wrap(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}
