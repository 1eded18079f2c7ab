//! A drive around a circle among landmarks, generated in advance.

use crate::{Noise, wrap};
use core::f64::consts::TAU;
use nalgebra::Vector2;
use std::vec::Vec;

/// Time between scans, s.
pub(crate) const DT_S: f32 = 0.2;
pub(crate) const RANGE_M: f32 = 15.0;
pub(crate) const DETECTION: f32 = 0.9;
/// Mean number of false measurements in a scan.
pub(crate) const CLUTTER: f32 = 2.0;

/// The data of one scan and the odometry before it.
#[derive(Debug, Clone)]
pub(crate) struct Passage {
    /// Odometry, m/s and rad/s.
    pub(crate) control: [f32; 2],
    pub(crate) scan: Vec<Vector2<f32>>,
    /// True pose at the scan, m, m, rad.
    pub(crate) truth: [f64; 3],
}

pub(crate) struct Drive {
    pub(crate) landmarks: Vec<[f64; 2]>,
    pub(crate) passages: Vec<Passage>,
}

impl Drive {
    pub(crate) fn new(seed: u64, scans: usize) -> Self {
        let mut draws = Noise::seeded(seed);
        let mut landmarks: Vec<[f64; 2]> = Vec::new();
        while landmarks.len() < 40 {
            let [x, y] = [0; 2].map(|_| 24.0 * (2.0 * draws.uniform::<f64>() - 1.0));
            // The vehicle starts at the origin, on the circle.
            if landmarks.iter().all(|held| (held[0] - x).hypot(held[1] - 8.0 - y) > 1.5) {
                landmarks.push([x, y + 8.0]);
            }
        }
        let mut pose = [0.0; 3];
        let passages = (0..scans).map(|_| passage(&landmarks, &mut pose, &mut draws)).collect();
        Self { landmarks, passages }
    }
}

fn passage(landmarks: &[[f64; 2]], pose: &mut [f64; 3], draws: &mut Noise) -> Passage {
    let (dt, control) = (f64::from(DT_S), [1.5, 1.5 / 8.0]);
    let (speed, rate) = (control[0] + 0.1 * draws.normal::<f64>(), control[1] + 0.03 * draws.normal::<f64>());
    let middle = pose[2] + 0.5 * rate * dt;
    *pose = [pose[0] + speed * dt * middle.cos(), pose[1] + speed * dt * middle.sin(), pose[2] + rate * dt];
    let mut scan = Vec::new();
    for landmark in landmarks {
        let (x, y) = (landmark[0] - pose[0], landmark[1] - pose[1]);
        let noise = [0.1 * draws.normal::<f64>(), 0.015 * draws.normal::<f64>()];
        if x.hypot(y) < f64::from(RANGE_M) && draws.uniform::<f32>() < DETECTION {
            let bearing = wrap(y.atan2(x) - pose[2] + noise[1]);
            scan.push(Vector2::new((x.hypot(y) + noise[0]) as f32, bearing as f32));
        }
    }
    // Poisson distribution, from exponential intervals.
    let mut left = f64::from(CLUTTER);
    loop {
        left += draws.uniform::<f64>().max(1e-9).ln();
        if left < 0.0 {
            break;
        }
        let [range, turn] = [0; 2].map(|_| draws.uniform::<f64>());
        scan.push(Vector2::new(f64::from(RANGE_M).mul_add(range, 0.05) as f32, wrap(TAU * turn) as f32));
    }
    scan.truncate(super::MEASUREMENTS);
    Passage { control: control.map(|x| x as f32), scan, truth: *pose }
}
