//! Models that are wrong, and what is learnt of it while running.

use crate::alone::{Alone, Models};
use crate::*;
use nalgebra::Vector2;

type Memory = State<PlanarPose<f64>, 1, 1, MapMemory<Static<Vector2<f64>>, 1, 64, 64, 512>>;

/// One world: p_D and λ as they are.
struct World {
    detection: f64,
    clutter_per_scan: f64,
}

/// Twelve features around a vehicle that stands still, seen as the world has it; the factors learnt in the end.
fn learnt(world: &World, detection: f64, clutter_per_scan: f64, online: Online<f64>, seed: u64) -> (f64, f64) {
    let window = RangeBearingWindow::full_circle(20.0, detection).unwrap();
    let models = Models {
        motion: KnownPose::new(),
        sensor: RangeBearing::new(0.1, 0.01).unwrap(),
        field_of_view: window,
        clutter: UniformClutter::of_scan(clutter_per_scan, window.measure()).unwrap(),
    };
    let births = Births::of_static(models.clutter.intensity() / 20.0);
    let config = Config { particles: 1, prune_weight: 1e-3, ..Config::default() };
    let mut memory = Box::new(Memory::new());
    let mut filter = Alone::new(models, births, config, &mut *memory).unwrap();
    filter.detector = filter.detector.learning(online).unwrap();
    filter.reset(PlanarPose::new(0.0, 0.0, 0.0), 1).unwrap();
    let mut noise = Noise::seeded(seed);
    let mut last = (1.0, 1.0);
    for _ in 0..400 {
        let mut scan: Vec<Vector2<f64>> = Vec::new();
        for feature in 0..12 {
            let place = Vector2::new(5.0 + f64::from(feature), 0.5 * f64::from(feature) - 3.0);
            if noise.uniform::<f64>() < world.detection {
                scan.push(place + Vector2::new(0.1 * noise.normal::<f64>(), 0.01 * noise.normal::<f64>()));
            }
        }
        // Binomial, which is near enough to Poisson.
        for _ in 0..40 {
            if noise.uniform::<f64>() < world.clutter_per_scan / 40.0 {
                let bearing = core::f64::consts::TAU * (noise.uniform::<f64>() - 0.5);
                scan.push(Vector2::new(20.0 * noise.uniform::<f64>(), bearing));
            }
        }
        let report = filter.scan(&scan).unwrap();
        last = (report.detection_scale, report.clutter_scale);
    }
    last
}

const BOTH: Online<f64> = Online { detection_memory: 100.0, clutter_memory: 100.0 };

#[test]
fn a_wrong_probability_of_detection_is_found_out() {
    for (truth, told) in [(0.95, 0.7), (0.7, 0.95), (0.5, 0.9), (0.8, 0.8)] {
        let world = World { detection: truth, clutter_per_scan: 4.0 };
        let (scale, _) = learnt(&world, told, 4.0, BOTH, 5);
        assert!((told * scale - truth).abs() < 0.04, "{} instead of {truth}", told * scale);
    }
}

#[test]
fn a_wrong_clutter_rate_is_found_out() {
    for (truth, told) in [(6.0, 2.0), (2.0, 6.0), (4.0, 4.0)] {
        let world = World { detection: 0.9, clutter_per_scan: truth };
        let (_, scale) = learnt(&world, 0.9, told, BOTH, 6);
        // Births claim a part of what is unexplained.
        assert!((told * scale / truth - 1.0).abs() < 0.2, "{} instead of {truth}", told * scale);
    }
}

#[test]
fn what_is_not_to_be_learnt_stays_exactly() {
    let world = World { detection: 0.7, clutter_per_scan: 6.0 };
    assert_eq!(learnt(&world, 0.9, 2.0, Online::NONE, 7), (1.0, 1.0));
    let (detection, clutter) = learnt(&world, 0.9, 2.0, Online { clutter_memory: 0.0, ..BOTH }, 7);
    assert!(detection < 0.9 && clutter == 1.0);
}
