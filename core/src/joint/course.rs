//! A vehicle on a circle among landmarks, for tests.

use crate::tests::alone::Lidar;
use crate::*;
use nalgebra::Vector2;
use std::vec::Vec;

pub(super) fn motion<T: Real>() -> Unicycle<T> {
    Unicycle::new(Step::Arc, ControlNoise::white(T::from_f64(0.1), T::from_f64(0.05))).unwrap()
}

/// A sensor with this clutter per scan.
pub(super) fn lidar<T: Real>(clutter: f64, births: Births<f64>) -> Detector<Lidar<T>> {
    let window = RangeBearingWindow::full_circle(T::from_f64(20.0), T::from_f64(0.9)).unwrap();
    let sensing = Sensing::range_bearing([0.1, 0.01].map(T::from_f64), window, T::from_f64(clutter)).unwrap();
    let [of_static, of_moving] = [births.of_static, births.of_moving].map(T::from_f64);
    Detector::new(sensing, Births { of_static, of_moving }).unwrap()
}

/// A vehicle on a circle of 8 m radius among twelve landmarks, and a person who may walk back and forth over two of them.
pub(super) struct Course {
    pub(super) pose: PlanarPose<f64>,
    draws: Noise,
    t_s: f64,
    walks: bool,
    /// False measurements in a scan.
    clutter: usize,
}

impl Course {
    pub(super) fn new(seed: u64, walks: bool, clutter: usize) -> Self {
        let pose = PlanarPose::new(8.0, 0.0, core::f64::consts::FRAC_PI_2);
        Self { pose, draws: Noise::seeded(seed), t_s: 0.0, walks, clutter }
    }

    pub(super) fn landmark(k: usize) -> Vector2<f64> {
        let angle = k as f64 * core::f64::consts::TAU / 12.0;
        Vector2::new(angle.cos(), angle.sin()) * if k.is_multiple_of(2) { 12.0 } else { 4.0 }
    }

    /// Position of the walker: from (0, 6) over landmark 3 at (0, 4) and landmark 9 at (0, −4) to (0, −6) in 12 s, and
    /// back.
    pub(super) fn walker(&self) -> Vector2<f64> {
        let phase = (self.t_s / 12.0).rem_euclid(2.0);
        Vector2::new(0.0, 6.0 - 12.0 * if phase < 1.0 { phase } else { 2.0 - phase })
    }

    /// The odometry of the next step of 0.1 s, and the scan after it, without the hidden landmarks.
    pub(super) fn step(&mut self, hidden: impl Fn(usize) -> bool) -> (UnicycleControl<f64>, Vec<Vector2<f64>>) {
        let real = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
        self.pose = real.propagate(&self.pose, &UnicycleControl { speed_mps: 2.0, rate_radps: 0.25 }, 0.1);
        self.t_s += 0.1;
        let mut draw = || self.draws.normal::<f64>();
        let odometry = UnicycleControl { speed_mps: 2.0 + 0.1 * draw(), rate_radps: 0.25 + 0.05 * draw() };
        let mut seen = Vec::new();
        let walker = self.walks.then(|| self.walker());
        for (k, at) in (0..12).map(Self::landmark).chain(walker).enumerate() {
            let (dx, dy) = (at.x - self.pose.x_m, at.y - self.pose.y_m);
            let noise = [0.1 * self.draws.normal::<f64>(), 0.01 * self.draws.normal::<f64>()];
            if self.draws.uniform::<f64>() < 0.9 && !hidden(k) {
                seen.push(Vector2::new(dx.hypot(dy) + noise[0], wrap(dy.atan2(dx) - self.pose.heading_rad + noise[1])));
            }
        }
        for _ in 0..self.clutter {
            let (range, turn) = (20.0 * self.draws.uniform::<f64>(), self.draws.uniform::<f64>());
            seen.push(Vector2::new(range.max(0.1), wrap(core::f64::consts::TAU * turn)));
        }
        (odometry, seen)
    }
}
