use super::{Kind, Misbehaviour, misbehaving, world};
use scphd_log::vehicle::dead_reckoning;
use scphd_score::trajectory;

fn dead_reckoning_rmse(log: &scphd_log::log::Log) -> f64 {
    let poses = dead_reckoning(log);
    let rows = poses.iter().zip(&log.truth).map(|(&pose, truth)| (pose, truth.position, truth.heading_rad));
    trajectory::score(rows).unwrap().position_rmse_m
}

#[test]
fn the_seed_determines_the_world_and_another_seed_gives_another_one() {
    for kind in [Kind::DataSheet, Kind::Exact, Kind::Mounted, Kind::Moving] {
        assert_eq!(world(kind, 5), world(kind, 5));
        assert_ne!(world(kind, 5).landmarks, world(kind, 6).landmarks);
    }
}

#[test]
fn worlds_have_the_stated_size() {
    for seed in 0..30 {
        let log = world(Kind::DataSheet, seed);
        assert!((15..=45).contains(&log.landmarks.len()), "{}", log.landmarks.len());
        let last = log.truth.last().unwrap().t_s;
        assert!((239.0..301.0).contains(&last), "{last}");
        let view = log.sensor.bearing_max_rad - log.sensor.bearing_min_rad;
        assert!((2.4..6.284).contains(&view));
        assert_eq!(log.truth.len(), log.scans.len());
        // Every landmark is detected in some scan of most worlds, and there is clutter.
        assert!(log.scans.iter().any(|scan| scan.labels.contains(&-1)));
    }
}

/// Without white noise and with all switches off, odometry has no error.
#[test]
fn the_switched_errors_are_those_of_dead_reckoning() {
    let (mut with, mut without) = (Vec::new(), Vec::new());
    for seed in 0..20 {
        let extent = |log: &scphd_log::log::Log| log.landmarks.iter().map(|m| m[0].abs()).fold(0.0, f64::max);
        let all = misbehaving(seed, Misbehaviour::ALL);
        let none = misbehaving(seed, Misbehaviour::NONE);
        assert_eq!(all.landmarks, none.landmarks);
        with.push(dead_reckoning_rmse(&all) / extent(&all));
        without.push(dead_reckoning_rmse(&none) / extent(&none));
    }
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let (with, without) = (median(&mut with), median(&mut without));
    assert!(with > 2.0 * without, "{with} {without}");
}

#[test]
fn a_switch_changes_only_its_error() {
    let none = misbehaving(3, Misbehaviour::NONE);
    let slip = misbehaving(3, Misbehaviour { slip: true, ..Misbehaviour::NONE });
    assert_eq!(slip.scans, none.scans);
    let changed = slip.odometry.iter().zip(&none.odometry).filter(|(a, b)| a != b).count();
    assert!((5..80).contains(&changed), "{changed} of {} rows", none.odometry.len());
    let hidden = misbehaving(3, Misbehaviour { occlusion: true, hidden_spells: true, ..Misbehaviour::NONE });
    assert_eq!(hidden.odometry, none.odometry);
    let count = |log: &scphd_log::log::Log| log.scans.iter().map(|scan| scan.detections.len()).sum::<usize>();
    assert!(count(&hidden) < count(&none));
    let ghosts = misbehaving(3, Misbehaviour { standing_clutter: true, ..Misbehaviour::NONE });
    assert!(count(&ghosts) > count(&none));
}

#[test]
fn an_exact_world_states_all_noise_and_a_data_sheet_only_range_and_bearing() {
    let exact = world(Kind::Exact, 1);
    assert!(exact.simulated && exact.nominal.clutter_per_scan.is_some_and(|clutter| (3.0..=10.0).contains(&clutter)));
    let sheet = world(Kind::DataSheet, 1);
    assert!(!sheet.simulated && sheet.nominal.detection_probability.is_none());
    assert!(sheet.nominal.speed_sigma_mps.is_none() && sheet.nominal.range_sigma_m.is_some());
}

/// The mounting of the sensor is known: detections are of static landmarks.
#[test]
fn a_mounted_sensor_detects_the_same_world() {
    let (plain, mounted) = (world(Kind::DataSheet, 4), world(Kind::Mounted, 4));
    assert_eq!(
        (&plain.odometry, &plain.truth, &plain.landmarks),
        (&mounted.odometry, &mounted.truth, &mounted.landmarks)
    );
    assert!(mounted.sensor.mounting.yaw_rad != 0.0);
    let mut off = Vec::new();
    for (scan, truth) in mounted.scans.iter().zip(&mounted.truth) {
        let [x, y] = truth.position;
        let [x, y, heading] = mounted.sensor.mounting.seat([x, y, truth.heading_rad.unwrap()]);
        for (z, &label) in scan.detections.iter().zip(&scan.labels).filter(|(_, label)| **label >= 0) {
            let [east, north] = mounted.landmarks[label as usize];
            let (s, c) = (heading + z[1]).sin_cos();
            off.push((x + z[0] * c - east).hypot(y + z[0] * s - north) / z[0]);
        }
    }
    off.sort_by(f64::total_cmp);
    assert!(off.len() > 1000 && off[off.len() / 2] < 0.03, "{} {}", off.len(), off[off.len() / 2]);
}

/// With moving objects nothing else changes: neither the noise of the landmarks, nor false detections, nor their order.
#[test]
fn moving_objects_are_added_to_the_same_world() {
    for seed in 0..10 {
        let (plain, moving) = (world(Kind::DataSheet, seed), world(Kind::Moving, seed));
        assert_eq!(
            (&plain.odometry, &plain.truth, &plain.landmarks),
            (&moving.odometry, &moving.truth, &moving.landmarks)
        );
        let mut added = 0;
        for (scan, others) in moving.scans.iter().zip(&plain.scans) {
            let mut detections = scan.detections.iter().zip(&scan.labels);
            for other in others.detections.iter().zip(&others.labels) {
                assert!(detections.any(|detection| detection == other), "{seed}");
            }
            added += scan.detections.len() - others.detections.len();
        }
        assert!(added > 50, "{seed}");
        // Their numbers are not labels of landmarks.
        let mut subjects: Vec<i64> = moving.moving.iter().map(|row| row.subject).collect();
        subjects.dedup();
        assert!((3..=7).contains(&subjects.len()) && moving.moving.len() == subjects.len() * moving.scans.len());
        assert_eq!(subjects[0], moving.landmarks.len() as i64);
    }
}
