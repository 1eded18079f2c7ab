//! Prediction of a detection of one scan in another.

use super::reading::Reading;
use scphd_log::angle::wrap;
use scphd_log::log::{Log, Mounting, Nominal, Scan, Sensor};

/// Gate in standard deviations.
const GATE: f64 = 3.0;

/// The sensors of a log under a reading.
pub(super) struct Sight<'a> {
    /// Each with the standard deviations of range, m, and bearing, rad, and the ratio of that of the range that grows with it.
    sensors: Vec<(&'a Sensor, [f64; 2], f64)>,
    yaw_rad: f64,
    unit_m: f64,
    sign: f64,
    absolute: bool,
}

impl<'a> Sight<'a> {
    pub(super) fn of(log: &'a Log, reading: &Reading) -> Self {
        // Without noise no two detections would match.
        let stated = |sigma: Option<f64>| sigma.filter(|sigma| *sigma > 0.0);
        let sensors = log.sensors().map(|(_, sensor, nominal)| {
            let (range_sigma_m, bearing_sigma_rad) = (stated(nominal.range_sigma_m), stated(nominal.bearing_sigma_rad));
            let [sigma_m, sigma_rad] = Nominal { range_sigma_m, bearing_sigma_rad, ..*nominal }.sigmas(sensor);
            (sensor, [reading.range * sigma_m, sigma_rad], nominal.range_sigma_ratio)
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

    /// Transforms a detection of this sensor from the first pose to the second: range, m, and bearing, rad; `None` if out of
    /// view.
    pub(super) fn carried(&self, sensor: usize, poses: [[f64; 3]; 2], [range, bearing]: [f64; 2]) -> Option<[f64; 2]> {
        let (sensor, ..) = self.sensors[sensor];
        let mounting = Mounting { yaw_rad: sensor.mounting.yaw_rad + self.yaw_rad, ..sensor.mounting };
        let [from, to] = poses.map(|pose| mounting.seat(pose));
        let [ahead_from, ahead_to] = if self.absolute { [0.0; 2] } else { [from[2], to[2]] };
        let (angle, range_m) = (ahead_from + self.sign * bearing, self.unit_m * range);
        let (x, y) = (from[0] + range_m * libm::cos(angle), from[1] + range_m * libm::sin(angle));
        let (x, y) = (x - to[0], y - to[1]);
        let (range_m, bearing_rad) = (libm::hypot(x, y), self.sign * wrap(libm::atan2(y, x) - ahead_to));
        sensor.sees(range_m / self.unit_m, bearing_rad).then_some([range_m, bearing_rad])
    }

    /// Whether a detection of the scan is within the gate of the transformed one.
    pub(super) fn meets(&self, scan: &Scan, carried: [f64; 2]) -> bool {
        self.meets_within(scan, carried, 1.0)
    }

    /// Whether a detection of the scan is within this multiple of the gate.
    fn meets_within(&self, scan: &Scan, carried: [f64; 2], gates: f64) -> bool {
        // The difference of two measurements has twice their variance.
        let is_near =
            |other: &[f64; 2]| self.are_within(scan.sensor, [self.unit_m * other[0], other[1]], carried, gates);
        scan.detections.iter().any(is_near)
    }

    /// Whether no detection can be in the gates of both.
    pub(super) fn are_apart(&self, sensor: usize, a: [f64; 2], b: [f64; 2]) -> bool {
        self.squares(sensor, a, b) > 8.0 * GATE * GATE
    }

    /// Whether both may be measurements of the same landmark.
    pub(super) fn are_near(&self, sensor: usize, a: [f64; 2], b: [f64; 2]) -> bool {
        self.are_within(sensor, a, b, 1.0)
    }

    /// Whether their distance is below this multiple of the gate.
    pub(super) fn are_within(&self, sensor: usize, a: [f64; 2], b: [f64; 2], gates: f64) -> bool {
        self.squares(sensor, a, b) < 2.0 * (gates * GATE).powi(2)
    }

    /// Standard deviations of a sensor at this range, m: range, m, and bearing, rad.
    pub(super) fn sigmas(&self, sensor: usize, range_m: f64) -> [f64; 2] {
        let (_, [sigma_m, sigma_rad], ratio) = self.sensors[sensor];
        [libm::hypot(sigma_m, ratio * range_m), sigma_rad]
    }

    /// Squared distance in standard deviations of one measurement.
    fn squares(&self, sensor: usize, a: [f64; 2], b: [f64; 2]) -> f64 {
        let [sigma_m, sigma_rad] = self.sigmas(sensor, 0.5 * (a[0] + b[0]));
        let off = [(a[0] - b[0]) / sigma_m, wrap(a[1] - b[1]) / sigma_rad];
        off[0] * off[0] + off[1] * off[1]
    }
}

/// Numbers of detections that were transformed into the view of a later scan, and of those that matched there.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Met {
    pub(super) carried: usize,
    pub(super) met: usize,
}

impl Met {
    /// Matches of one scan in another.
    pub(super) fn of(log: &Log, sight: &Sight<'_>, poses: &[[f64; 3]], pair: [usize; 2]) -> Self {
        Self::turned(log, sight, poses, pair, 1.0, 0.0)
    }

    /// Matches with this multiple of the gate, for a vehicle that turned to the right by this additional angle, rad.
    pub(super) fn turned(
        log: &Log,
        sight: &Sight<'_>,
        poses: &[[f64; 3]],
        [from, to]: [usize; 2],
        gates: f64,
        turn_rad: f64,
    ) -> Self {
        let mut met = Self::default();
        let scan = &log.scans[from];
        for &detection in &scan.detections {
            let Some([range, bearing]) = sight.carried(scan.sensor, [poses[from], poses[to]], detection) else {
                continue;
            };
            met.carried += 1;
            met.met += usize::from(sight.meets_within(&log.scans[to], [range, bearing + turn_rad], gates));
        }
        met
    }

    pub(super) fn and(self, other: Self) -> Self {
        Self { carried: self.carried + other.carried, met: self.met + other.met }
    }

    pub(super) fn share(self) -> f64 {
        self.met as f64 / self.carried.max(1) as f64
    }
}
