//! Checks of the units of numbers.
//!
//! Numbers that are physically impossible for vehicles or sensors are refused, with the unit that would explain them. The bounds
//! are far beyond any log that a filter could use, so that they detect only wrong units:
//!
//! | quantity | bound | reason |
//! |---|---|---|
//! | median time between rows of odometry | 5 s | a row holds until the next one; at walking pace that is the width of a street |
//! | median time between scans | 60 s | sonars that turn are the slowest sensors, and need a third of that |
//! | median distance between two scans | twice the greatest range | beyond it no two scans show the same landmarks |
//! | most scans | between the first and the last row of odometry | otherwise the clocks or units differ |
//! | median range | twice the greatest range | beyond it most measurements would be out of range |
//! | bearing | π | the greatest angle between two directions |
//! | edges of the view, initial heading | 2π | both may be counted from 0 |
//! | steering angle | less than π/2 | the wheels would be perpendicular to the vehicle |

use super::error::{LogError, Place, Problem};
use std::f64::consts::{FRAC_PI_2, PI};

/// Tolerance for π with few digits, rad.
const SLACK_RAD: f64 = 1e-3;
/// Greatest bearing, rad.
pub(super) const HALF_TURN_RAD: f64 = PI + SLACK_RAD;
/// Greatest edge of a view and heading, rad.
pub(super) const WHOLE_TURN_RAD: f64 = 2.0 * PI + SLACK_RAD;
/// Greatest plausible unwrapped angle, rad; beyond, angles are in degrees.
const COUNTED_RAD: f64 = 4.0 * PI;
pub(super) const ODOMETRY_INTERVAL_S: f64 = 5.0;
pub(super) const SCAN_INTERVAL_S: f64 = 60.0;
/// A common interval of rows, s; the unit that comes nearest to it is reported.
const COMMON_INTERVAL_S: f64 = 0.1;

pub(super) struct Stamp {
    pub(super) place: Place,
    pub(super) t_s: f64,
}

/// The median; for an even number of values the greater of the two middle ones.
fn median(mut numbers: Vec<f64>) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied()
}

pub(super) fn radians(found: f64, most: f64, place: impl FnOnce() -> Place) -> Result<(), LogError> {
    if found.abs() <= most {
        return Ok(());
    }
    Err(place().error(Problem::NotRadians { found, most, degrees: found.abs() > COUNTED_RAD }))
}

/// Bearings or steering angles of a table. In degrees some may be small; the greatest decides.
pub(super) struct Angles {
    most: f64,
    greatest: f64,
    first: Option<(Place, f64)>,
}

impl Angles {
    pub(super) fn bearings() -> Self {
        Self { most: HALF_TURN_RAD, greatest: 0.0, first: None }
    }

    pub(super) fn steering() -> Self {
        Self { most: FRAC_PI_2, greatest: 0.0, first: None }
    }

    pub(super) fn add(&mut self, angle: f64, place: impl FnOnce() -> Place) {
        self.greatest = self.greatest.max(angle.abs());
        if !(angle.abs() <= self.most) && self.first.is_none() {
            self.first = Some((place(), angle));
        }
    }

    pub(super) fn check(self) -> Result<(), LogError> {
        let Self { most, greatest, first } = self;
        first.map_or(Ok(()), |(place, found)| {
            Err(place.error(Problem::NotRadians { found, most, degrees: greatest > COUNTED_RAD }))
        })
    }
}

pub(super) fn interval(rows: &[Stamp], most_s: f64) -> Result<(), LogError> {
    let Some(median_s) = median(rows.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).collect()) else {
        return Ok(());
    };
    let far = rows.windows(2).find(|pair| !(pair[1].t_s - pair[0].t_s <= most_s));
    match far {
        Some(pair) if !(median_s <= most_s) => {
            Err(pair[1].place.clone().error(Problem::FarApart { median_s, most_s, unit: unit_of(median_s) }))
        }
        _ => Ok(()),
    }
}

/// The unit in which the interval of rows would be common.
fn unit_of(median_s: f64) -> &'static str {
    let off = |ticks_a_second: f64| (median_s / ticks_a_second / COMMON_INTERVAL_S).log10().abs();
    let units = [("milliseconds", 1e3), ("microseconds", 1e6), ("nanoseconds", 1e9)];
    units.into_iter().min_by(|a, b| off(a.1).total_cmp(&off(b.1))).map_or("another unit", |(name, _)| name)
}

/// Checks that there is odometry, that it begins before the last scan, and that most scans are within its time.
pub(super) fn common_clock(odometry: &[Stamp], scans: &[Stamp]) -> Result<(), LogError> {
    let [Some(first), Some(last)] = [odometry.first(), odometry.last()] else {
        return Err(Place::File("odometry.csv").error(Problem::NoOdometry));
    };
    if let Some(scan) = scans.last().filter(|scan| first.t_s > scan.t_s) {
        let problem = Problem::LateOdometry { first_s: first.t_s, last_scan_s: scan.t_s };
        return Err(first.place.clone().error(problem));
    }
    let outside = || scans.iter().filter(|scan| !(first.t_s..=last.t_s).contains(&scan.t_s));
    // A single row holds for ever: it means that nothing moves.
    match outside().next() {
        Some(scan) if odometry.len() > 1 && 2 * outside().count() > scans.len() => {
            let problem = Problem::OtherClock { scan_s: scan.t_s, odometry_s: [first.t_s, last.t_s] };
            Err(scan.place.clone().error(problem))
        }
        _ => Ok(()),
    }
}

/// Checks that half of the ranges are within twice the greatest range.
pub(super) fn ranges(ranges_m: Vec<f64>, range_max_m: f64) -> Result<(), LogError> {
    let most_m = 2.0 * range_max_m;
    match median(ranges_m) {
        Some(median_m) if !(median_m <= most_m) => {
            Err(Place::Column("detections.csv", "range_m").error(Problem::OutOfReach { median_m, most_m }))
        }
        _ => Ok(()),
    }
}

/// Checks that the median distance which the vehicle drives between scans, with `speeds_mps` of the rows of odometry, is at most
/// twice the greatest range.
pub(super) fn way(
    odometry: &[Stamp],
    speeds_mps: impl Iterator<Item = f64>,
    scans: &[Stamp],
    range_max_m: f64,
    column: &'static str,
) -> Result<(), LogError> {
    let mut rows = odometry.iter().zip(speeds_mps).peekable();
    let (mut now_s, mut speed, mut driven) = (f64::NEG_INFINITY, 0.0_f64, 0.0_f64);
    let mut ways = Vec::with_capacity(scans.len());
    for scan in scans {
        let before = driven;
        while let Some((row, next)) = rows.next_if(|(row, _)| row.t_s <= scan.t_s) {
            if speed > 0.0 {
                driven += speed * (row.t_s - now_s);
            }
            (now_s, speed) = (row.t_s, next.abs());
        }
        if speed > 0.0 {
            driven += speed * (scan.t_s - now_s);
            now_s = scan.t_s;
        }
        ways.push(driven - before);
    }
    let most_m = 2.0 * range_max_m;
    match median(ways) {
        Some(median_m) if scans.len() > 1 && !(median_m <= most_m) => {
            Err(Place::Column("odometry.csv", column).error(Problem::DrivesTooFar { median_m, most_m }))
        }
        _ => Ok(()),
    }
}
