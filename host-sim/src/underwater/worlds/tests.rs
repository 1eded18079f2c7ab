use super::plan::Plan;
use super::{Kind, Misbehaviour, misbehaving, world};
use crate::angle::wrap;
use crate::dimensions::Underwater;
use crate::kind::Kind as _;
use crate::underwater::log::Log;
use crate::underwater::settings::Settings;
use nalgebra::Vector3;

fn dead_reckoning_rmse(log: &Log) -> f64 {
    let settings = Settings::for_real_log(log);
    let places = Underwater::dead_reckoning(log, &settings).unwrap();
    let squares: f64 = log
        .scans
        .iter()
        .zip(&places)
        .map(|(scan, &place)| {
            let row = log.truth.partition_point(|row| row.t_s <= scan.t_s) - 1;
            (Vector3::from(place) - Vector3::from(log.truth[row].position)).norm_squared()
        })
        .sum();
    (squares / places.len() as f64).sqrt()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn keypoints(log: &Log) -> usize {
    log.scans.iter().map(|scan| scan.detections.len()).sum()
}

#[test]
fn a_world_is_its_seed_and_another_seed_is_another_world() {
    for kind in [Kind::DataSheet, Kind::Exact] {
        assert_eq!(world(kind, 5), world(kind, 5));
        assert_ne!(world(kind, 5).landmarks, world(kind, 6).landmarks);
    }
}

#[test]
fn worlds_are_as_large_as_they_say_and_the_rows_lead_along_the_way() {
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

/// Most features that were seen in the first third are seen in the last.
#[test]
fn places_are_seen_again_and_a_frame_shows_some() {
    let (mut again, mut shown) = (Vec::new(), Vec::new());
    for seed in 0..30 {
        let log = world(Kind::DataSheet, seed);
        let settings = Settings::for_real_log(&log);
        let view = Underwater::view(&log, &settings);
        let seen = |part: usize| -> Vec<usize> {
            let rows = log.truth.len() / 3;
            let poses = || log.truth[part * rows..(part + 1) * rows].iter().step_by(10);
            let in_view = |index: &usize| poses().any(|pose| view(pose, log.landmarks[*index].position) == Some(true));
            (0..log.landmarks.len()).filter(in_view).collect()
        };
        let (first, last) = (seen(0), seen(2));
        again.push(first.iter().filter(|index| last.contains(index)).count() as f64 / first.len() as f64);
        shown.push(keypoints(&log) as f64 / log.scans.len() as f64);
    }
    assert!(again.iter().all(|share| *share > 0.1) && median(again.clone()) > 0.5, "{again:?}");
    assert!(shown.iter().all(|count| (1.0..20.0).contains(count)) && median(shown.clone()) > 4.0, "{shown:?}");
}

#[test]
fn misbehaviour_is_what_dead_reckoning_errs_by() {
    let worlds = |misbehaviour| -> f64 {
        median(
            (0..20)
                .map(|seed| dead_reckoning_rmse(&misbehaving(seed, misbehaviour)) / Plan::data_sheet(seed).size_m)
                .collect(),
        )
    };
    let (with, without) = (worlds(Misbehaviour::ALL), worlds(Misbehaviour::NONE));
    assert!(with > 2.0 * without && with < 0.3, "{with} {without}");
}

#[test]
fn a_switch_changes_what_it_says_and_nothing_else() {
    let only = |change: fn(&mut Misbehaviour)| {
        let mut misbehaviour = Misbehaviour::NONE;
        change(&mut misbehaviour);
        misbehaving(3, misbehaviour)
    };
    let none = misbehaving(3, Misbehaviour::NONE);
    let rows = |log: &Log, differ: fn(&super::super::log::Instruments, &super::super::log::Instruments) -> bool| {
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
    // Some world of the first has a structure.
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
fn an_exact_world_states_all_and_a_data_sheet_its_instruments() {
    for seed in 0..10 {
        let (exact, sheet) = (world(Kind::Exact, seed), world(Kind::DataSheet, seed));
        assert!(exact.simulated && (3.0..=10.0).contains(&exact.nominal.clutter_per_scan));
        assert!(exact.landmarks.iter().all(|landmark| landmark.detectability == exact.nominal.detection_probability));
        assert_eq!(exact.camera.common_sigmas, [0.0; 2]);
        assert!(!sheet.simulated && sheet.camera.common_sigmas[0] > 0.0);
        assert_eq!((sheet.nominal.detection_probability, sheet.nominal.clutter_per_scan), (0.85, 0.5));
    }
}
