//! A sensor whose noise grows with the range.

use super::*;
use scphd_filters::settings::Settings;
use scphd_filters::slam::{Filter, Precision};
use scphd_log::angle::wrap;
use scphd_log::log::{Log, Nominal, Odometry, Scan, Vehicle};
use scphd_log::noise::Noise;
use scphd_worlds::scenario;
use std::f64::consts::{FRAC_PI_2, PI};

const DT_S: f64 = 0.1;
const RANGE_MAX_M: f64 = 20.0;
const DETECTION: f64 = 0.9;
/// What the sensor has, and the log states.
const STATED: Nominal = Nominal {
    range_sigma_m: Some(0.02),
    range_sigma_ratio: 0.04,
    bearing_sigma_rad: Some(0.1),
    speed_sigma_mps: Some(0.1),
    rate_sigma_radps: Some(0.05),
    steering_sigma_rad: None,
    detection_probability: Some(DETECTION),
    clutter_per_scan: Some(0.5),
};

/// Round and round a circle among landmarks, and the root mean square of the noise of all ranges, m.
fn drive(seed: u64) -> (Log, f64) {
    let mut draws = Noise::new(seed);
    let mut log = scenario::survey(1);
    log.landmarks = (0..20).map(|_| [0; 2].map(|_| draws.between(-15.0, 15.0))).collect();
    (log.vehicle, log.nominal) = (Vehicle::UnicycleArc, STATED);
    (log.sensor.range_max_m, log.initial_pose) = (RANGE_MAX_M, [6.0, 0.0, FRAC_PI_2]);
    (log.odometry, log.scans, log.truth) = (Vec::new(), Vec::new(), Vec::new());
    let (mut variances, mut count) = (0.0, 0);
    for step in 0..=600 {
        let t_s = DT_S * f64::from(step);
        let turned = 0.25 * t_s;
        let ([x, y], heading) = ([6.0 * turned.cos(), 6.0 * turned.sin()], wrap(turned + FRAC_PI_2));
        log.odometry.push(Odometry { t_s, control: [1.5 + 0.1 * draws.normal(), 0.25 + 0.05 * draws.normal(), 0.0] });
        log.truth.push(TruePose { t_s, position: [x, y], heading_rad: Some(heading) });
        let mut detections = Vec::new();
        for landmark in &log.landmarks {
            let (dx, dy) = (landmark[0] - x, landmark[1] - y);
            let range = dx.hypot(dy);
            let [range_sigma_m, bearing_sigma_rad] = STATED.sigmas_at(&log.sensor, range);
            let z =
                [range + range_sigma_m * draws.normal(), dy.atan2(dx) - heading + bearing_sigma_rad * draws.normal()];
            if range < RANGE_MAX_M && z[0] > 0.0 && draws.happens(DETECTION) {
                detections.push([z[0], wrap(z[1])]);
                (variances, count) = (variances + range_sigma_m * range_sigma_m, count + 1);
            }
        }
        for _ in 0..draws.poisson(0.5) {
            detections.push([draws.between(0.1, RANGE_MAX_M), draws.between(-PI, PI)]);
        }
        log.scans.push(Scan { t_s, detections, ..Scan::default() });
    }
    (log, (variances / f64::from(count)).sqrt())
}

/// Root mean square error of the position over all drives, m, and the mean of the medians of the pose's NEES.
fn joint(log_of: impl Fn(u64) -> Log) -> [f64; 2] {
    const DRIVES: u64 = 12;
    let (mut squares, mut nees) = (0.0, 0.0);
    // The noise was chosen on the seeds 1 to 12.
    for seed in 101..=100 + DRIVES {
        let log = log_of(seed);
        let filter = Filter::Joint(Precision::F64);
        let summary = run::<Planar>(&log, &Settings::for_log(&log), filter, seed, &mut |_| ()).unwrap().summary;
        squares += summary.position_rmse_m.unwrap().powi(2) / DRIVES as f64;
        nees += summary.nees_pose_median.unwrap() / DRIVES as f64;
    }
    [squares.sqrt(), nees]
}

#[test]
fn stated_noise_that_grows_with_the_range_is_better_than_a_constant() {
    let [stated_m, nees] = joint(|seed| drive(seed).0);
    let [constant_m, _] = joint(|seed| {
        let (mut log, constant_m) = drive(seed);
        (log.nominal.range_sigma_m, log.nominal.range_sigma_ratio) = (Some(constant_m), 0.0);
        log
    });
    assert!(stated_m < 0.9 * constant_m, "{stated_m} m, {constant_m} m with a constant");
    // The median of chi squared with three degrees of freedom, divided by three, is 0.79.
    assert!((0.6..1.0).contains(&nees), "{nees}");
}
