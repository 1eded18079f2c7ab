//! An odometry bias is detected, and there are few false alarms without one.

use scphd::models::{AuvPose, PlanarPose, Pose};
use scphd::numerics::nalgebra::Vector3;
use scphd::numerics::{Noise, Vector};
use scphd_sequencer::OdometryWatch;

const SIGMAS: Vector3<f64> = Vector3::new(0.07, 0.0, 0.02);

/// Adds forward and heading corrections, in standard deviations of the odometry. Returns after each whether a bias is suspected.
fn watched(corrections: impl Iterator<Item = [f64; 2]>) -> impl Iterator<Item = bool> {
    let mut watch = OdometryWatch::new();
    let predicted = PlanarPose::new(3.0, -2.0, 0.8);
    corrections.map(move |[forward, turn]| {
        let forward = forward * SIGMAS.x;
        let by = Vector3::new(forward * 0.8_f64.cos(), forward * 0.8_f64.sin(), turn * SIGMAS.z);
        watch.scan(&predicted, &predicted.displaced(&by), &SIGMAS).is_suspected()
    })
}

#[test]
fn means_and_sums_are_along_the_axes_of_the_vehicle() {
    let mut watch = OdometryWatch::new();
    let predicted = PlanarPose::new(0.0, 0.0, core::f64::consts::FRAC_PI_2);
    // Forward is north and left is west: corrections of two standard deviations and of three quarters of one.
    let corrected = PlanarPose::new(-0.03, 0.1, predicted.heading_rad);
    let bias = watch.scan(&predicted, &corrected, &Vector3::new(0.05, 0.04, 0.0));
    assert!((bias.each_scan - Vector3::new(0.02, 0.006, 0.0)).norm() < 1e-12, "{bias:?}");
    assert!((bias.evidence - Vector3::new(1.0, 0.0, 0.0)).norm() < 1e-12, "{bias:?}");
}

#[test]
fn of_a_hundred_thousand_scans_with_noise_alone_hardly_one_is_suspected() {
    // Noise with the assumed standard deviation, half of it and twice that.
    for scale in [1.0, 0.5, 2.0] {
        let mut draws = Noise::seeded(31);
        let noise = (0..100_000).map(|_| [scale * draws.normal::<f64>(), scale * draws.normal::<f64>()]);
        let alarms = watched(noise).filter(|&suspected| suspected).count();
        assert!(alarms <= 10, "{scale}: {alarms}");
    }
}

#[test]
fn a_bias_of_two_standard_deviations_is_told_within_ten_scans() {
    for direction in [[2.0, 0.0], [0.0, -2.0]] {
        let found = (0..200).filter(|&seed| {
            let mut draws = Noise::seeded(seed);
            let corrections = (0..410).map(|scan| {
                let on = if scan < 400 { 0.0 } else { 1.0 };
                direction.map(|by| by * on + draws.normal::<f64>())
            });
            watched(corrections).skip(400).any(|suspected| suspected)
        });
        let found = found.count();
        assert!(found >= 180, "{direction:?}: {found} of 200");
    }
}

#[test]
fn it_is_as_small_as_the_documentation_says() {
    assert_eq!(size_of::<OdometryWatch<PlanarPose<f32>>>(), 48);
}

#[test]
fn a_single_jump_is_no_bias() {
    let corrections = (0..100).map(|scan| [if scan == 50 { 1e6 } else { 0.0 }, 0.0]);
    assert!(watched(corrections).all(|suspected| !suspected));
}

#[test]
fn non_finite_corrections_change_nothing() {
    let mut watch = OdometryWatch::new();
    let pose = PlanarPose::new(0.0, 0.0, 0.0);
    let before = watch.scan(&pose, &PlanarPose::new(0.1, 0.0, 0.01), &SIGMAS);
    let after = watch.scan(&pose, &PlanarPose::new(f64::NAN, 0.0, 0.0), &SIGMAS);
    assert_eq!(before.each_scan, after.each_scan);
    let unknown = watch.scan(&pose, &pose, &Vector3::repeat(f64::NAN));
    assert!(unknown.evidence == after.evidence && unknown.each_scan == Vector3::zeros());
}

#[test]
fn under_water_the_depth_is_monitored_too() {
    let mut watch = OdometryWatch::<AuvPose<f64>>::new();
    let predicted = AuvPose::ZERO;
    let mut moved = predicted.coordinates() - predicted.coordinates();
    moved.as_mut_slice()[2] = 0.2;
    let sigmas = moved * 0.5;
    let bias = (0..20).map(|_| watch.scan(&predicted, &predicted.displaced(&moved), &sigmas)).last().unwrap();
    assert!(bias.is_suspected() && bias.evidence.at(2) > 5.5 && bias.evidence.at(0) == 0.0, "{bias:?}");
}
