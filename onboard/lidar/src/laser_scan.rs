//! Scans with a constant angle between beams, the format of most drivers.

use crate::scan::{Beam, Scan};
use crate::settings::SettingsError;
use core::f32::consts::TAU;

/// The geometry of a laser scan: the fields of ROS's `LaserScan`, with units in their names.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sweep {
    /// Direction of the first beam, rad to the left of the lidar's axis.
    pub start_rad: f32,
    /// Angle between beams, rad; negative if clockwise. Not 0, at most 1 in magnitude.
    pub increment_rad: f32,
    /// Smaller ranges are no return, m; at least 0.
    pub range_min_m: f32,
    /// Ranges of this or more are no return, m; above the least range, may be infinite.
    pub range_max_m: f32,
    /// Time from the first beam to the last, s; 0 if all have the same time, negative if the last beam is the earliest.
    pub duration_s: f32,
}

/// A scan with a constant angle between beams: any number of beams, in either direction, over a full circle or a part of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaserScan<'a> {
    sweep: Sweep,
    ranges_m: &'a [f32],
    intensities: &'a [f32],
    is_closed: bool,
}

impl<'a> LaserScan<'a> {
    /// A scan with these ranges, m, from the first beam. Ranges that are NaN, infinite, 0 or outside the limits are no return.
    /// `intensities` has the same length, or is empty if the lidar does not measure them: reflectors can then not be distinguished.
    ///
    /// # Errors
    /// A field of the sweep is out of range, or the lengths differ.
    pub fn new(sweep: Sweep, ranges_m: &'a [f32], intensities: &'a [f32]) -> Result<Self, SettingsError> {
        let wrong = |field, range| Err(SettingsError { field, range });
        let Sweep { start_rad, increment_rad, range_min_m, range_max_m, duration_s } = sweep;
        if !start_rad.is_finite() {
            wrong("start_rad", "finite")
        } else if !(increment_rad != 0.0 && increment_rad.abs() <= 1.0) {
            wrong("increment_rad", "from -1 to 1, and not 0")
        } else if !(range_min_m >= 0.0) {
            wrong("range_min_m", "at least 0")
        } else if !(range_max_m > range_min_m) {
            wrong("range_max_m", "above range_min_m")
        } else if !duration_s.is_finite() {
            wrong("duration_s", "finite")
        } else if !(intensities.is_empty() || intensities.len() == ranges_m.len()) {
            wrong("intensities", "as many as ranges, or none")
        } else {
            // Drivers that include both ends of a circle send the same direction twice.
            let open = TAU / increment_rad.abs() - ranges_m.len() as f32 + 1.0;
            let is_closed = (-0.5..=1.5).contains(&open);
            Ok(Self { sweep, ranges_m, intensities, is_closed })
        }
    }
}

impl Scan for LaserScan<'_> {
    fn beams(&self) -> usize {
        self.ranges_m.len()
    }

    fn beam(&self, number: usize) -> Option<Beam> {
        let range_m = *self.ranges_m.get(number)?;
        let is_return = range_m > 0.0 && range_m >= self.sweep.range_min_m && range_m < self.sweep.range_max_m;
        Some(Beam {
            bearing_rad: self.sweep.start_rad + self.sweep.increment_rad * number as f32,
            range_m: if is_return && range_m.is_finite() { range_m } else { 0.0 },
            intensity: self.intensities.get(number).copied().unwrap_or(0.0),
        })
    }

    fn step_rad(&self) -> f32 {
        self.sweep.increment_rad
    }

    fn between_rad(&self, from: usize, to: usize) -> f32 {
        let steps = to as f32 - from as f32;
        let ahead = steps * self.sweep.increment_rad.abs();
        if steps < 0.0 { TAU + ahead } else { ahead }
    }

    fn before_end_s(&self, number: usize) -> f32 {
        let duration_s = self.sweep.duration_s;
        let last = self.ranges_m.len().saturating_sub(1);
        let share = if last > 0 { number as f32 / last as f32 } else { 1.0 };
        if duration_s < 0.0 { -duration_s * share } else { duration_s * (1.0 - share) }
    }

    fn is_closed(&self) -> bool {
        self.is_closed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::PI;
    use std::vec;

    const SWEEP: Sweep =
        Sweep { start_rad: -PI, increment_rad: TAU / 360.0, range_min_m: 0.1, range_max_m: 10.0, duration_s: 0.1 };

    #[test]
    fn fields_are_checked() {
        for (sweep, field) in [
            (Sweep { start_rad: f32::NAN, ..SWEEP }, "start_rad"),
            (Sweep { increment_rad: 0.0, ..SWEEP }, "increment_rad"),
            (Sweep { increment_rad: f32::NAN, ..SWEEP }, "increment_rad"),
            (Sweep { increment_rad: -1.5, ..SWEEP }, "increment_rad"),
            (Sweep { range_min_m: -1.0, ..SWEEP }, "range_min_m"),
            (Sweep { range_max_m: 0.1, ..SWEEP }, "range_max_m"),
            (Sweep { duration_s: f32::INFINITY, ..SWEEP }, "duration_s"),
        ] {
            assert_eq!(LaserScan::new(sweep, &[1.0], &[]).unwrap_err().field, field);
        }
        assert_eq!(LaserScan::new(SWEEP, &[1.0], &[1.0, 2.0]).unwrap_err().field, "intensities");
        let endless = Sweep { range_max_m: f32::INFINITY, ..SWEEP };
        assert_eq!(LaserScan::new(endless, &[f32::INFINITY], &[]).unwrap().beam(0).unwrap().range_m, 0.0);
    }

    #[test]
    fn invalid_ranges_are_no_return() {
        let ranges = [1.0, 0.0, -1.0, 0.05, 10.0, 11.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 9.99];
        let scan = LaserScan::new(SWEEP, &ranges, &[]).unwrap();
        let read: vec::Vec<f32> = (0..10).map(|beam| scan.beam(beam).unwrap().range_m).collect();
        assert_eq!(read, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 9.99]);
        assert_eq!(scan.beam(10), None);
    }

    #[test]
    fn a_circle_is_closed_with_one_or_both_ends() {
        let ranges = vec![1.0; 400];
        let is_closed = |count: usize, increment_rad: f32| {
            LaserScan::new(Sweep { increment_rad, ..SWEEP }, &ranges[..count], &[]).unwrap().is_closed()
        };
        assert!(is_closed(360, TAU / 360.0) && is_closed(360, -TAU / 360.0) && is_closed(361, TAU / 360.0));
        assert!(!is_closed(350, TAU / 360.0) && !is_closed(363, TAU / 360.0) && !is_closed(0, 0.1));
    }

    #[test]
    fn beams_have_times() {
        let ranges = [1.0; 11];
        let times = |duration_s: f32| {
            let scan = LaserScan::new(Sweep { duration_s, ..SWEEP }, &ranges, &[]).unwrap();
            [0, 5, 10].map(|beam| scan.before_end_s(beam))
        };
        assert_eq!(times(1.0), [1.0, 0.5, 0.0]);
        assert_eq!(times(-1.0), [0.0, 0.5, 1.0]);
        assert_eq!(times(0.0), [0.0; 3]);
        assert_eq!(LaserScan::new(SWEEP, &[1.0], &[]).unwrap().before_end_s(0), 0.0);
    }
}
