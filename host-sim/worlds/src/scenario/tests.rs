//! Tests of all scenarios.

use super::*;
use scphd_log::angle::wrap;
use scphd_log::log::{Fix, FixNoise, PoseFix};
use scphd_log::vehicle::dead_reckoning;
use scphd_log::{log_folder, truth};
use scphd_score::trajectory;

#[test]
fn every_name_gives_its_log() {
    for (name, about) in SCENARIOS {
        // The name of a random world ends with its seed.
        let named = by_name(name, 1).unwrap().name;
        assert_eq!(named.strip_suffix("-1").unwrap_or(&named), *name);
        assert!(!about.contains('\n'));
    }
    assert!(by_name("no such scenario", 1).is_none());
}

fn extent(log: &Log, k: usize) -> f64 {
    let along = log.truth.iter().map(|row| row.position[k]);
    along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[test]
fn sizes_are_those_of_the_thesis() {
    for (log, scans, landmarks, movers, width, height) in
        [(thesis_dynamic(1), 301, 45, 6, 38.6, 37.0), (thesis_compare(1), 401, 60, 0, 44.0, 40.7)]
    {
        assert_eq!((log.scans.len(), log.odometry.len()), (scans, 2 * scans - 2));
        assert_eq!((log.landmarks.len(), log.moving.len()), (landmarks, movers * scans));
        assert!((extent(&log, 0) - width).abs() < 0.5, "{} wide", extent(&log, 0));
        assert!((extent(&log, 1) - height).abs() < 0.5, "{} high", extent(&log, 1));
        let (first, last) = (log.truth[0], log.truth[scans - 1]);
        assert!(apart(first.position, last.position) < 1e-9, "the way closes");
    }
}

#[test]
fn landmarks_keep_their_distance() {
    for (log, from_path) in [(thesis_dynamic(1), 2.5), (thesis_compare(1), 3.0)] {
        for (index, &landmark) in log.landmarks.iter().enumerate() {
            assert!(log.landmarks[..index].iter().all(|&other| apart(landmark, other) >= 3.0));
            assert!(log.truth.iter().all(|row| apart(landmark, row.position) > from_path - 0.1));
            assert!(log.moving.iter().all(|row| apart(landmark, row.position) > 1.4));
        }
    }
}

#[test]
fn moving_landmarks_cross_the_path_and_stay_in_view_for_long() {
    let log = thesis_dynamic(1);
    for track in log.moving.chunks(log.scans.len()) {
        let from_vehicle: Vec<f64> =
            track.iter().zip(&log.truth).map(|(row, pose)| apart(row.position, pose.position)).collect();
        assert!(from_vehicle.iter().all(|&distance| distance > 2.5));
        let in_view = from_vehicle.iter().filter(|&&distance| distance <= 15.0).count();
        assert!(in_view as f64 / log.scans.len() as f64 > 0.4, "{} of {}", in_view, log.scans.len());
        let crossing = track.iter().any(|row| log.truth.iter().any(|pose| apart(row.position, pose.position) < 1.5));
        assert!(crossing, "{:?}", track[0]);
        let speed = apart(track[1].position, track[0].position) / 0.1;
        assert!((0.5..=2.5).contains(&speed), "{speed}");
        for other in log.moving.chunks(log.scans.len()).filter(|other| other[0].subject < track[0].subject) {
            assert!(track.iter().zip(other).all(|(a, b)| apart(a.position, b.position) > 2.0));
        }
    }
}

#[test]
fn detections_are_of_landmarks_or_uniform_clutter_at_the_stated_rates() {
    for name in ["survey", "thesis-dynamic", "thesis-compare"] {
        let (mut in_range, mut detected, mut clutter, mut scans) = (0, 0, 0, 0);
        let (mut range_squares, mut bearing_squares) = (0.0, 0.0);
        let nominal = by_name(name, 0).unwrap().nominal;
        let sigmas = [nominal.range_sigma_m.unwrap(), nominal.bearing_sigma_rad.unwrap()];
        for seed in 0..4 {
            let log = by_name(name, seed).unwrap();
            for (index, scan) in log.scans.iter().enumerate() {
                scans += 1;
                let here = truth::at(&log.truth, scan.t_s).unwrap();
                let mut unexplained = scan.detections.clone();
                let moving = log.moving.chunks(log.scans.len()).map(|track| track[index].position);
                for landmark in log.landmarks.iter().copied().chain(moving) {
                    let (dx, dy) = (landmark[0] - here.position[0], landmark[1] - here.position[1]);
                    let range = dx.hypot(dy);
                    if range > log.sensor.range_max_m {
                        continue;
                    }
                    in_range += 1;
                    let bearing = dy.atan2(dx) - here.heading_rad.unwrap();
                    let off = |z: &[f64; 2]| [(z[0] - range) / sigmas[0], wrap(z[1] - bearing) / sigmas[1]];
                    let size = |z: &[f64; 2]| off(z)[0].powi(2) + off(z)[1].powi(2);
                    let Some(best) =
                        (0..unexplained.len()).min_by(|&a, &b| size(&unexplained[a]).total_cmp(&size(&unexplained[b])))
                    else {
                        continue;
                    };
                    // The gate contains all but 1 in 3000.
                    if size(&unexplained[best]) < 16.0 {
                        let [r, b] = off(&unexplained.swap_remove(best));
                        range_squares += r * r;
                        bearing_squares += b * b;
                        detected += 1;
                    }
                }
                clutter += unexplained.len();
            }
        }
        let rate = f64::from(detected) / f64::from(in_range);
        let false_rate = clutter as f64 / f64::from(scans);
        let variances = [range_squares, bearing_squares].map(|sum: f64| sum / f64::from(detected));
        let per_scan = f64::from(in_range) / f64::from(scans);
        println!("{name}: {per_scan} in range, detected {rate}, clutter {false_rate}, variances {variances:?}");
        // With large noise, landmarks are sometimes matched with other detections.
        let slack = if name == "thesis-compare" { 4.0 } else { 1.0 };
        assert!((rate - 0.95).abs() < 0.004 * slack);
        assert!((false_rate - nominal.clutter_per_scan.unwrap()).abs() < 0.4);
        assert!(variances.iter().all(|v| (v - 1.0).abs() < 0.03 * slack));
        assert!((8.0..25.0).contains(&per_scan));
    }
}

#[test]
fn a_label_is_the_number_of_the_landmark() {
    for name in ["thesis-dynamic", "faults"] {
        let log = by_name(name, 3).unwrap();
        assert_eq!(log.moving[0].subject, log.landmarks.len() as i64);
        assert!(log.scans.iter().all(|scan| scan.labels.len() == scan.detections.len()));
        let scan = &log.scans[100];
        let here = truth::at(&log.truth, scan.t_s).unwrap();
        let labelled = scan.detections.iter().zip(&scan.labels);
        let of_static = labelled.filter_map(|(z, &label)| Some((z, log.landmarks.get(usize::try_from(label).ok()?)?)));
        let apart: Vec<f64> = of_static
            .map(|(&[range, bearing], &landmark)| {
                let (sin, cos) = (here.heading_rad.unwrap() + bearing).sin_cos();
                apart(landmark, [here.position[0] + range * cos, here.position[1] + range * sin])
            })
            .collect();
        // Six standard deviations.
        assert!(apart.len() > 5 && apart.iter().all(|&distance| distance < 1.7), "{name}: {apart:?}");
    }
}

#[test]
fn dead_reckoning_has_errors_of_metres() {
    for (name, _) in SCENARIOS {
        for seed in 0..4 {
            let log = by_name(name, seed).unwrap();
            let poses = dead_reckoning(&log);
            let errors: Vec<f64> =
                poses.iter().zip(&log.truth).map(|(pose, truth)| apart([pose[0], pose[1]], truth.position)).collect();
            let greatest = errors.iter().copied().fold(0.0, f64::max);
            let score = trajectory::score(
                poses.iter().zip(&log.truth).map(|(&pose, truth)| (pose, truth.position, truth.heading_rad)),
            );
            println!("{name} {seed}: greatest {greatest}, rms {}", score.unwrap().position_rmse_m);
            assert_eq!(errors[0], 0.0);
            assert!((0.5..60.0).contains(&greatest), "{greatest}");
        }
    }
}

#[test]
fn the_seed_changes_only_the_noise() {
    // A random world is different for every seed.
    for (name, _) in SCENARIOS.iter().filter(|(name, _)| is_of_thesis(name)) {
        let [log, same, other] = [5, 5, 6].map(|seed| by_name(name, seed).unwrap());
        assert_eq!(log, same);
        assert_eq!((&log.truth, &log.landmarks, &log.moving), (&other.truth, &other.landmarks, &other.moving));
        assert_ne!(log.odometry, other.odometry);
        assert_ne!(log.scans, other.scans);
    }
}

/// Checks that a log is the same after writing and reading.
fn written_and_read(log: &Log) {
    let dir = std::env::temp_dir().join(format!("scphd-{}-{}", log.name, std::process::id()));
    log_folder::write(log, &dir).unwrap();
    let back = log_folder::read(&dir);
    std::fs::remove_dir_all(&dir).unwrap();
    assert_eq!(back.unwrap(), *log);
}

#[test]
fn a_written_scenario_reads_back_the_same() {
    for (name, _) in SCENARIOS {
        written_and_read(&by_name(name, 9).unwrap());
    }
}

#[test]
fn sensors_and_fixes_are_read_and_written_bit_for_bit() {
    written_and_read(&two_sensors(3));
    written_and_read(&with_every_fix(survey_fixes(3)));
}

/// With all keys of `[fixes]`, and headings.
fn with_every_fix(mut log: Log) -> Log {
    log.fixes.push(Fix { t_s: 61.25, measured: PoseFix::Heading(-0.75) });
    let (heading_sigma_rad, gate) = (Some(0.1), Some(25.0));
    log.fix_noise = FixNoise { heading_sigma_rad, gate, forward_m: -0.5, left_m: 0.25, ..log.fix_noise };
    log
}
