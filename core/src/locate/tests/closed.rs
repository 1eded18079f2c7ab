//! Closed forms, and what is refused.

use crate::locate::alignment::{Alignment, Landmark};
use crate::*;
use nalgebra::{Vector2, Vector3};

fn post(x: f64, y: f64) -> Landmark<f64> {
    Component { mean: Vector2::new(x, y), covariance: Symmetric::from_diagonal([0.01, 0.04]), ..Component::ZERO }
}

/// `of_map`, as it is seen where its middle has this pose.
fn seen(at: &PlanarPose<f64>, of_map: &Landmark<f64>) -> Landmark<f64> {
    Component { mean: Alignment { at: *at, ..Alignment::ZERO }.turned().of(&of_map.mean), ..*of_map }
}

#[test]
fn least_squares_find_the_alignment() {
    let map = [post(1.0, 2.0), post(-4.0, 3.0), post(2.5, -6.0)];
    let at = PlanarPose::new(7.0, -3.0, 2.9);
    let landmarks = map.map(|of_map| seen(&at, &of_map));
    let lines = Alignment::of_lines([&landmarks[0].mean, &landmarks[1].mean], [&map[0].mean, &map[1].mean]);
    assert!(lines.at.difference(&at).norm() < 1e-12);
    // From a pose with a small error.
    let mut alignment = Alignment { at: at.displaced(&Vector3::new(0.05, -0.1, 0.02)), ..Alignment::ZERO };
    for _ in 0..4 {
        alignment = alignment.fitted(2.0, landmarks.iter().zip(&map)).unwrap();
    }
    assert!(alignment.at.difference(&at).norm() < 1e-9, "{alignment:?}");
}

/// Two landmarks, 2 r apart, each of variance s² in all directions, in either map: the variance of the middle is s², and that of
/// the heading s²/r².
#[test]
fn its_covariance_is_that_of_two_landmarks() {
    let round = |x: f64| Component { covariance: Symmetric::from_diagonal([0.02, 0.02]), ..post(x, 0.0) };
    let map = [round(-5.0), round(5.0)];
    let alignment = Alignment::ZERO.fitted(1.0, map.iter().zip(&map)).unwrap();
    for (k, variance) in [0.02, 0.02, 0.02 / 25.0].into_iter().enumerate() {
        assert!((alignment.covariance.get(k, k) - variance).abs() < 1e-12, "{k}: {alignment:?}");
    }
}

#[test]
fn the_covariance_in_the_map_is_by_the_right_derivatives() {
    let middle = Vector2::new(30.0, -20.0);
    let alignment = Alignment { at: PlanarPose::new(3.0, 1.0, -1.2), ..Alignment::ZERO };
    let pose = PlanarPose::new(-2.0, 5.0, 0.7);
    let there = alignment.pose_in_map(&pose, &middle);
    // Back again.
    let place = Vector2::new(there.x_m, there.y_m) - middle;
    assert!((alignment.turned().of(&place) - Vector2::new(-2.0, 5.0)).norm() < 1e-12);
    let step = 1e-6;
    for k in 0..6 {
        let mut by = Vector3::zeros();
        by[k % 3] = step;
        let moved = if k < 3 {
            Alignment { at: alignment.at.displaced(&by), ..alignment }.pose_in_map(&pose, &middle)
        } else {
            alignment.pose_in_map(&pose.displaced(&by), &middle)
        };
        let slope = moved.difference(&there) / step;
        let own = Symmetric::from_fn(|row, column| if row == column && row == k % 3 { 1.0 } else { 0.0 });
        let covariance = if k < 3 {
            Alignment { covariance: own, ..alignment }.covariance_in_map(&pose, &Symmetric::ZERO)
        } else {
            alignment.covariance_in_map(&pose, &own)
        };
        let squares = slope * slope.transpose();
        assert!((covariance.to_matrix() - squares).norm() < 1e-4, "{k}: {covariance:?} {squares}");
    }
}

#[test]
fn what_is_no_map_and_no_tuning_is_refused() {
    let mut memory = LocatorState::<f64, 4, 4>::new();
    let bad = LocatorConfig { new_share: 0.0, ..LocatorConfig::default() };
    assert_eq!(Locator::new(bad, &mut memory).unwrap_err().field, "new_share");
    let bad = LocatorConfig { trials: 0, ..LocatorConfig::default() };
    assert_eq!(Locator::new(bad, &mut memory).unwrap_err().field, "trials");
    let bad = LocatorConfig { inflation: f64::NAN, ..LocatorConfig::default() };
    assert_eq!(Locator::new(bad, &mut memory).unwrap_err().field, "inflation");
    let mut locator = Locator::new(LocatorConfig::default(), &mut memory).unwrap();
    let flat = Component { covariance: Symmetric::ZERO, ..post(0.0, 0.0) };
    assert_eq!(locator.load_map(&[post(0.0, 0.0), flat]), Err(LoadMapError::Component { index: 1 }));
    let many = LoadMapError::TooManyComponents { components: 5, capacity: 4 };
    assert_eq!(locator.load_map(&[post(0.0, 0.0); 5]), Err(many));
    assert_eq!(locator.load_map(&[]), Ok(()));
}

#[test]
fn a_state_takes_what_the_document_says() {
    assert!(size_of::<LocatorState<f32, 64, 16>>() <= 5200, "{}", size_of::<LocatorState<f32, 64, 16>>());
}
