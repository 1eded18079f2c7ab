use super::candidates::candidates;
use super::innovations::innovations;
use super::{Effort, Group, Plan, Said, TuneError, scans_between, tune};
use crate::session::Filter;
use scphd_filters::settings::Settings;
use scphd_filters::slam::Precision;
use scphd_log::dimensions::{Planar, Underwater};
use scphd_log::log::Log;
use scphd_worlds::scenario;
use std::sync::atomic::{AtomicUsize, Ordering};

const FILTER: Filter = Filter::Core(Precision::F64);

/// Settings with every noise wrong by a factor.
fn misjudged(log: &Log, factor: f64) -> Settings {
    let mut settings = Settings::for_log(log);
    settings.filter.particles = 8;
    settings.sensor.range_sigma_m *= factor;
    settings.sensor.bearing_sigma_rad *= factor;
    settings.sensor.clutter_per_scan /= factor;
    settings.sensor.detection_near = 0.8;
    settings.sensor.detection_far = 0.8;
    settings.vehicle.speed_sigma_mps *= factor;
    settings.vehicle.turn_sigma *= factor;
    settings
}

fn value<S: serde::Serialize>(settings: &S, field: &str) -> f64 {
    super::change::size_of(settings, field).unwrap()
}

/// The estimates from the innovations of the first scans after a number of rounds.
fn said(log: &Log, settings: &Settings, scans: usize, rounds: usize, count: &(dyn Fn() + Sync)) -> Vec<Said> {
    let plan = Plan { learn: 0..scans, rounds, ..plan(log, 1) };
    innovations::<Planar>(log, settings, &plan, count).unwrap()
}

#[test]
fn the_noise_of_a_simulation_is_found_from_smaller_and_greater_values() {
    let log = scenario::survey(3);
    let truth = Settings::for_log(&log);
    for factor in [0.5, 2.0] {
        let rounds = AtomicUsize::new(0);
        let count = || {
            rounds.fetch_add(1, Ordering::Relaxed);
        };
        let said = said(&log, &misjudged(&log, factor), log.scans.len(), 3, &count);
        assert_eq!(rounds.into_inner(), 3);
        for said in &said {
            let tolerance = match said.field {
                field if field.starts_with("vehicle.") => 0.15,
                field if field.contains("detection") => 0.05,
                _ => 0.1,
            };
            let expected = value(&truth, said.field);
            let found = said.to.unwrap();
            assert!((found - expected).abs() <= tolerance * expected, "from {factor}: {said:#?}");
            assert!(said.observations > 500 && !said.clamped, "{said:#?}");
        }
    }
}

#[test]
fn a_limiting_bound_is_reported() {
    let mut log = scenario::survey(3);
    let settings = misjudged(&log, 3.0);
    // The sensor is better than its default settings.
    log.simulated = false;
    log.nominal.range_sigma_m = Some(0.4);
    let said = said(&log, &settings, log.scans.len(), 1, &|| ());
    let range = said.iter().find(|said| said.field == "sensor.range_sigma_m").unwrap();
    assert!(range.clamped, "{range:#?}");
    // The data sheet's noise, plus that of the default settings.
    let scheme = value(&Settings::for_log(&log), "sensor.range_sigma_m");
    assert!((scheme - 0.6).abs() < 1e-12);
    assert_eq!(range.to, Some(scheme));
    // Default settings are not changed by the bound.
    let settings = Settings { sensor: Settings::for_log(&log).sensor, ..settings };
    let unchanged = Said { now: scheme, ..range.clone() };
    assert_eq!(candidates::<Planar>(&log, &settings, &[unchanged]), []);
}

#[test]
fn too_few_observations_change_nothing() {
    let log = scenario::survey(3);
    let said = said(&log, &Settings::for_log(&log), 2, 1, &|| ());
    // 60 detections are enough for the clutter only.
    for said in said {
        assert_eq!(said.to.is_some(), said.field == "sensor.clutter_per_scan", "{said:#?}");
    }
}

fn plan(log: &Log, runs: u64) -> Plan {
    let half = 0..log.scans.len() / 2;
    Plan { filter: FILTER, learn: half, rounds: 2, effort: Effort { seed: 1, runs, jobs: 2 } }
}

/// The two halves of the log are of different sensors: settings learnt from the first are worse in the second.
#[test]
fn settings_that_are_worse_on_the_rest_are_refused() {
    let log = changing();
    let settings = misjudged(&log, 1.0);
    let tuned = tune::<Planar>(&log, &settings, &plan(&log, 2), &|| (), None).unwrap();
    let clutter = tuned.said.iter().find(|said| said.field == "sensor.clutter_per_scan").unwrap();
    assert!(clutter.to.is_some(), "something is proposed: {:#?}", tuned.said);
    assert_eq!(tuned.outcome.proposed(), None);
    assert_eq!(tuned.outcome.settings, settings);
    let of_sensor = tuned.outcome.tried.iter().find(|tried| tried.candidate.group == Group::Sensor).unwrap();
    assert!(of_sensor.gain.is_some_and(|gain| gain.mean < 0.0) && !of_sensor.wins, "{of_sensor:#?}");
}

/// A survey whose first half is as measured by a sensor without noise, misses and clutter.
fn changing() -> Log {
    let mut log = scenario::survey(3);
    let half = log.scans.len() / 2;
    for scan in &mut log.scans[..half] {
        let Some(truth) = scphd_log::truth::at(&log.truth, scan.t_s) else { continue };
        let heading = truth.heading_rad.unwrap();
        scan.detections = log
            .landmarks
            .iter()
            .map(|landmark| {
                let (dx, dy) = (landmark[0] - truth.position[0], landmark[1] - truth.position[1]);
                [dx.hypot(dy), scphd_log::angle::wrap(dy.atan2(dx) - heading)]
            })
            .filter(|[range, _]| *range < log.sensor.range_max_m)
            .collect();
        scan.labels.clear();
    }
    log
}

#[test]
fn wrong_settings_are_corrected_without_the_truth() {
    let log = scenario::survey(3);
    let mut far_off = misjudged(&log, 1.0);
    far_off.vehicle.speed_sigma_mps = 0.05;
    far_off.vehicle.turn_sigma = 0.002;
    let tuned = tune::<Planar>(&log, &far_off, &plan(&log, 1), &|| (), None).unwrap();
    let best = tuned.outcome.best.as_ref().unwrap();
    assert!(best.confirmed, "{:#?}", tuned.outcome.tried);
    let error = |runs| super::position_rmse_m(runs).unwrap();
    assert!(error(&best.then) < error(&best.now), "{} {}", error(&best.then), error(&best.now));
    let blind = Log { truth: Vec::new(), landmarks: Vec::new(), ..log.clone() };
    let again = tune::<Planar>(&blind, &far_off, &plan(&blind, 1), &|| (), None).unwrap();
    assert_eq!(again.outcome.settings, tuned.outcome.settings);
    assert_eq!(again.outcome.best.unwrap().gain, best.gain);
}

#[test]
fn a_part_of_the_log_is_held_out() {
    let log = scenario::survey(3);
    let last = log.scans.last().unwrap().t_s - log.scans[0].t_s;
    assert_eq!(scans_between::<Planar>(&log, 0.0, f64::INFINITY), 0..log.scans.len());
    assert_eq!(scans_between::<Planar>(&log, 2.0 * last, 1.0).len(), 0);
    let two = scans_between::<Planar>(&log, 0.05, 0.25);
    assert!(two.clone().all(|k| (0.05..0.25).contains(&(log.scans[k].t_s - log.scans[0].t_s))) && !two.is_empty());
    for learn in [0..0, 0..log.scans.len()] {
        let plan = Plan { learn, ..plan(&log, 1) };
        let refused = tune::<Planar>(&log, &Settings::for_log(&log), &plan, &|| (), None);
        assert!(matches!(refused, Err(TuneError::EmptyPart)));
    }
}

#[test]
fn births_follow_clutter_and_the_odometry_noise_of_a_real_log_is_not_lowered() {
    let mut log = scenario::survey(3);
    let settings = Settings::for_log(&log);
    let says = |field, factor: f64| {
        let now = value(&settings, field);
        Said { field, now, to: Some(factor * now), clamped: false, observations: 100 }
    };
    let groups = |log: &Log, said: &[Said]| {
        candidates::<Planar>(log, &settings, said).iter().map(|candidate| candidate.group).collect::<Vec<_>>()
    };
    let clutter = says("sensor.clutter_per_scan", 0.25);
    let all = candidates::<Planar>(&log, &settings, std::slice::from_ref(&clutter));
    let half = all.iter().find(|candidate| (candidate.group, &*candidate.how) == (Group::Clutter, "half way")).unwrap();
    let change = |field: &str| half.changes.iter().find(|change| change.field == field).unwrap().size().unwrap();
    assert!((change("sensor.clutter_per_scan") / settings.sensor.clutter_per_scan - 0.5).abs() < 1e-12);
    assert!((change("filter.birth_intensity") / settings.filter.birth_intensity - 0.5).abs() < 1e-12);
    let less = [says("vehicle.speed_sigma_mps", 0.5), clutter.clone()];
    let more = [says("vehicle.speed_sigma_mps", 2.0), clutter];
    assert!(groups(&log, &less).contains(&Group::Odometry));
    log.simulated = false;
    assert!(!groups(&log, &less).contains(&Group::Odometry) && !groups(&log, &less).contains(&Group::Together));
    assert!(groups(&log, &more).contains(&Group::Odometry) && groups(&log, &more).contains(&Group::Together));
}

/// The tank with twice the pixel noise, half the false measurements and a smaller detection probability than the true ones.
fn misjudged_tank(log: &scphd_log::underwater::Log) -> scphd_filters::underwater::settings::Settings {
    let mut settings = scphd_filters::underwater::settings::Settings::for_real_log(log);
    settings.camera.pixel_sigmas = log.camera.pixel_sigmas.map(|sigma| 2.0 * sigma);
    settings.camera.common_sigmas = log.camera.common_sigmas.map(|sigma| 2.0 * sigma);
    settings.camera.clutter_per_scan = 10.0;
    settings.filter.birth_intensity *= 0.5;
    settings.camera.detection = 0.6;
    settings
}

/// The estimates from the innovations of the tank with wrong settings.
fn said_of(log: &scphd_log::underwater::Log) -> Vec<Said> {
    let plan = Plan { filter: FILTER, learn: 0..400, rounds: 3, effort: Effort { seed: 1, runs: 1, jobs: 1 } };
    let said = innovations::<Underwater>(log, &misjudged_tank(log), &plan, &|| ()).unwrap();
    println!("{said:#?}");
    said
}

fn found(said: &[Said], field: &str) -> f64 {
    said.iter().find(|said| said.field == field).unwrap().to.unwrap()
}

#[test]
fn the_noise_of_a_simulation_is_found_in_space() {
    let mut log = scphd_worlds::underwater::tank::girona_tank(1);
    log.scans.truncate(400);
    log.camera.common_sigmas = [0.0; 2];
    let said = said_of(&log);
    assert!((found(&said, "camera.pixel_sigmas") / 3.0 - 1.0).abs() < 0.15);
    // Half of the features are seldom detected: well known ones are detected more often than the mean of all.
    assert!((0.7..0.95).contains(&found(&said, "camera.detection")));
    // Seldom detected ones count as clutter until they are features.
    assert!((15.0..40.0).contains(&found(&said, "camera.clutter_per_scan")));
    // The common noise is zero and cannot be scaled, and the velocity noise of the tank is as stated.
    assert!(said.iter().all(|said| said.field != "camera.common_sigmas" || said.now == 0.0));
}

#[test]
fn the_common_noise_of_both_images_is_scaled_with_the_rest() {
    let mut log = scphd_worlds::underwater::tank::girona_tank(1);
    log.scans.truncate(400);
    let said = said_of(&log);
    let over_true = |field: &str, sigma: f64| found(&said, field) / sigma;
    // A wrong tilt moves all pairs of a frame together, and the pose follows: innovations show only a part of it.
    assert!((0.75..1.1).contains(&over_true("camera.pixel_sigmas", log.camera.pixel_sigmas[0])));
    assert!((0.75..1.1).contains(&over_true("camera.common_sigmas", log.camera.common_sigmas[0])));
}

#[test]
fn settings_that_are_worse_on_the_rest_are_refused_in_space() {
    let mut log = scphd_worlds::underwater::tank::girona_tank(1);
    // The first lawnmower covers the floor out and back; the part to learn from is of a sensor without misses and noise.
    log.scans.truncate(300);
    let settings = scphd_filters::underwater::settings::Settings::for_real_log(&log);
    for scan in &mut log.scans[..100] {
        scan.detections.truncate(1);
    }
    let plan = Plan { filter: FILTER, learn: 0..100, rounds: 1, effort: Effort { seed: 1, runs: 1, jobs: 2 } };
    let tuned = tune::<Underwater>(&log, &settings, &plan, &|| (), None).unwrap();
    assert_eq!((tuned.outcome.proposed(), &tuned.outcome.settings), (None, &settings));
    assert!(tuned.said.iter().any(|said| said.to.is_some()), "{:#?}", tuned.said);
}

/// Ranges that mean "no return" are not measurements, and no noise can be learnt from them.
#[test]
fn a_log_with_ranges_of_no_return_is_refused() {
    let mut log = scenario::survey(3);
    let settings = Settings::for_log(&log);
    log.scans.iter_mut().for_each(|scan| scan.detections.push([14.96, 0.3]));
    let refused = tune::<Planar>(&log, &settings, &plan(&log, 1), &|| (), None).unwrap_err();
    assert!(matches!(&refused, TuneError::Unfit(why) if why.contains("14.96")), "{refused}");
    // A sensor with few digits repeats many ranges.
    let mut coarse = scenario::survey(3);
    let round = |[range, _]: &mut [f64; 2]| *range = (*range).round();
    coarse.scans.iter_mut().for_each(|scan| scan.detections.iter_mut().for_each(round));
    assert_eq!(super::planar::no_returns(&coarse), None);
}
