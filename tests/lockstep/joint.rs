//! The joint filter and its reference in lockstep: with equal inputs they must give equal results.

use scphd_filters::settings::Settings;
use scphd_filters::slam::Precision;
use scphd_log::dimensions::Planar;
use scphd_log::log::{Log, Vehicle};
use scphd_log::log_folder;
use scphd_run::compare::{JointComparison, JointDifferences, compare_joint};
use scphd_run::session::with_roomy_stack;
use scphd_shared_data::find as data_folder;
use scphd_worlds::scenario;

/// Greatest difference in double precision, in one step and over all steps of a log. Rounding gives about 1e-13; a difference of
/// formulas gives much more.
const F64_BOUND: f64 = 1e-9;

/// Greatest differences in single precision, in one step and over all steps, m.
const F32_POSITION_BOUND_M: f64 = 1e-4;
const F32_OWN_WAY_BOUND_M: f64 = 5e-3;

fn lockstep(log: &Log, precision: Precision, change: impl FnOnce(&mut Settings)) -> JointComparison {
    let mut settings = Settings::for_log(log);
    change(&mut settings);
    with_roomy_stack(|| compare_joint::<Planar>(log, &settings, precision, |_| ()))
        .expect("a thread")
        .expect("no step is refused")
}

fn assert_agreement(name: &str, overall: &JointDifferences, scans: usize) {
    let fields = [
        ("predicted position, m", overall.predicted_position_m),
        ("predicted heading, rad", overall.predicted_heading_rad),
        ("predicted covariance", overall.predicted_covariance),
        ("time since the scan, s", overall.waited_s),
        ("ln evidence", overall.ln_evidence),
        ("innovation", overall.innovation),
        ("estimated position, m", overall.estimated_position_m),
        ("estimated heading, rad", overall.estimated_heading_rad),
        ("mean", overall.mean),
        ("pose covariance", overall.pose_covariance),
        ("feature covariance", overall.feature_covariance),
        ("cross-covariance", overall.cross_covariance),
        ("existence", overall.existence),
        ("detections", overall.detections),
        ("mover's weight", overall.mover_weight),
        ("mover's mean", overall.mover_mean),
        ("mover's covariance", overall.mover_covariance),
        ("position on its own way, m", overall.own_way_position_m),
        ("heading on its own way, rad", overall.own_way_heading_rad),
    ];
    for (field, difference) in fields {
        assert!(difference <= F64_BOUND, "{name}: {field} differs by {difference:e}");
    }
    assert_eq!((overall.unmatched, overall.other_views), (0, 0), "{name}: other features");
    assert_eq!(overall.capacity_events, 0, "{name}: scans without room");
    assert_eq!(overall.scans, scans, "{name}: scans compared");
    // Empty maps would always agree.
    assert!(overall.features > 5 * scans, "{name}: only {} features were compared", overall.features);
}

fn short(name: &str, seed: u64, scans: usize) -> Log {
    let mut log = scenario::by_name(name, seed).expect("a built-in scenario");
    log.scans.truncate(scans);
    log
}

/// Compares the first `scans` scans of a published log; `model` checks that the log has the expected motion model.
fn agrees_on_excerpt(name: &str, scans: usize, model: fn(&Vehicle) -> bool) {
    let Some(folder) = data_folder(name) else { return };
    let mut log = log_folder::read(&folder).expect("a readable log");
    assert!(model(&log.vehicle), "{name} has another motion model: {:?}", log.vehicle);
    log.scans.truncate(scans);
    assert_agreement(name, &lockstep(&log, Precision::F64, |_| ()).overall, scans);
}

#[test]
fn survey_in_double_precision() {
    let log = short("survey", 1, 120);
    assert_agreement("survey", &lockstep(&log, Precision::F64, |_| ()).overall, 120);
}

#[test]
fn survey_in_single_precision() {
    let log = short("survey", 1, 120);
    let overall = lockstep(&log, Precision::F32, |_| ()).overall;
    assert!(overall.estimated_position_m <= F32_POSITION_BOUND_M, "{overall:?}");
    assert!(overall.own_way_position_m <= F32_OWN_WAY_BOUND_M, "{overall:?}");
    // The filter really computed in single precision.
    assert!(overall.estimated_position_m > F64_BOUND, "{overall:?}");
}

/// Random worlds with landmarks near each other, with shared measurements and merged features; landmarks are hidden, removed, or
/// occluded by nearer ones.
#[test]
fn worlds() {
    for (name, seed) in [("worlds-exact", 1), ("worlds", 5), ("worlds-mounted", 2)] {
        let log = short(name, seed, 200);
        let comparison = lockstep(&log, Precision::F64, |settings| {
            let joint = &mut settings.joint;
            (joint.visible_s, joint.occluded_s, joint.lifetime_s, joint.occlusion_factor) = (20.0, 5.0, 1e3, 0.3);
        });
        assert_agreement(name, &comparison.overall, 200);
    }
}

/// Noise that grows with the range, also while a loop is closed and with moving features.
#[test]
fn noise_that_grows_with_the_range() {
    for (name, seed) in [("worlds-exact", 1), ("worlds", 900_016), ("worlds-moving", 4), ("two-sensors", 1)] {
        let log = short(name, seed, 200);
        let comparison = lockstep(&log, Precision::F64, |settings| {
            settings.moving.birth_intensity = 0.2 * settings.filter.birth_intensity;
            settings.sensor.range_sigma_ratio = 0.05;
        });
        assert_agreement(name, &comparison.overall, 200);
    }
}

/// The vehicle returns to its start with an error of some decimetres among known features: for 33 and 40 scans some of them are
/// too uncertain for association, until new features are merged with them (loop closure).
#[test]
fn loop_closure() {
    for seed in [900_016, 900_024] {
        let log = short("worlds", seed, 200);
        assert_agreement("worlds", &lockstep(&log, Precision::F64, |_| ()).overall, 200);
    }
}

/// Moving features among the landmarks; births may be of either kind.
#[test]
fn what_moves() {
    for seed in [1, 4] {
        let log = short("worlds-moving", seed, 200);
        let overall = lockstep(&log, Precision::F64, |settings| settings.set_moving(true)).overall;
        assert_agreement("worlds-moving", &overall, 200);
        assert!(overall.movers > 200, "{seed}: only {} movers were compared", overall.movers);
    }
}

#[test]
fn unicycle_arc() {
    agrees_on_excerpt("phd_slam3_a00", 120, |vehicle| matches!(vehicle, Vehicle::UnicycleArc));
}

#[test]
fn unicycle() {
    agrees_on_excerpt("mrclam_ds6_robot2", 300, |vehicle| matches!(vehicle, Vehicle::Unicycle));
}

#[test]
fn ackermann() {
    agrees_on_excerpt("thesis_cmp_a00", 60, |vehicle| matches!(vehicle, Vehicle::Ackermann { .. }));
}
