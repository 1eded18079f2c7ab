//! Whether detections are in the view that the log states.

use super::finding::{Findings, percent, quantile, short};
use scphd_log::angle::wrap;
use scphd_log::log::{Log, Nominal, Sensor};
use std::f64::consts::PI;

/// Noise moves a detection across the edge of the view by at most about this number of standard deviations.
const SIGMAS: f64 = 3.0;
/// Greatest share of detections out of view, which a filter takes as clutter. A normal distribution across the edge has a smaller
/// share; ten times more does harm.
const OUT_SHARE: f64 = 0.03;
/// Least number of detections.
const DETECTIONS: usize = 100;
/// A sensor whose detections use less than this share of its stated range has another range, or another unit.
const USED_SHARE: f64 = 0.1;

/// The share of the detections out of view; `None` without detections.
pub(super) fn planar(log: &Log, findings: &mut Findings) -> Option<f64> {
    let (mut all, mut out) = (0, 0);
    for (place, (name, sensor, nominal)) in log.sensors().enumerate() {
        let section =
            if name.is_empty() { "log.toml, section sensor".to_owned() } else { format!("log.toml, sensor {name}") };
        let detections: Vec<[f64; 2]> =
            log.scans.iter().filter(|scan| scan.sensor == place).flat_map(|scan| &scan.detections).copied().collect();
        let beyond = detections.iter().filter(|detection| !holds(sensor, nominal, **detection)).count();
        (all, out) = (all + detections.len(), out + beyond);
        if detections.len() < DETECTIONS {
            continue;
        }
        let share = beyond as f64 / detections.len() as f64;
        if share > OUT_SHARE {
            let column =
                |k: usize, at: f64| short(quantile(detections.iter().map(|one| one[k]).collect(), at).unwrap_or(0.0));
            findings.warn(
                "out-of-view",
                &section,
                format!(
                    "{} of the detections lie out of the stated view by more than noise; 98 % of them lie between {} m and {} m and between {} rad and \
                     {} rad",
                    percent(share),
                    column(0, 0.01),
                    column(0, 0.99),
                    column(1, 0.01),
                    column(1, 0.99)
                ),
                "set range_min_m, range_max_m, bearing_min_rad and bearing_max_rad to what the sensor shows, or check the units and the \
                 zero of the bearings (ahead, growing to the left): the filter takes what is out of view for false",
            );
        }
        if let Some(far_m) = quantile(detections.iter().map(|one| one[0]).collect(), 0.99)
            && far_m < USED_SHARE * sensor.range_max_m
        {
            findings.warn(
                "range-unit",
                &section,
                format!(
                    "99 % of the ranges are below {} m, range_max_m is {} m",
                    short(far_m),
                    short(sensor.range_max_m)
                ),
                "ranges are in metres; if they are, lower range_max_m: the filter expects detections up to there",
            );
        }
    }
    (all > 0).then(|| f64::from(out as u32) / all as f64)
}

/// Whether a detection is in view, with a margin for noise.
fn holds(sensor: &Sensor, nominal: &Nominal, [range_m, bearing_rad]: [f64; 2]) -> bool {
    let [slack_m, slack_rad] = nominal.sigmas_at(sensor, range_m).map(|sigma| SIGMAS * sigma);
    if !(sensor.range_min_m - slack_m..=sensor.range_max_m + slack_m).contains(&range_m) {
        return false;
    }
    let half_rad = 0.5 * (sensor.bearing_max_rad - sensor.bearing_min_rad) + slack_rad;
    let middle_rad = 0.5 * (sensor.bearing_max_rad + sensor.bearing_min_rad);
    half_rad >= PI || wrap(bearing_rad - middle_rad).abs() <= half_rad
}
