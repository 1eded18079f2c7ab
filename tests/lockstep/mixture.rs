//! The mixture filter and its reference in lockstep: with equal inputs they must give equal results.

use scphd_filters::settings::{Proposal, Settings};
use scphd_filters::slam::Precision;
use scphd_log::dimensions::Planar;
use scphd_log::log::{Log, Vehicle};
use scphd_log::log_folder;
use scphd_run::compare::{Comparison, Differences, compare};
use scphd_run::session::with_roomy_stack;
use scphd_shared_data::find as data_folder;
use scphd_worlds::scenario;

/// Greatest difference in double precision in one step, relative or in m and rad. Rounding gives about 1e-13; a difference of
/// formulas gives much more.
const F64_BOUND: f64 = 1e-9;

/// Greatest difference of the estimated pose in single precision in one step, m.
const F32_POSITION_BOUND_M: f64 = 0.01;

const SEED: u64 = 1;

fn lockstep(log: &Log, particles: usize, samples: usize, precision: Precision) -> Comparison {
    lockstep_with(log, particles, samples, precision, |_| ())
}

/// Lockstep with changed settings.
fn lockstep_with(
    log: &Log,
    particles: usize,
    samples: usize,
    precision: Precision,
    change: impl FnOnce(&mut Settings),
) -> Comparison {
    let mut settings = Settings::for_log(log);
    settings.filter.particles = particles;
    settings.filter.samples = samples;
    settings.restrict_to_reference();
    change(&mut settings);
    with_roomy_stack(|| compare::<Planar>(log, &settings, precision, SEED, |_| ()))
        .expect("a thread")
        .expect("no step is refused")
}

fn assert_agreement(name: &str, overall: &Differences, scans: usize) {
    let fields = [
        ("predicted position, m", overall.predicted_position_m),
        ("predicted heading, rad", overall.predicted_heading_rad),
        ("ln likelihood", overall.ln_likelihood),
        ("particle weight", overall.particle_weight),
        ("component weight", overall.component_weight),
        ("mean", overall.mean),
        ("covariance", overall.covariance),
        ("mass", overall.mass),
        ("time since the scan, s", overall.waited_s),
        ("estimated position, m", overall.estimated_position_m),
        ("estimated heading, rad", overall.estimated_heading_rad),
    ];
    for (field, difference) in fields {
        assert!(difference <= F64_BOUND, "{name}: {field} differs by {difference:e}");
    }
    assert_eq!(overall.unmatched, 0, "{name}: components without a counterpart");
    assert_eq!(overall.other_survivors, 0, "{name}: scans with other survivors");
    assert_eq!(overall.capacity_events, 0, "{name}: scans without room, which need not agree");
    assert_eq!(overall.scans, scans, "{name}: scans compared");
    // Empty maps would always agree.
    assert!(overall.components > scans, "{name}: only {} components were compared", overall.components);
}

/// Compares the filter with the reference on the first `scans` scans of a published log. `model` checks that the log has the
/// expected motion model.
fn agrees_on_excerpt(name: &str, scans: usize, particles: usize, model: fn(&Vehicle) -> bool) {
    let Some(folder) = data_folder(name) else { return };
    let mut log = log_folder::read(&folder).expect("a readable log");
    assert!(model(&log.vehicle), "{name} has another motion model: {:?}", log.vehicle);
    log.scans.truncate(scans);
    let comparison = lockstep(&log, particles, 2, Precision::F64);
    assert_agreement(name, &comparison.overall, scans);
}

#[test]
fn survey_in_double_precision() {
    let log = scenario::by_name("survey", SEED).expect("a built-in scenario");
    let comparison = lockstep(&log, 32, 2, Precision::F64);
    assert_agreement("survey", &comparison.overall, log.scans.len());
}

#[test]
fn survey_in_single_precision() {
    let log = scenario::by_name("survey", SEED).expect("a built-in scenario");
    let comparison = lockstep(&log, 32, 2, Precision::F32);
    assert_eq!(comparison.scans.len(), log.scans.len());
    for (scan, differences) in comparison.scans.iter().enumerate() {
        let difference = differences.estimated_position_m;
        assert!(difference <= F32_POSITION_BOUND_M, "scan {scan}: the estimated position differs by {difference} m");
    }
}

/// Noise that grows with the range, of static and moving features.
#[test]
fn noise_that_grows_with_the_range() {
    let mut log = scenario::by_name("thesis-dynamic", SEED).expect("a built-in scenario");
    log.scans.truncate(150);
    let comparison = lockstep_with(&log, 16, 2, Precision::F64, |settings| {
        settings.moving.birth_intensity = settings.filter.birth_intensity;
        settings.sensor.range_sigma_ratio = 0.05;
    });
    assert_agreement("thesis-dynamic", &comparison.overall, 150);
}

/// Moving and static features, over a whole scenario.
#[test]
fn moving_features() {
    let log = scenario::by_name("thesis-dynamic", SEED).expect("a built-in scenario");
    let comparison = lockstep_with(&log, 16, 2, Precision::F64, |settings| {
        settings.moving.birth_intensity = settings.filter.birth_intensity;
    });
    assert_agreement("thesis-dynamic", &comparison.overall, log.scans.len());
    let moving = comparison.overall.moving_components;
    assert!(moving > log.scans.len(), "only {moving} moving components were compared");
}

/// Confirmed features are kept after missed detections, as by default on logs with little clutter.
#[test]
fn remembered_features() {
    let mut log = scenario::by_name("survey", SEED).expect("a built-in scenario");
    log.scans.truncate(150);
    let remembering = |weight| {
        let comparison = lockstep_with(&log, 8, 2, Precision::F64, |settings| {
            let filter = &mut settings.filter;
            (filter.confirming_detections, filter.confirmed_weight) = (3.0, weight);
            settings.sensor.detection_near = 0.7;
            settings.sensor.detection_far = 0.7;
        });
        assert_agreement("survey", &comparison.overall, log.scans.len());
        comparison.overall.components
    };
    let (forgotten, remembered) = (remembering(0.0), remembering(0.2));
    assert!(remembered > forgotten, "{remembered} and {forgotten} components were compared");
}

/// A sensor with a mounting other than the vehicle's pose.
#[test]
fn mounted_sensor() {
    let mut log = scenario::by_name("survey", SEED).expect("a built-in scenario");
    log.scans.truncate(100);
    let comparison = lockstep_with(&log, 8, 2, Precision::F64, |settings| {
        let sensor = &mut settings.sensor;
        (sensor.forward_m, sensor.left_m, sensor.yaw_rad) = (-1.3, 0.4, 2.6);
    });
    assert_agreement("survey", &comparison.overall, log.scans.len());
}

#[test]
fn unicycle_arc() {
    agrees_on_excerpt("phd_slam3_a00", 120, 6, |vehicle| matches!(vehicle, Vehicle::UnicycleArc));
}

#[test]
fn unicycle() {
    agrees_on_excerpt("mrclam_ds6_robot2", 120, 6, |vehicle| matches!(vehicle, Vehicle::Unicycle));
}

#[test]
fn ackermann() {
    agrees_on_excerpt("thesis_cmp_a00", 40, 6, |vehicle| matches!(vehicle, Vehicle::Ackermann { .. }));
}

/// A setting without a counterpart in the reference is refused.
#[test]
fn an_informed_proposal_has_no_counterpart() {
    let log = scenario::by_name("survey", SEED).expect("a built-in scenario");
    let mut settings = Settings::for_log(&log);
    settings.filter.proposal = Proposal::Informed;
    let refusal = with_roomy_stack(|| compare::<Planar>(&log, &settings, Precision::F64, SEED, |_| ()))
        .expect("a thread")
        .unwrap_err();
    assert!(refusal.to_string().contains("blind"), "{refusal}");
}
