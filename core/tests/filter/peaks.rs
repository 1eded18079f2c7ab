//! What a scan says of the room that it took, and of what it expected to see.

use crate::alone::{Alone, Lidar, Models};
use crate::*;
use nalgebra::Vector2;

type Memory = State<PlanarPose<f64>, 2, 2, MapMemory<Static<Vector2<f64>>, 2, 24, 12, 128>>;

const DETECTION: f64 = 0.9;

fn filter(state: &mut Memory, particles: usize) -> Alone<'_, Unicycle<f64>, Lidar<f64>> {
    let field_of_view = RangeBearingWindow::full_circle(20.0, DETECTION).unwrap();
    let models = Models {
        motion: Unicycle::new(Step::Euler, ControlNoise::white(1e-6, 1e-6)).unwrap(),
        sensing: Sensing::range_bearing([0.05, 0.005], field_of_view, 1e-3).unwrap(),
    };
    let config = Config { particles, resample_threshold: 0.0, ..Config::default() };
    let mut filter = Alone::new(models, Births::of_static(1.0), config, state).unwrap();
    filter.slam.reset(PlanarPose::ZERO, 1).unwrap();
    filter
}

/// Twenty posts around the vehicle, far apart.
fn posts() -> Vec<Vector2<f64>> {
    (0..20).map(|k| Vector2::new(10.0, 0.3 * f64::from(k) - 2.9)).collect()
}

#[test]
fn twenty_births_take_three_pages() {
    let mut state = Box::new(Memory::new());
    let mut filter = filter(&mut state, 1);
    let report = filter.scan(&posts()).unwrap();
    assert_eq!((report.peak.in_view, report.peak.pages, report.peak.map_pages), (20, 3, 3));
    assert_eq!(report.moving_peak, Peak::default());
    // Nothing was there to be expected.
    assert_eq!((report.expected_detections, report.detections), (0.0, 0.0));
}

#[test]
fn what_is_expected_is_seen_or_missed() {
    let mut state = Box::new(Memory::new());
    let mut filter = filter(&mut state, 1);
    (0..6).for_each(|_| assert!(filter.scan(&posts()).is_ok()));
    let seen = filter.scan(&posts()).unwrap();
    // The intensity of a post that is always detected is w = (1 − p_D) w + 1, so that p_D w is one.
    assert!((seen.expected_detections - 20.0).abs() < 0.05, "{}", seen.expected_detections);
    assert!((seen.detections - 20.0).abs() < 0.05, "{}", seen.detections);
    // Missed and detected copies of all posts, before they are merged.
    assert_eq!(seen.peak.in_view, 40);
    let missed = filter.scan(&[]).unwrap();
    assert!((missed.expected_detections - 20.0).abs() < 0.05, "{}", missed.expected_detections);
    assert_eq!(missed.detections, 0.0);
    // After a miss, (1 − p_D) of it is left.
    let again = filter.scan(&[]).unwrap();
    assert!((again.expected_detections - 20.0 * (1.0 - DETECTION)).abs() < 0.05, "{}", again.expected_detections);
}

/// Two maps that differ, one of which is written while the other is still there.
#[test]
fn the_peak_is_at_least_what_is_held() {
    let mut state = Box::new(Memory::new());
    let mut filter = filter(&mut state, 2);
    for _ in 0..5 {
        let report = filter.scan(&posts()).unwrap();
        assert!(report.peak.pages >= report.pages_used && report.peak.pages <= report.pages);
        assert!(report.peak.map_pages * 2 >= report.pages_used && report.peak.map_pages <= 12);
    }
}
