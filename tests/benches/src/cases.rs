//! The measured cases: two from other projects, and four curves.

use crate::rig::{Case, Rig};
use crate::world::{Clutter, World};
use nalgebra::Vector2;
use scphd::models::{ConstantVelocity, ControlNoise, KnownPose, Step, Unicycle};
use scphd::settings::MovingConfig;
use scphd::storage::{Dynamic, MapMemory, NoMoving, Static};
use scphd::{Births, Config};
use scphd_log::noise::Noise;
use std::f64::consts::TAU;

/// Capacity for components in an update.
const VIEW: usize = 2048;

type Still<const PARTICLES: usize, const PAGES: usize, const MAP_PAGES: usize> =
    MapMemory<Static<Vector2<f32>>, PARTICLES, PAGES, MAP_PAGES, VIEW>;

/// A curve: the time of a scan as a function of one number, with all others fixed.
#[derive(Debug, Clone, Copy)]
pub struct Curve {
    pub name: &'static str,
    /// Description of the number, for the axis.
    pub what: &'static str,
    pub points: &'static [usize],
    /// Constructs the case with this number.
    pub case: fn(usize) -> Box<dyn Case>,
}

pub const CURVES: [Curve; 4] = [
    Curve { name: "map", what: "features in the map", points: &[100, 300, 1000, 3000, 10_000], case: map },
    Curve { name: "measurements", what: "measurements a scan", points: &[5, 10, 20, 50, 100, 200], case: measurements },
    Curve { name: "particles", what: "particles", points: &[8, 32, 128, 512, 1024], case: particles },
    Curve { name: "clutter", what: "false measurements a scan", points: &[0, 5, 20, 50, 100], case: clutter },
];

pub type Make = fn() -> Box<dyn Case>;

/// The cases that are not on a curve.
pub const NAMED: [(&str, Make); 2] = [("rfs_slam_like", rfs_slam_like), ("gmphd_20_targets", gmphd_20_targets)];

/// A slow vehicle with good odometry, so that the filter does not diverge.
fn robot() -> Unicycle<f32> {
    Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.02)).expect("the noise of the odometry")
}

/// About one new feature in a scan of a 15 m circle.
const BIRTHS: Births<f32> = Births::of_static(0.01);

fn config(particles: usize, samples: usize) -> Config<f32> {
    Config { particles, samples, ..Config::default() }
}

/// Pruning threshold that leaves as many components as in RFS-SLAM: components from false measurements are kept for a while.
const RFS_SLAM_PRUNE_WEIGHT: f32 = 1e-4;

/// 200 particles, 50 landmarks, 9.8 measurements in a scan, about 37 components in a map: the default 2-D simulation of RFS-SLAM.
fn rfs_slam_like() -> Box<dyn Case> {
    let world = World {
        landmarks: World::scattered(50, 19.5, 1.0, 3),
        targets: Vec::new(),
        way_radius_m: 3.72,
        speed_mps: 1.0,
        range_max_m: 5.1,
        detection: 0.95,
        clutter: Clutter::Mean(0.3),
    };
    // More than a complete round.
    let config = Config { prune_weight: RFS_SLAM_PRUNE_WEIGHT, ..config(200, 1) };
    Box::new(Rig::new::<Still<200, 4096, 16>, NoMoving, 200, 200>(robot(), BIRTHS, config, world, &[], 320))
}

/// GM-PHD tracking from a known pose: 20 targets, 20 false measurements in a scan.
fn gmphd_20_targets() -> Box<dyn Case> {
    const RANGE_M: f64 = 50.0;
    let mut noise = Noise::new(4);
    let targets = World::scattered(20, 60.0, 5.0, 4).into_iter().map(|place| {
        let direction = noise.between(0.0, TAU);
        [place, [direction.cos(), direction.sin()]]
    });
    let world = World {
        landmarks: Vec::new(),
        targets: targets.collect(),
        way_radius_m: 0.0,
        speed_mps: 0.0,
        range_max_m: RANGE_M,
        detection: 0.95,
        clutter: Clutter::Mean(20.0),
    };
    let moving = MovingConfig {
        motion: ConstantVelocity { acceleration_psd: 0.1, lifetime_s: 100.0 },
        ..MovingConfig::walkers()
    };
    let births = Births { of_static: 0.0, of_moving: 0.01 };
    let config = Config { prune_weight: 1e-5, moving, ..config(1, 1) };
    type Moving = MapMemory<Dynamic<Vector2<f32>>, 1, 128, 64, 1024>;
    Box::new(Rig::new::<Still<1, 64, 32>, Moving, 1, 1>(KnownPose::new(), births, config, world, &[], 100))
}

/// A map of `features`, of which 20 are always in view, and the others never.
fn map(features: usize) -> Box<dyn Case> {
    const IN_VIEW: usize = 20;
    /// Least distance of the other features from the origin, and distance between them, m.
    const BEYOND_M: f64 = 30.0;
    const APART_M: f64 = 3.0;
    let world = World {
        landmarks: World::scattered(IN_VIEW, 10.0, 1.0, 5),
        targets: Vec::new(),
        way_radius_m: 2.0,
        speed_mps: 1.0,
        range_max_m: 15.0,
        detection: 0.95,
        clutter: Clutter::Mean(20.0),
    };
    let mut known = world.landmarks.clone();
    // A grid in rows, in which consecutive features are neighbours.
    let rows = (features as f64).sqrt().ceil() as usize + 2 * (BEYOND_M / APART_M) as usize;
    let grid = (0..rows * rows).map(|k| [k % rows, k / rows].map(|place| (place as f64 - rows as f64 / 2.0) * APART_M));
    let beyond = grid.filter(|place| place[0].hypot(place[1]) > BEYOND_M);
    known.extend(beyond.take(features - IN_VIEW));
    Box::new(Rig::new::<Still<32, 16_384, 2048>, NoMoving, 32, 64>(robot(), BIRTHS, config(32, 2), world, &known, 20))
}

/// Twenty features in view, and clutter up to the number of measurements; if this is below twenty, as many features are detected.
fn measurements(measurements: usize) -> Box<dyn Case> {
    const IN_VIEW: usize = 20;
    let world = World {
        landmarks: World::scattered(IN_VIEW, 16.0, 2.0, 6),
        targets: Vec::new(),
        way_radius_m: 2.0,
        speed_mps: 1.0,
        range_max_m: 15.0,
        detection: 0.95 * (measurements as f64 / IN_VIEW as f64).min(1.0),
        clutter: Clutter::UpTo(measurements),
    };
    let known = world.landmarks.clone();
    Box::new(Rig::new::<Still<32, 4096, 128>, NoMoving, 32, 64>(robot(), BIRTHS, config(32, 2), world, &known, 20))
}

/// 45 landmarks and the clutter of section 5.3.1, one sample for each particle.
fn particles(particles: usize) -> Box<dyn Case> {
    type Memory = Still<1024, 65_535, 128>;
    let config = config(particles, 1);
    Box::new(Rig::new::<Memory, NoMoving, 1024, 1024>(robot(), BIRTHS, config, loop_of_5_3_1(20.0), &[], 100))
}

/// As `particles`, with 32 particles of two samples, for another clutter rate.
fn clutter(mean: usize) -> Box<dyn Case> {
    let world = loop_of_5_3_1(mean as f64);
    Box::new(Rig::new::<Still<32, 4096, 128>, NoMoving, 32, 64>(robot(), BIRTHS, config(32, 2), world, &[], 100))
}

fn loop_of_5_3_1(clutter: f64) -> World {
    World {
        landmarks: World::scattered(45, 50.0, 3.0, 7),
        targets: Vec::new(),
        way_radius_m: 12.0,
        speed_mps: 4.0,
        range_max_m: 15.0,
        detection: 0.95,
        clutter: Clutter::Mean(clutter),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means over these scans: measurements, components of a map, components of its moving part.
    fn means(case: &mut dyn Case, scans: usize) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for _ in 0..scans {
            case.prepare();
            let report = case.scan();
            assert!(report.tightened == 0 && report.lost == 0, "{report:?}");
            let [still, moving] = case.components();
            sums = [sums[0] + report.measurements as f64, sums[1] + still, sums[2] + moving];
        }
        sums.map(|sum| sum / scans as f64)
    }

    #[test]
    fn the_case_of_rfs_slam_has_its_figures() {
        // A complete round: 2π 3.72 m at 0.1 m in a scan.
        let found = means(&mut *rfs_slam_like(), 234);
        println!("{found:?}");
        // A change of the survivors, even from the rounding of a sum, changes the number of components by about one.
        assert!((found[0] - 9.8).abs() < 0.3 && (found[1] - 37.0).abs() < 2.5, "{found:?}");
    }

    #[test]
    fn the_case_of_tracking_has_its_figures() {
        let found = means(&mut *gmphd_20_targets(), 100);
        println!("{found:?}");
        assert!((found[0] - 39.0).abs() < 2.0 && (100.0..140.0).contains(&found[2]), "{found:?}");
    }

    #[test]
    fn every_point_of_a_curve_can_be_made() {
        for curve in CURVES {
            for &point in curve.points.iter().filter(|&&point| curve.name == "map" || point <= 50) {
                let mut case = (curve.case)(point);
                let found = means(&mut *case, 100);
                println!("{} {point}: {found:?}", curve.name);
                let expected = match curve.name {
                    "map" => found[1] >= point as f64,
                    "measurements" => (found[0] - point as f64).abs() < 1.0,
                    _ => found[0] > 0.0,
                };
                assert!(expected, "{} {point}: {found:?}", curve.name);
            }
        }
    }
}
