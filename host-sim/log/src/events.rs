//! Odometry, scans and fixes of a log in the order in which a filter needs them.

use crate::dimensions::{Dimensions, Planar};
use crate::log::Log;

/// One step of a filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event<D: Dimensions = Planar> {
    /// The vehicle moved.
    Predict {
        /// Index of the odometry row in force.
        row: usize,
        /// The control: in the plane the odometry row in force, with speed (m/s), then steering angle (rad) or turn rate (rad/s),
        /// then speed to the left (m/s).
        control: D::Control,
        /// Duration, s; above 0.
        dt_s: f64,
    },
    /// The pose itself was measured.
    Fix { fix: D::Fix },
    /// A scan was taken.
    Scan { index: usize },
}

/// Iterator over the events of a log; see [`events`].
#[derive(Debug, Clone)]
pub struct Events<'a> {
    log: &'a Log,
    now_s: f64,
    /// Number of odometry rows that have come into force.
    rows: usize,
    /// Number of scans that have been returned.
    scans: usize,
    /// Number of fixes that have been returned.
    fixes: usize,
}

/// The events of `log` in order of time, up to its last scan.
///
/// The vehicle is at the initial pose at the time of the first odometry row or the first scan, whichever is earlier. A row holds
/// until the next one; before the first row there are no predictions. A scan at the time of a row comes after all motion until
/// then and before any motion by that row: if both start at the same time, scan 0 is seen from the initial pose. The same holds
/// for a fix, which comes before a scan of the same time. Odometry and fixes after the last scan are left out.
pub fn events(log: &Log) -> Events<'_> {
    let first_row_s = log.odometry.first().map_or(f64::INFINITY, |row| row.t_s);
    let first_scan_s = log.scans.first().map_or(f64::INFINITY, |scan| scan.t_s);
    Events { log, now_s: first_row_s.min(first_scan_s), rows: 0, scans: 0, fixes: 0 }
}

impl Iterator for Events<'_> {
    type Item = Event;

    fn next(&mut self) -> Option<Event> {
        loop {
            let scan_s = self.log.scans.get(self.scans)?.t_s;
            while self.log.odometry.get(self.rows).is_some_and(|row| row.t_s <= self.now_s) {
                self.rows += 1;
            }
            let fix = self.log.fixes.get(self.fixes).filter(|fix| fix.t_s <= scan_s);
            if let Some(fix) = fix.filter(|fix| fix.t_s <= self.now_s) {
                self.fixes += 1;
                return Some(Event::Fix { fix: fix.measured });
            }
            if scan_s <= self.now_s {
                let index = self.scans;
                self.scans += 1;
                return Some(Event::Scan { index });
            }
            let due_s = fix.map_or(scan_s, |fix| fix.t_s);
            let until_s = self.log.odometry.get(self.rows).map_or(due_s, |row| row.t_s.min(due_s));
            let dt_s = until_s - self.now_s;
            self.now_s = until_s;
            if let Some(row) = self.rows.checked_sub(1) {
                return Some(Event::Predict { row, control: self.log.odometry[row].control, dt_s });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::{Fix, Odometry, PoseFix, Scan, Sensor};

    fn log(odometry: &[f64], scans: &[f64]) -> Log {
        Log {
            sensor: Sensor { range_max_m: 1.0, bearing_min_rad: -1.0, bearing_max_rad: 1.0, ..Sensor::default() },
            simulated: true,
            odometry: odometry.iter().map(|&t_s| Odometry { t_s, control: [t_s, -t_s, 0.0] }).collect(),
            scans: scans.iter().map(|&t_s| Scan { t_s, detections: vec![], ..Scan::default() }).collect(),
            ..Log::default()
        }
    }

    /// A prediction by the row with this index, of time `row_s`.
    fn moved((row, row_s): (usize, f64), dt_s: f64) -> Event {
        Event::Predict { row, control: [row_s, -row_s, 0.0], dt_s }
    }

    fn scan(index: usize) -> Event {
        Event::Scan { index }
    }

    fn all(odometry: &[f64], scans: &[f64]) -> Vec<Event> {
        events(&log(odometry, scans)).collect()
    }

    #[test]
    fn scan_k_is_seen_from_pose_k() {
        let expected = [scan(0), moved((0, 0.0), 1.0), scan(1), moved((1, 1.0), 1.0), scan(2)];
        assert_eq!(all(&[0.0, 1.0, 2.0], &[0.0, 1.0, 2.0]), expected);
    }

    #[test]
    fn rows_are_split_at_scans_and_scans_wait_for_rows() {
        let expected = [
            moved((0, 0.0), 0.5),
            moved((1, 0.5), 0.25),
            scan(0),
            moved((1, 0.5), 0.25),
            moved((2, 1.0), 0.5),
            scan(1),
        ];
        assert_eq!(all(&[0.0, 0.5, 1.0, 2.0], &[0.75, 1.5]), expected);
    }

    #[test]
    fn nothing_moves_before_the_first_row() {
        let expected = [scan(0), scan(1), moved((0, 2.0), 1.0), scan(2)];
        assert_eq!(all(&[2.0], &[0.0, 1.0, 3.0]), expected);
    }

    #[test]
    fn equal_times_make_no_empty_predict() {
        let expected = [scan(0), scan(1), moved((0, 0.0), 1.0), scan(2)];
        assert_eq!(all(&[0.0], &[0.0, 0.0, 1.0]), expected);
        let mut twice = log(&[0.0, 0.0], &[1.0]);
        twice.odometry[1].control = [7.0, 8.0, 0.0];
        let expected = [Event::Predict { row: 1, control: [7.0, 8.0, 0.0], dt_s: 1.0 }, scan(0)];
        assert_eq!(events(&twice).collect::<Vec<_>>(), expected);
    }

    #[test]
    fn the_last_row_holds_and_odometry_after_the_last_scan_is_not_used() {
        assert_eq!(all(&[0.0], &[4.0]), [moved((0, 0.0), 4.0), scan(0)]);
        assert_eq!(all(&[0.0, 5.0, 6.0], &[4.0]), [moved((0, 0.0), 4.0), scan(0)]);
        assert_eq!(all(&[], &[1.0, 2.0]), [scan(0), scan(1)]);
        assert_eq!(all(&[0.0], &[]), []);
    }

    #[test]
    fn a_fix_splits_a_row_and_comes_before_a_scan_of_its_time() {
        let mut log = log(&[0.0], &[1.0, 2.0]);
        let fix = |t_s: f64| Fix { t_s, measured: PoseFix::Heading(t_s) };
        log.fixes = vec![fix(0.25), fix(2.0), fix(2.5)];
        let told = |t_s| Event::Fix { fix: PoseFix::Heading(t_s) };
        let expected = [
            moved((0, 0.0), 0.25),
            told(0.25),
            moved((0, 0.0), 0.75),
            scan(0),
            moved((0, 0.0), 1.0),
            told(2.0),
            scan(1),
        ];
        assert_eq!(events(&log).collect::<Vec<_>>(), expected);
    }
}
