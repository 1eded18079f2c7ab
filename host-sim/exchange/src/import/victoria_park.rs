//! The original MAT-files of the Victoria Park dataset (Guivant and Nebot, ACFR Sydney). Times are in milliseconds.
//!
//! | file | matrices |
//! |---|---|
//! | `aa3_dr.mat` | `time`, `speed` (m/s, of the left rear wheel), `steering` (rad) |
//! | `aa3_lsr2.mat` | `TLsr`, `LASER`: a row a scan, 361 ranges half a degree apart, from the right to the left; 13 bits of cm |
//! | `aa3_gpsx.mat` | `timeGps`, `Lo_m` and `La_m` (m, east and north) |

use super::matlab::{Matrix, matrices};
use super::{Draft, ImportError, Imported};
use scphd_log::log::{Log, Odometry, Scan, TruePose};
use scphd_log::log_folder;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Vehicle and laser, as published with the data; the initial heading is from the first metres of GPS. The noise is nominal.
const HEAD: &str = "name = \"Victoria Park\"\ninitial_pose = [0.0, 0.0, 0.6196]\n\n[vehicle]\nmodel = \"ackermann\"\nwheelbase_m = 2.83\n\
    encoder_offset_m = 0.76\nsensor_forward_m = 3.78\nsensor_left_m = 0.5\n\n[sensor]\nmodel = \"range_bearing\"\nrange_max_m = 80.0\n\
    bearing_min_rad = -1.5708\nbearing_max_rad = 1.5708\nrange_sigma_m = 0.5\nbearing_sigma_rad = 0.02\n";

/// Number of rays of a scan, and the angle between them, rad.
const RAYS: usize = 361;
const STEP_RAD: f64 = std::f64::consts::PI / 360.0;
/// Mask of the range in a value of the laser, 13 bits; the others are the intensity.
const RANGE_BITS: u32 = 0x1fff;
/// Greatest range of a return, m.
const FARTHEST_M: f64 = 75.0;
/// Diameter of a trunk, m.
const TRUNK_M: std::ops::RangeInclusive<f64> = 0.05..=1.2;
/// Greatest difference of neighbouring ranges of one trunk, m.
const SAME_M: f64 = 0.4;
/// Least distance by which the surroundings of a trunk are farther, m; otherwise it is partly occluded, or a piece of a hedge.
const FREE_M: f64 = 1.0;

/// Whether a folder has the files.
pub fn is(dir: &Path) -> bool {
    dir.join("aa3_dr.mat").is_file()
}

/// Reads the log. Trees are isolated objects of the width of a trunk. `head`, if given, describes vehicle and sensor.
///
/// # Errors
/// A file or matrix is missing or damaged: see [`ImportError`].
pub fn read(dir: &Path, head: Option<Log>) -> Result<Imported, ImportError> {
    let open = |name: &'static str| {
        let path = dir.join(name);
        let bytes = fs::read(&path).map_err(|error| ImportError::io(&path, error))?;
        let all = matrices(&bytes).map_err(|what| ImportError::at(path.display(), what))?;
        Ok(File { place: path.display().to_string(), all })
    };
    let file: File = open("aa3_dr.mat")?;
    let (time, [speed, steering]) = file.columns("time", ["speed", "steering"])?;
    let rows = time.iter().zip(speed).zip(steering);
    let odometry: Vec<Odometry> =
        rows.map(|((ms, speed), steering)| Odometry { t_s: ms / 1e3, control: [*speed, *steering, 0.0] }).collect();

    let file: File = open("aa3_lsr2.mat")?;
    let times = &file.matrix("TLsr")?.numbers;
    let laser = file.matrix("LASER")?;
    if laser.rows != times.len() || laser.numbers.len() != RAYS * times.len() {
        let what = format!("LASER has {} numbers, expected {} rows of {RAYS}", laser.numbers.len(), times.len());
        return Err(ImportError::at(&file.place, what));
    }
    let mut scans = Vec::with_capacity(times.len());
    for (row, ms) in times.iter().enumerate() {
        // The matrix is stored by columns; values are whole numbers of 16 bits.
        let ranges: Vec<f64> =
            (0..RAYS).map(|ray| f64::from(laser.numbers[ray * laser.rows + row] as u32 & RANGE_BITS) / 100.0).collect();
        scans.push(Scan { t_s: ms / 1e3, detections: trunks(&ranges), ..Scan::default() });
    }
    let mut truth: Vec<TruePose> = Vec::new();
    let mut told = vec![format!(
        "{} rows of odometry, {} scans; trees by a detector of this program's own",
        odometry.len(),
        scans.len()
    )];
    if dir.join("aa3_gpsx.mat").is_file() {
        let file: File = open("aa3_gpsx.mat")?;
        let (time, [east, north]) = file.columns("timeGps", ["Lo_m", "La_m"])?;
        let rows = time.iter().zip(east).zip(north);
        truth = rows.map(|((ms, x), y)| TruePose { t_s: ms / 1e3, position: [*x, *y], heading_rad: None }).collect();
    } else {
        told.push("no aa3_gpsx.mat: no truth".to_owned());
    }
    let stated = head.is_some();
    let mut head = match head {
        Some(head) => head,
        None => log_folder::of_head(HEAD).map_err(|error| ImportError::Head("Victoria Park".into(), error))?,
    };
    if let Some(first) = truth.first().filter(|_| !stated) {
        (head.initial_pose[0], head.initial_pose[1]) = (first.position[0], first.position[1]);
    }
    let sensors = vec![(String::new(), None)];
    Draft { head: Some(head), sensors, odometry, scans, truth, told, ..Draft::default() }.finish()
}

struct File {
    place: String,
    all: BTreeMap<String, Matrix>,
}

impl File {
    fn matrix(&self, name: &str) -> Result<&Matrix, ImportError> {
        let names = || self.all.keys().cloned().collect::<Vec<_>>().join(", ");
        let matrix = self.all.get(name);
        let matrix = matrix
            .ok_or_else(|| ImportError::at(&self.place, format_args!("no matrix {name}; there are {}", names())))?;
        match matrix.numbers.iter().position(|number| !number.is_finite()) {
            None => Ok(matrix),
            Some(place) => Err(ImportError::at(&self.place, format_args!("{name}, number {}: not finite", place + 1))),
        }
    }

    /// A column, and others of the same length.
    fn columns<const N: usize>(&self, first: &str, others: [&str; N]) -> Result<(&[f64], [&[f64]; N]), ImportError> {
        let time = &self.matrix(first)?.numbers[..];
        let mut found = [time; N];
        for (place, name) in found.iter_mut().zip(others) {
            *place = &self.matrix(name)?.numbers;
            if place.len() != time.len() {
                let what = format!("{name} has {} numbers, {first} {}", place.len(), time.len());
                return Err(ImportError::at(&self.place, what));
            }
        }
        Ok((time, found))
    }
}

/// Range (m) and bearing (rad) of the centres of trunks.
fn trunks(ranges: &[f64]) -> Vec<[f64; 2]> {
    let seen = |range: f64| range > 0.0 && range < FARTHEST_M;
    let mut found = Vec::new();
    let mut begin = 0;
    while begin < ranges.len() {
        let mut end = begin + 1;
        while end < ranges.len() && (ranges[end] - ranges[end - 1]).abs() <= SAME_M {
            end += 1;
        }
        let piece = &ranges[begin..end];
        // Both neighbours are farther, or no return; the edge of the view may occlude.
        let edge = |inside: f64, outside: Option<&f64>| {
            outside.is_some_and(|&outside| !seen(outside) || outside > inside + FREE_M)
        };
        let free = begin > 0 && edge(ranges[begin], ranges.get(begin - 1)) && edge(ranges[end - 1], ranges.get(end));
        let mean = piece.iter().sum::<f64>() / piece.len() as f64;
        let thick = mean * STEP_RAD * piece.len() as f64;
        if free && piece.iter().all(|range| seen(*range)) && TRUNK_M.contains(&thick) {
            let middle = 0.5 * (begin + end - 1) as f64;
            let nearest = piece.iter().copied().fold(f64::INFINITY, f64::min);
            found.push([nearest + 0.5 * thick, (middle - 0.5 * (RAYS - 1) as f64) * STEP_RAD]);
        }
        begin = end;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trunks_are_detected_and_walls_are_not() {
        // Rays that meet circles, and a wall on the left.
        let circles = [([10.0, 0.0], 0.2), ([12.0, -9.0], 0.35), ([3.0, 4.0], 0.15)];
        let ray = |k: usize| {
            let angle = (k as f64 - 180.0) * STEP_RAD;
            let direction = [angle.cos(), angle.sin()];
            let hit = |([x, y], radius): &([f64; 2], f64)| {
                let along = x * direction[0] + y * direction[1];
                let across = x * direction[1] - y * direction[0];
                (across.abs() < *radius).then(|| along - (radius * radius - across * across).sqrt())
            };
            let wall = if angle > 1.1 { 6.0 / angle.sin() } else { 81.91 };
            circles.iter().filter_map(hit).fold(wall, f64::min)
        };
        let ranges: Vec<f64> = (0..RAYS).map(ray).collect();
        let found = trunks(&ranges);
        assert_eq!(found.len(), 3, "{found:?}");
        for ([x, y], _) in circles {
            let near = |[range, bearing]: &&[f64; 2]| {
                (range - f64::hypot(x, y)).abs() < 0.1 && (bearing - y.atan2(x)).abs() < 0.01
            };
            assert!(found.iter().any(|seen| near(&seen)), "{x} {y}: {found:?}");
        }
        assert!(trunks(&[0.0; RAYS]).is_empty() && trunks(&[81.91; RAYS]).is_empty());
    }
}
