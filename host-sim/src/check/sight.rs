//! What a detection of one scan should be in another.

use super::reading::Reading;
use crate::angle::wrap;
use crate::log::{Log, Mounting, Nominal, Scan, Sensor};

/// Gate in standard deviations.
const GATE: f64 = 3.0;

/// The sensors of a log, as a reading takes them.
pub(super) struct Sight<'a> {
    /// Each, with the standard deviations of range, m, and bearing, rad.
    sensors: Vec<(&'a Sensor, [f64; 2])>,
    yaw_rad: f64,
    unit_m: f64,
    sign: f64,
    absolute: bool,
}

impl<'a> Sight<'a> {
    pub(super) fn of(log: &'a Log, reading: &Reading) -> Self {
        // Without noise no two detections would agree.
        let stated = |sigma: Option<f64>| sigma.filter(|sigma| *sigma > 0.0);
        let sensors = log.sensors().map(|(_, sensor, nominal)| {
            let (range_sigma_m, bearing_sigma_rad) = (stated(nominal.range_sigma_m), stated(nominal.bearing_sigma_rad));
            let [sigma_m, sigma_rad] = Nominal { range_sigma_m, bearing_sigma_rad, ..*nominal }.sigmas(sensor);
            (sensor, [reading.range * sigma_m, sigma_rad])
        });
        let sign = if reading.mirrored { -1.0 } else { 1.0 };
        Self {
            sensors: sensors.collect(),
            yaw_rad: reading.yaw_rad,
            unit_m: reading.range,
            sign,
            absolute: reading.absolute,
        }
    }

    /// A detection of this sensor at the first pose, as it should be at the second: range, m, and bearing, rad; `None` where it is out of view.
    pub(super) fn carried(&self, sensor: usize, poses: [[f64; 3]; 2], [range, bearing]: [f64; 2]) -> Option<[f64; 2]> {
        let (sensor, _) = self.sensors[sensor];
        let mounting = Mounting { yaw_rad: sensor.mounting.yaw_rad + self.yaw_rad, ..sensor.mounting };
        let [from, to] = poses.map(|pose| mounting.seat(pose));
        let [ahead_from, ahead_to] = if self.absolute { [0.0; 2] } else { [from[2], to[2]] };
        let (angle, range_m) = (ahead_from + self.sign * bearing, self.unit_m * range);
        let (x, y) = (from[0] + range_m * libm::cos(angle), from[1] + range_m * libm::sin(angle));
        let (x, y) = (x - to[0], y - to[1]);
        let (range_m, bearing_rad) = (libm::hypot(x, y), self.sign * wrap(libm::atan2(y, x) - ahead_to));
        sensor.sees(range_m / self.unit_m, bearing_rad).then_some([range_m, bearing_rad])
    }

    /// Whether one of a scan's detections is near what was carried there.
    pub(super) fn meets(&self, scan: &Scan, carried: [f64; 2]) -> bool {
        // The difference of two measurements has twice their variance.
        let is_near = |other: &[f64; 2]| {
            self.squares(scan.sensor, [self.unit_m * other[0], other[1]], carried) < 2.0 * GATE * GATE
        };
        scan.detections.iter().any(is_near)
    }

    /// Whether no detection is near both.
    pub(super) fn are_apart(&self, sensor: usize, a: [f64; 2], b: [f64; 2]) -> bool {
        self.squares(sensor, a, b) > 8.0 * GATE * GATE
    }

    /// Squared distance in standard deviations of one measurement.
    fn squares(&self, sensor: usize, a: [f64; 2], b: [f64; 2]) -> f64 {
        let (_, [sigma_m, sigma_rad]) = self.sensors[sensor];
        let off = [(a[0] - b[0]) / sigma_m, wrap(a[1] - b[1]) / sigma_rad];
        off[0] * off[0] + off[1] * off[1]
    }
}
