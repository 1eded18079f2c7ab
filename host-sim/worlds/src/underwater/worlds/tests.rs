use super::plan::Plan;
use super::{Kind, Misbehaviour, misbehaving, world};
use scphd_log::angle::wrap;
use scphd_log::underwater::Log;

fn keypoints(log: &Log) -> usize {
    log.scans.iter().map(|scan| scan.detections.len()).sum()
}

#[test]
fn the_seed_determines_the_world_and_another_seed_gives_another_one() {
    for kind in [Kind::DataSheet, Kind::Exact] {
        assert_eq!(world(kind, 5), world(kind, 5));
        assert_ne!(world(kind, 5).landmarks, world(kind, 6).landmarks);
    }
}

#[test]
fn worlds_have_the_stated_size_and_the_rows_give_the_trajectory() {
    for seed in 0..30 {
        let plan = Plan::data_sheet(seed);
        assert!((4.0..=40.0).contains(&plan.size_m));
        let duration = plan.time(plan.way.len());
        assert!((149.0..241.0).contains(&duration), "{seed}: {duration} s");
        let rates = [1, plan.rows_per_scan, plan.rows_per_velocity].map(|rows| 1.0 / (plan.row_s * rows as f64));
        assert!(
            (5.0..=20.0).contains(&rates[0]) && (1.0..=20.0).contains(&rates[1]) && (2.0..=10.0).contains(&rates[2]),
            "{rates:?}"
        );
        assert!((30..=160).contains(&plan.features.len()));
        for (vehicle, next) in plan.way.iter().zip(&plan.way[1..]) {
            let [x, y, z] = vehicle.position.into();
            assert!(x.hypot(y) < 0.9 * plan.size_m && z < -4.0, "{seed}: {x} {y} {z}");
            let moved = vehicle.position + vehicle.rotation() * vehicle.velocity_mps * plan.row_s;
            assert!((moved - next.position).norm() < 1e-9);
            assert!(wrap(vehicle.yaw_rad + vehicle.yaw_rate_radps * plan.row_s - next.yaw_rad).abs() < 1e-9);
        }
    }
}

#[test]
fn a_switch_changes_only_its_error() {
    let only = |change: fn(&mut Misbehaviour)| {
        let mut misbehaviour = Misbehaviour::NONE;
        change(&mut misbehaviour);
        misbehaving(3, misbehaviour)
    };
    let none = misbehaving(3, Misbehaviour::NONE);
    let rows =
        |log: &Log, differ: fn(&scphd_log::underwater::Instruments, &scphd_log::underwater::Instruments) -> bool| {
            assert_eq!((&log.scans, &log.truth), (&none.scans, &none.truth));
            log.instruments.iter().zip(&none.instruments).filter(|(a, b)| differ(a, b)).count() as f64
                / none.instruments.len() as f64
        };
    let bias = only(|m| m.gyroscope_bias = true);
    assert_eq!(rows(&bias, |a, b| a.yaw_rate_radps != b.yaw_rate_radps), 1.0);
    assert_eq!(
        rows(&bias, |a, b| (a.velocity_mps, a.yaw_rad, a.roll_rad) != (b.velocity_mps, b.yaw_rad, b.roll_rad)),
        0.0
    );
    let lost = only(|m| m.velocity_outages = true);
    let share = rows(&lost, |a, b| a.velocity_mps.is_none() && b.velocity_mps.is_some());
    assert!(share > 0.001 && share < 0.2, "{share}");
    assert_eq!(rows(&lost, |a, b| a.velocity_mps.is_some() && a.velocity_mps != b.velocity_mps), 0.0);
    let tilt = only(|m| m.tilt = true);
    assert_eq!(rows(&tilt, |a, b| a.roll_rad != b.roll_rad && a.pitch_rad != b.pitch_rad), 1.0);
    let compass = only(|m| m.compass = true);
    assert_eq!(rows(&compass, |a, b| a.yaw_rad != b.yaw_rad), 1.0);
    let worst = compass
        .instruments
        .iter()
        .zip(&none.instruments)
        .map(|(a, b)| wrap(a.yaw_rad - b.yaw_rad).abs())
        .fold(0.0, f64::max);
    assert!((0.02..0.6).contains(&worst), "{worst}");
    let share = rows(&only(|m| m.velocity_outliers = true), |a, b| a.velocity_mps != b.velocity_mps);
    assert!(share > 0.0 && share < 0.03, "{share}");
    assert!(rows(&only(|m| m.velocity_scale = true), |a, b| a.velocity_mps != b.velocity_mps) > 0.1);
    for (change, more) in [
        (|m: &mut Misbehaviour| m.hidden_spells = true, false),
        (|m: &mut Misbehaviour| m.uneven_detection = true, false),
        (|m: &mut Misbehaviour| m.standing_clutter = true, true),
    ] as [(fn(&mut Misbehaviour), bool); 3]
    {
        let log = only(change);
        assert_eq!(log.instruments, none.instruments);
        assert_eq!(keypoints(&log) > keypoints(&none), more, "{} {}", keypoints(&log), keypoints(&none));
    }
    assert_ne!(only(|m| m.outliers = true).scans, none.scans);
    // One of the first worlds has a structure.
    let hides = |seed| {
        let occlusion = Misbehaviour { occlusion: true, ..Misbehaviour::NONE };
        let (with, without) =
            (keypoints(&misbehaving(seed, occlusion)), keypoints(&misbehaving(seed, Misbehaviour::NONE)));
        assert!(with <= without);
        with < without
    };
    assert!((0..10).any(hides));
}

#[test]
fn an_exact_world_states_all_noise_and_a_data_sheet_its_instruments() {
    for seed in 0..10 {
        let (exact, sheet) = (world(Kind::Exact, seed), world(Kind::DataSheet, seed));
        assert!(exact.simulated && (3.0..=10.0).contains(&exact.nominal.clutter_per_scan));
        assert!(exact.landmarks.iter().all(|landmark| landmark.detectability == exact.nominal.detection_probability));
        assert_eq!(exact.camera.common_sigmas, [0.0; 2]);
        assert!(!sheet.simulated && sheet.camera.common_sigmas[0] > 0.0);
        assert_eq!((sheet.nominal.detection_probability, sheet.nominal.clutter_per_scan), (0.85, 0.5));
    }
}
