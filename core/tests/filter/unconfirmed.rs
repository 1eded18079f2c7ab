//! What becomes of features that were seen but once and of those that are confirmed, and which features are the estimated ones.

use crate::alone::{Alone, Lidar, Models};
use crate::{
    Births, Component, Config, ControlNoise, Extraction, MapMemory, PlanarPose, RangeBearingLimits, RangeBearingWindow,
    Sensing, State, Static, Step, Symmetric, Unicycle, UnicycleControl,
};
use nalgebra::Vector2;

type Memory = State<PlanarPose<f64>, 1, 1, MapMemory<Static<Vector2<f64>>, 1, 16, 16, 64>>;
type Planar<'s> = Alone<'s, Unicycle<f64>, Lidar<f64>>;

/// A vehicle that turns on the spot without error and sees to the front.
fn filter(memory: &mut Memory, config: Config<f64>) -> Planar<'_> {
    let limits = RangeBearingLimits { bearing_half_width_rad: 1.0, ..RangeBearingLimits::full_circle(10.0, 0.95) };
    let window = RangeBearingWindow::new(limits).unwrap();
    let models = Models {
        motion: Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap(),
        sensing: Sensing::range_bearing([0.1, 0.02], window, 1.0).unwrap(),
    };
    let mut filter = Planar::new(models, Births::of_static(0.01), config, memory).unwrap();
    filter.reset(PlanarPose::new(0.0, 0.0, 0.0), 1).unwrap();
    filter
}

fn turn(filter: &mut Planar<'_>, angle_rad: f64) {
    filter.predict(&UnicycleControl { speed_mps: 0.0, rate_radps: angle_rad }, 1.0).unwrap();
}

fn bearings(filter: &Planar<'_>) -> Vec<f64> {
    let mut bearings: Vec<_> = filter.map(0).map(|component| component.mean.y.atan2(component.mean.x)).collect();
    bearings.sort_by(f64::total_cmp);
    bearings
}

#[test]
fn what_was_seen_but_once_is_forgotten_when_it_leaves_the_view() {
    for (unconfirmed_weight, left) in [(0.0, 3), (0.5, 2)] {
        let mut memory = Box::new(Memory::new());
        let config = Config { unconfirmed_weight, particles: 1, ..Config::default() };
        let mut filter = filter(&mut memory, config);
        // A feature at −0.8 rad, seen again and again but not in the last scan, and a lone measurement in that one.
        for _ in 0..5 {
            filter.scan(&[Vector2::new(5.0, -0.8), Vector2::new(5.0, 0.9)]).unwrap();
        }
        filter.scan(&[Vector2::new(5.0, -0.6), Vector2::new(5.0, 0.9)]).unwrap();
        let missed = filter.map(0).find(|component| component.mean.y.atan2(component.mean.x) < -0.7).unwrap();
        assert!(missed.ln_weight.exp() < 0.1, "{missed:?}");
        // Both on the right leave the view; what is on the left stays in it.
        turn(&mut filter, 1.0);
        let report = filter.scan(&[Vector2::new(5.0, -0.1)]).unwrap();
        let found = bearings(&filter);
        assert_eq!(found.len(), left, "{found:?}");
        assert!(found.iter().any(|bearing| (bearing + 0.8).abs() < 0.05), "confirmed, and missed only now: {found:?}");
        assert!(found.iter().any(|bearing| (bearing - 0.9).abs() < 0.05), "{found:?}");
        // What was forgotten is accounted for.
        assert_eq!(report.pruned_mass > 0.01, left == 2, "{}", report.pruned_mass);
    }
}

#[test]
fn the_highest_peaks_or_the_heaviest_are_the_estimated_features() {
    let component = |label, weight: f64, x, variance| Component {
        label,
        ln_weight: weight.ln(),
        mean: Vector2::new(x, 0.0),
        covariance: Symmetric::from_diagonal([variance, variance]),
    };
    // N̂ = 1.75: two features. The second is well known but was missed of late, the third two false measurements that agreed.
    let map = [component(1, 1.0, 1.0, 0.01), component(2, 0.05, 2.0, 0.001), component(3, 0.7, 3.0, 0.1)];
    for (extraction, expected) in [(Extraction::Heaviest, [1, 3]), (Extraction::Peaks, [1, 2])] {
        let mut memory = Box::new(Memory::new());
        let mut filter = filter(&mut memory, Config { extraction, particles: 1, ..Config::default() });
        filter.load_map(&map).unwrap();
        let mut features = [Component::ZERO; 3];
        assert_eq!(filter.estimate_map(&mut features).features, 2);
        assert_eq!([features[0].label, features[1].label], expected);
    }
}

#[test]
fn what_is_confirmed_outlasts_misses() {
    let seen = [Vector2::new(5.0, 0.4)];
    for (confirmed_weight, scans, left) in [(0.0, 20, 0), (0.05, 20, 1), (0.05, 1, 0)] {
        let mut memory = Box::new(Memory::new());
        let config = Config {
            confirming_detections: 3.0,
            confirmed_weight,
            extraction: Extraction::Confirmed,
            particles: 1,
            ..Config::default()
        };
        let mut filter = filter(&mut memory, config);
        for _ in 0..scans {
            filter.scan(&seen).unwrap();
        }
        for _ in 0..6 {
            filter.scan(&[]).unwrap();
        }
        let mut features = [Component::ZERO; 3];
        let estimate = filter.estimate_map(&mut features);
        assert_eq!((filter.map(0).count(), estimate.features), (left, left), "{confirmed_weight} {scans}");
        if left == 1 {
            // N̂ alone would leave it out.
            assert!(
                (estimate.expected_features - 0.05).abs() < 1e-12 && (features[0].ln_weight.exp() - 0.05).abs() < 1e-12
            );
            // The next detection brings it back.
            filter.scan(&seen).unwrap();
            assert!(filter.estimate_map(&mut features).expected_features > 0.9);
        }
    }
}

#[test]
fn all_that_are_confirmed_are_estimated_however_heavy_the_others() {
    let component = |label, weight: f64, x, variance| Component {
        label,
        ln_weight: weight.ln(),
        mean: Vector2::new(x, 0.0),
        covariance: Symmetric::from_diagonal([variance, variance]),
    };
    // R is 0.01 m² in range and 0.01 m² or more across: the last has been seen once.
    let map = [
        component(1, 0.1, 5.0, 1e-4),
        component(2, 0.3, 6.0, 1e-3),
        component(3, 0.001, 7.0, 1e-4),
        component(4, 0.9, 8.0, 0.02),
    ];
    let mut memory = Box::new(Memory::new());
    let config = Config {
        extraction: Extraction::Confirmed,
        extraction_weight: 0.02,
        confirming_detections: 3.0,
        particles: 1,
        ..Config::default()
    };
    let mut filter = filter(&mut memory, config);
    filter.load_map(&map).unwrap();
    let mut features = [Component::ZERO; 4];
    assert_eq!(filter.estimate_map(&mut features).features, 2);
    assert_eq!([features[0].label, features[1].label], [1, 2]);
}
