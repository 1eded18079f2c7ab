//! Learning for vehicles in the plane.

use super::learn::{Added, CoreEye, Eye, Learn, NoiseOf};
use nalgebra::DMatrix;
use scphd::models::PlanarPose;
use scphd_filters::settings::{SensorSettings, Settings};
use scphd_filters::slam::{Refusal, range_bearing};
use scphd_log::angle::wrap;
use scphd_log::dimensions::Planar;
use scphd_log::log::{Log, Vehicle};
use std::f64::consts::PI;

/// A range means "no return" if more than this share of all detections has it to the last digit, …
const REPEATED_SHARE: f64 = 0.02;
/// … at least this many times as often as any other range (a sensor with few digits repeats many), …
const OFTENER: usize = 10;
/// … and at most this share of the detections is farther.
const BEYOND_SHARE: f64 = 0.02;

/// The range that means "no return", if there is one, m, the number of detections with it, and of all.
pub(super) fn no_returns(log: &Log) -> Option<(f64, usize, usize)> {
    let mut ranges: Vec<f64> =
        log.scans.iter().flat_map(|scan| scan.detections.iter().map(|[range, _]| *range)).collect();
    ranges.sort_by(f64::total_cmp);
    let mut counts: Vec<(f64, usize)> = ranges.chunk_by(|a, b| a == b).map(|same| (same[0], same.len())).collect();
    counts.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
    let (&(range_m, count), next) = (counts.first()?, counts.get(1).map_or(0, |&(_, count)| count));
    let stands_out = count as f64 > REPEATED_SHARE * ranges.len() as f64 && count >= OFTENER * next.max(1);
    let beyond = ranges.len() - ranges.partition_point(|range| *range <= range_m);
    (stands_out && beyond as f64 <= BEYOND_SHARE * ranges.len() as f64).then_some((range_m, count, ranges.len()))
}

impl Learn for Planar {
    const ODOMETRY: [&'static [&'static str]; 2] = [
        &["vehicle.speed_sigma_mps", "vehicle.speed_sigma_ratio"],
        &["vehicle.turn_sigma", "vehicle.turn_sigma_ratio"],
    ];
    const NOISE: &'static [NoiseOf] = &[
        NoiseOf { fields: &["sensor.range_sigma_m", "sensor.range_sigma_ratio"], coordinates: &[0] },
        NoiseOf { fields: &["sensor.bearing_sigma_rad"], coordinates: &[1] },
    ];
    const DETECTION: &'static [&'static str] = &["sensor.detection_near", "sensor.detection_far"];
    const CLUTTER: &'static str = "sensor.clutter_per_scan";

    fn unfit(log: &Log) -> Option<String> {
        let (range_m, count, all) = no_returns(log)?;
        Some(format!(
            "{count} of {all} detections have the range {range_m} m to the last digit, which is how a sensor says that nothing came back; noise that is \
             learnt from them is none: take them out of detections.csv"
        ))
    }

    fn is_simulated(log: &Log) -> bool {
        log.simulated
    }

    fn states(log: &Log, field: &str) -> bool {
        match field {
            "sensor.range_sigma_m" => log.nominal.range_sigma_m.is_some(),
            "sensor.range_sigma_ratio" => log.nominal.range_sigma_ratio > 0.0,
            "sensor.bearing_sigma_rad" => log.nominal.bearing_sigma_rad.is_some(),
            _ => false,
        }
    }

    fn scheme(log: &Log) -> Settings {
        Settings::for_log(log)
    }

    fn view_measure(log: &Log) -> f64 {
        let sensor = &log.sensor;
        let width = sensor.bearing_max_rad - sensor.bearing_min_rad;
        0.5 * width * (sensor.range_max_m.powi(2) - sensor.range_min_m.powi(2))
    }

    fn reach_m(_log: &Log, settings: &Settings) -> f64 {
        settings.sensor.range_max_m
    }

    fn added(log: &Log, settings: &Settings, control: &[f64; 3], dt_s: f64) -> Added {
        let noise = &settings.vehicle;
        let &[ahead, turn, left] = control;
        let speed = ahead.hypot(left).copysign(ahead);
        // A lasting error accumulates over its duration.
        let lasts_s = noise.noise_interval_s * settings.filter.interval_margin;
        let lasting = dt_s * if lasts_s > 0.0 { lasts_s } else { dt_s };
        let variance = |constant: f64, ratio: f64, value: f64| constant.powi(2) + (ratio * value).powi(2);
        let of_speed = variance(noise.speed_sigma_mps, noise.speed_sigma_ratio, speed) * lasting;
        let of_turn = variance(noise.turn_sigma, noise.turn_sigma_ratio, turn) * lasting;
        // ∂ heading rate / ∂ control.
        let [by_speed, by_turn] = match log.vehicle {
            Vehicle::Ackermann { wheelbase_m, .. } => {
                [turn.tan() / wheelbase_m, speed / (wheelbase_m * turn.cos().powi(2))]
            }
            Vehicle::Unicycle | Vehicle::UnicycleArc | Vehicle::Holonomic => [0.0, 1.0],
        };
        Added { along: of_speed, turned: [of_speed * by_speed * by_speed, of_turn * by_turn * by_turn] }
    }

    fn eye<'a>(log: &'a Log, settings: &'a Settings) -> Result<Box<dyn Eye<Self> + 'a>, Refusal> {
        if !log.others.is_empty() {
            return Err(Refusal("tune learns of one sensor, and the log has several".into()));
        }
        let view = &settings.sensor;
        Ok(Box::new(CoreEye {
            sensor: range_bearing::<f64>(view)?,
            seat: Box::new(|_, pose: &[f64; 3]| seat(*pose, view)),
            inside: Box::new(|&[range, bearing]: &[f64; 2]| is_inside(view, range, bearing).then_some(range)),
        }))
    }
}

/// The pose of the sensor from that of the vehicle, and its derivatives by the vehicle's.
fn seat([x, y, heading]: [f64; 3], view: &SensorSettings) -> (PlanarPose<f64>, Option<DMatrix<f64>>) {
    let [seat_x, seat_y, seat_heading] = view.mounting().seat([x, y, heading]);
    let by_vehicle = [1.0, 0.0, y - seat_y, 0.0, 1.0, seat_x - x, 0.0, 0.0, 1.0];
    (PlanarPose::new(seat_x, seat_y, seat_heading), Some(DMatrix::from_row_slice(3, 3, &by_vehicle)))
}

/// Whether a measurement is far enough inside the view that its soft edges have no effect.
fn is_inside(sensor: &SensorSettings, range: f64, bearing: f64) -> bool {
    let edge = sensor.range_edge_m.max(2.0 * sensor.range_sigma_at(range));
    let full_circle = sensor.bearing_half_width_rad() >= PI;
    let aside = wrap(bearing - sensor.bearing_center_rad()).abs();
    range > sensor.range_min_m + edge
        && range < sensor.range_max_m - edge
        && (full_circle || aside < sensor.bearing_half_width_rad() - sensor.bearing_edge_rad)
}
