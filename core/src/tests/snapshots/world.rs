//! A vehicle on a circle among posts, and a walker: the inputs of every test.

use crate::tests::alone::Lidar;
use crate::*;
use nalgebra::Vector2;
use std::vec::Vec;

pub(in crate::tests) type Scratch<T> = DetectorMemory<Vector2<T>, 32>;
pub(in crate::tests) type Eyes<'m, T> = Detector<Lidar<T>, ScanRoom<'m, Vector2<T>>>;

/// The type id of the vehicles here.
pub(in crate::tests) const KIND: u32 = 0x00c0_ffee;
/// Posts, m.
const POSTS: [[f64; 2]; 12] = [
    [6.0, 3.0],
    [2.0, 9.0],
    [-6.0, 6.0],
    [-5.0, -2.0],
    [4.0, -4.0],
    [9.0, 0.0],
    [0.0, 0.5],
    [-9.0, -7.0],
    [7.5, -9.0],
    [0.0, -8.0],
    [-11.0, 2.0],
    [10.0, 10.0],
];

pub(in crate::tests) fn motion<T: Real>() -> Unicycle<T> {
    Unicycle::new(Step::Arc, ControlNoise::white(T::from_f64(0.1), T::from_f64(0.05))).unwrap()
}

pub(in crate::tests) fn lidar<T: Real>() -> Lidar<T> {
    let window = RangeBearingWindow::full_circle(T::from_f64(10.0), T::from_f64(0.9)).unwrap();
    Sensing::range_bearing([T::from_f64(0.1), T::from_f64(0.01)], window, T::from_f64(3.0)).unwrap()
}

pub(in crate::tests) fn detector<T: Real>(scratch: &mut Scratch<T>, moves: bool) -> Eyes<'_, T> {
    let moving = T::from_f64(if moves { 0.002 } else { 0.0 });
    Detector::new(lidar(), Births { of_static: T::from_f64(0.002), of_moving: moving }).unwrap().over(scratch).unwrap()
}

/// The inputs of one step: odometry and a scan.
#[derive(Debug, Clone)]
pub(in crate::tests) struct Inputs<T> {
    pub(in crate::tests) odometry: UnicycleControl<T>,
    pub(in crate::tests) scan: Vec<Vector2<T>>,
}

/// The initial pose of every run.
pub(in crate::tests) fn start<T: Real>() -> PlanarPose<T> {
    PlanarPose::new(T::from_f64(3.0), T::ZERO, T::from_f64(1.5))
}

/// Inputs of a number of steps of 0.1 s.
pub(in crate::tests) fn world<T: Real>(steps: usize) -> Vec<Inputs<T>> {
    let real = T::from_f64;
    let exact = Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap();
    let (mut truth, mut draws) = (start::<T>(), Noise::seeded(7));
    let step = |step: usize| {
        let control = UnicycleControl { speed_mps: T::ONE, rate_radps: real(1.0 / 3.0) };
        truth = exact.propagate(&truth, &control, real(0.1));
        let odometry = UnicycleControl {
            speed_mps: T::ONE + real(0.1) * draws.normal(),
            rate_radps: real(1.0 / 3.0) + real(0.05) * draws.normal(),
        };
        let mut scan = Vec::new();
        let walker = [-8.0 + 0.08 * step as f64 % 16.0, 5.0];
        for [x, y] in POSTS.into_iter().chain([walker]) {
            let (dx, dy) = (real(x) - truth.x_m, real(y) - truth.y_m);
            let range = (dx * dx + dy * dy).sqrt();
            let (off, turned) = (real(0.1) * draws.normal(), real(0.01) * draws.normal());
            if range < real(10.0) && draws.uniform::<T>() < real(0.9) {
                scan.push(Vector2::new(range + off, wrap(dy.atan2(dx) - truth.heading_rad + turned)));
            }
        }
        for _ in 0..3 {
            scan.push(Vector2::new(real(10.0) * draws.uniform(), T::PI * (draws.uniform::<T>() - real(0.5))));
        }
        Inputs { odometry, scan }
    };
    (0..steps).map(step).collect()
}

/// Saves into a new vector.
pub(in crate::tests) fn saved<E: core::fmt::Debug>(
    save: impl FnOnce(&mut dyn FnMut(&[u8]) -> Result<(), SliceEnd>) -> Result<usize, E>,
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let len = save(&mut |chunk| {
        assert!(chunk.len() <= 64 && !chunk.is_empty());
        bytes.extend_from_slice(chunk);
        Ok(())
    });
    assert_eq!(len.unwrap(), bytes.len());
    bytes
}
