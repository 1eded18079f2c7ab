//! Several sensors and fixes.

use super::*;
use scphd_filters::ekf::Association;
use scphd_filters::settings::Settings;
use scphd_filters::slam::Precision;
use scphd_log::log::{Fix, FixNoise, Log, Mounting, NamedSensor, Nominal, PoseFix, Scan, Sensor};
use scphd_log::log_folder;
use scphd_worlds::scenario;
use std::f64::consts::{FRAC_PI_2, PI};

const EKF: Filter = Filter::Ekf(Association::NearestNeighbour);

/// The survey with two sensors, which view the left and the right half at the same times.
fn halved(log: &Log) -> Log {
    let half = |yaw_rad| Sensor {
        bearing_min_rad: -FRAC_PI_2,
        bearing_max_rad: FRAC_PI_2,
        mounting: Mounting { yaw_rad, ..Mounting::NONE },
        ..log.sensor
    };
    let nominal = Nominal { clutter_per_scan: log.nominal.clutter_per_scan.map(|all| 0.5 * all), ..log.nominal };
    let scans = log.scans.iter().flat_map(|scan| {
        [(0, 1.0), (1, -1.0)].map(|(sensor, side)| {
            let own = scan.detections.iter().filter(|[_, bearing]| (side * bearing) > 0.0);
            let detections = own.map(|&[range, bearing]| [range, bearing - side * FRAC_PI_2]).collect();
            Scan { t_s: scan.t_s, sensor, detections, ..Scan::default() }
        })
    });
    assert!(log.sensor.bearing_max_rad == PI && log.others.is_empty());
    Log {
        sensor: half(FRAC_PI_2),
        sensor_name: "left".into(),
        nominal,
        others: vec![NamedSensor { name: "right".into(), sensor: half(-FRAC_PI_2), nominal }],
        scans: scans.collect(),
        ..log.clone()
    }
}

/// The log that a filter can process: for the EKF without clutter, in which nearest neighbours diverge and take long.
fn seen_by(filter: Filter, log: &Log) -> Log {
    if filter == EKF { unclutter(log) } else { log.clone() }
}

/// The log with only the detections within a metre of a landmark, as seen from the true poses.
fn unclutter(log: &Log) -> Log {
    let mut log = log.clone();
    let seats: Vec<Mounting> = log.sensors().map(|(_, sensor, _)| sensor.mounting).collect();
    for scan in &mut log.scans {
        let truth = truth::at(&log.truth, scan.t_s).unwrap();
        let [x, y] = truth.position;
        let [x, y, heading] = seats[scan.sensor].seat([x, y, truth.heading_rad.unwrap()]);
        scan.detections.retain(|[range, bearing]| {
            let place = [x + range * (heading + bearing).cos(), y + range * (heading + bearing).sin()];
            log.landmarks.iter().any(|landmark| (landmark[0] - place[0]).hypot(landmark[1] - place[1]) < 1.0)
        });
    }
    log
}

#[test]
fn two_half_views_estimate_what_the_full_view_does() {
    let whole = Log { scans: scenario::survey(2).scans[..320].to_vec(), ..scenario::survey(2) };
    let folder = tempfile::tempdir().unwrap();
    log_folder::write(&halved(&whole), &folder.path().join("halves")).unwrap();
    let halves = log_folder::read(&folder.path().join("halves")).unwrap();
    for filter in [Filter::Joint(Precision::F64), Filter::Core(Precision::F64), EKF] {
        let [whole, halves] = [&whole, &halves].map(|log| seen_by(filter, log));
        let run = |log: &Log| run::<Planar>(log, &informed(log), filter, 1, &mut |_| ()).unwrap().record;
        let (one, two) = (run(&whole), run(&halves));
        let apart = one
            .scans
            .iter()
            .zip(two.scans.chunks(2))
            .map(|(one, two)| (one.pose[0] - two[1].pose[0]).hypot(one.pose[1] - two[1].pose[1]));
        let squares: f64 = apart.map(|apart| apart * apart).sum();
        let rms = (squares / one.scans.len() as f64).sqrt();
        println!("{filter:?}: {rms} m, {} and {} features", one.map.len(), two.map.len());
        assert!(rms < 0.05, "{filter:?}: {rms} m apart");
        // With nearest neighbours, the order of detections decides which false landmarks are kept.
        let alike = one.map.len().abs_diff(two.map.len()) <= 3;
        assert!(alike || filter == EKF, "{} and {}", one.map.len(), two.map.len());
    }
}

/// Settings with few random numbers, so that two runs differ only by their inputs.
fn informed(log: &Log) -> Settings {
    let mut settings = Settings::for_log(log);
    (settings.filter.particles, settings.filter.proposal_sampled_fraction) = (1, 0.0);
    settings
}

#[test]
fn fixes_are_counted_and_one_far_off_is_left_out() {
    let mut log = scenario::survey_fixes(1);
    log.scans.truncate(250);
    let Some(PoseFix::Position(second)) = log.fixes.get_mut(1).map(|fix| &mut fix.measured) else { panic!() };
    second[0] += 50.0;
    assert_eq!(log.fix_noise.gate, None, "five standard deviations where nothing is said");
    for filter in [Filter::Joint(Precision::F32), Filter::Core(Precision::F32), EKF] {
        let seen = seen_by(filter, &log);
        let summary = run::<Planar>(&seen, &informed(&seen), filter, 1, &mut |_| ()).unwrap().summary;
        assert_eq!((summary.fixes, summary.fixes_left_out), (2, 1), "{filter:?}");
        assert!(summary.position_rmse_m.unwrap() < 0.5, "{filter:?}: {:?}", summary.position_rmse_m);
    }
    let refused = run::<Planar>(&log, &informed(&log), Filter::Reference, 1, &mut |_| ()).unwrap_err().to_string();
    assert!(refused.contains("the reference takes no fixes"), "{refused}");
}

/// A drive whose initial pose is wrong by 30 m and half a radian, with a fix of 0.5 m a second; the fixes have no random noise.
fn wrong_start() -> Log {
    let mut log = scenario::survey(2);
    log.fixes.clear();
    for (second, truth) in log.truth.iter().filter(|truth| truth.t_s % 1.0 < 0.05).enumerate().skip(1) {
        let off = if second % 2 == 0 { 0.3 } else { -0.3 };
        let place = truth.position.map(|at| at + off);
        log.fixes.push(Fix { t_s: truth.t_s, measured: PoseFix::Position(place) });
    }
    log.fix_noise = FixNoise { position_sigma_m: Some(0.5), ..FixNoise::default() };
    let [x, y, heading] = log.initial_pose;
    log.initial_pose = [x - 30.0, y + 3.0, heading + 0.5];
    log
}

#[test]
fn a_filter_that_is_wrong_is_put_to_fixes_that_agree_and_only_if_it_may_be() {
    let mut log = wrong_start();
    for filter in [Filter::Joint(Precision::F32), Filter::Core(Precision::F32), EKF] {
        log.fix_noise.patience_s = None;
        let seen = seen_by(filter, &log);
        let back = run::<Planar>(&seen, &informed(&seen), filter, 1, &mut |_| ()).unwrap().summary;
        assert!(back.fix_relocations >= 1 && back.fixes_left_out >= 5, "{filter:?}: {back:?}");
        log.fix_noise.patience_s = Some(f64::INFINITY);
        let seen = seen_by(filter, &log);
        let lost = run::<Planar>(&seen, &informed(&seen), filter, 1, &mut |_| ()).unwrap().summary;
        assert_eq!(lost.fix_relocations, 0, "{filter:?}");
        assert!(lost.final_position_error_m > back.final_position_error_m, "{filter:?}");
    }
}

#[test]
fn inconsistent_fixes_do_not_relocate_a_filter() {
    let mut log = wrong_start();
    log.initial_pose = scenario::survey(2).initial_pose;
    // A receiver repeats its last position for 20 s, 300 m off.
    let held = log.fixes[20].measured;
    let PoseFix::Position([x, y]) = held else { panic!() };
    log.fixes[20..40].iter_mut().for_each(|fix| fix.measured = PoseFix::Position([x + 300.0, y]));
    for filter in [Filter::Joint(Precision::F32), Filter::Core(Precision::F32), EKF] {
        let seen = seen_by(filter, &log);
        let summary = run::<Planar>(&seen, &informed(&seen), filter, 1, &mut |_| ()).unwrap().summary;
        assert!(summary.fixes_left_out >= 20 && summary.fix_relocations == 0, "{filter:?}: {summary:?}");
        assert!(summary.position_rmse_m.unwrap() < 1.0, "{filter:?}: {:?}", summary.position_rmse_m);
    }
}

/// Without detections, fixes bound the drift of the odometry.
#[test]
fn fixes_bound_the_error_of_a_filter_without_detections() {
    let mut log = scenario::survey_fixes(1);
    log.scans.iter_mut().for_each(|scan| scan.detections.clear());
    for filter in [Filter::Joint(Precision::F32), EKF] {
        let of = |log: &Log| {
            let summary = run::<Planar>(log, &informed(log), filter, 1, &mut |_| ()).unwrap().summary;
            summary.position_rmse_m.unwrap()
        };
        let (with, without) = (of(&log), of(&Log { fixes: Vec::new(), ..log.clone() }));
        println!("{filter:?}: {with} m, {without} m without");
        assert!(with < 0.9 * without, "{filter:?}: {with} m, {without} m without");
    }
}
