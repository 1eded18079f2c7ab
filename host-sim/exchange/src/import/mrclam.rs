//! The original text files of the UTIAS Multi-Robot Cooperative Localization and Mapping datasets (Leung, Halpern, Barfoot and
//! Liu, IJRR 2011): columns separated by white space, `#` before remarks, times in seconds of a common clock.
//!
//! | file | columns |
//! |---|---|
//! | `Barcodes.dat` | subject, barcode |
//! | `Landmark_Groundtruth.dat` | subject, x and y (m), their standard deviations (m) |
//! | `RobotN_Odometry.dat` | time, forward velocity (m/s), angular velocity (rad/s) |
//! | `RobotN_Measurement.dat` | time, barcode, range (m), bearing (rad) |
//! | `RobotN_Groundtruth.dat` | time, x and y (m), heading (rad) |
//!
//! Subjects 1 to 5 are robots, 6 to 20 landmarks.

use super::scans::{Seen, scans};
use super::text::{Delimiter, Text, Writing};
use super::{Draft, ImportError, Imported};
use crate::calendar;
use scphd_log::log::{Log, MovingLandmark, Odometry, TruePose};
use scphd_log::{log_folder, truth};
use std::collections::HashMap;
use std::path::Path;

pub const ROBOTS: std::ops::RangeInclusive<u32> = 1..=5;

const WRITING: Writing = Writing { delimiter: Delimiter::Space, header: false };

/// Robot and camera; the noise is that of the detections of three robots of dataset 6, compared with the truth.
const HEAD: &str = "name = \"UTIAS MRCLAM\"\ninitial_pose = [0.0, 0.0, 0.0]\n\n[vehicle]\nmodel = \"unicycle\"\n\n[sensor]\n\
    model = \"range_bearing\"\nrange_max_m = 10.0\nbearing_min_rad = -0.6\nbearing_max_rad = 0.6\nrange_sigma_m = 0.16\n\
    bearing_sigma_rad = 0.02\n";

/// Whether a folder has the files of a robot.
pub fn is(dir: &Path) -> bool {
    ROBOTS.into_iter().any(|robot| dir.join(format!("Robot{robot}_Odometry.dat")).is_file())
}

/// Reads the log of a robot. `head`, if given, describes vehicle and camera.
///
/// # Errors
/// A file is missing, or a row has no numbers: see [`ImportError`].
pub fn read(dir: &Path, robot: u32, head: Option<Log>) -> Result<Imported, ImportError> {
    let open = |name: &str| Text::read(&dir.join(name), WRITING);
    let of = |robot: u32, what: &str| format!("Robot{robot}_{what}.dat");
    let mut subjects = HashMap::new();
    for row in open("Barcodes.dat")?.rows() {
        // Subjects and barcodes are whole numbers of two digits.
        subjects.insert(row.number(1)? as i64, row.number(0)? as i64);
    }
    let odometry = open(&of(robot, "Odometry"))?;
    let mut rows = Vec::new();
    for row in odometry.rows() {
        rows.push(Odometry { t_s: row.number(0)?, control: [row.number(1)?, row.number(2)?, 0.0] });
    }
    let first_s = rows.first().map_or(0.0, |row| row.t_s);
    // Seconds since 1970 would lose digits: times are relative to the whole second before the first row.
    let zero_s = if first_s > 1e6 { first_s.floor() } else { 0.0 };
    // Times have milliseconds.
    let time = |t_s: f64| ((t_s - zero_s) * 1e3).round() / 1e3;
    rows.iter_mut().for_each(|row| row.t_s = time(row.t_s));

    let mut seen: Vec<Seen> = Vec::new();
    let mut unknown = 0;
    for row in open(&of(robot, "Measurement"))?.rows() {
        let subject = subjects.get(&(row.number(1)? as i64)).copied();
        unknown += usize::from(subject.is_none());
        seen.push((time(row.number(0)?), [row.number(2)?, row.number(3)?], Some(subject.unwrap_or(-1))));
    }
    let mut landmarks = Vec::new();
    for row in open("Landmark_Groundtruth.dat")?.rows() {
        landmarks.push([row.number(1)?, row.number(2)?]);
    }
    let pose = |row: super::text::Row<'_>| {
        let position = [row.number(1)?, row.number(2)?];
        Ok(TruePose { t_s: time(row.number(0)?), position, heading_rad: Some(row.number(3)?) })
    };
    let truth = open(&of(robot, "Groundtruth"))?.rows().map(pose).collect::<Result<Vec<TruePose>, ImportError>>()?;
    let mut moving = Vec::new();
    for other in ROBOTS.filter(|other| *other != robot) {
        if !dir.join(of(other, "Groundtruth")).is_file() {
            continue;
        }
        for row in open(&of(other, "Groundtruth"))?.rows() {
            let TruePose { t_s, position, .. } = pose(row)?;
            moving.push(MovingLandmark { subject: i64::from(other), t_s, position });
        }
    }

    let stated = head.is_some();
    let mut head = match head {
        Some(head) => head,
        None => log_folder::of_head(HEAD).map_err(|error| ImportError::Head("MRCLAM".into(), error))?,
    };
    let begin_s = rows.first().map_or(0.0, |row| row.t_s);
    let start = truth::at(&truth, begin_s).or_else(|| truth.first().copied());
    if let Some(TruePose { position: [x, y], heading_rad, .. }) = start.filter(|_| !stated) {
        head.initial_pose = [x, y, heading_rad.unwrap_or(0.0)];
        head.name = format!("UTIAS MRCLAM robot {robot}");
    }
    let mut told = vec![format!("robot {robot}: {} rows of odometry, {} detections", rows.len(), seen.len())];
    if zero_s > 0.0 {
        let date = calendar::utc(zero_s).map_or_else(String::new, |date| format!(" ({date})"));
        told.push(format!("times are counted from {zero_s} s on{date}"));
    }
    if unknown > 0 {
        told.push(format!("{unknown} detections have a barcode that Barcodes.dat does not have: their label is -1"));
    }
    if !stated {
        told.push(
            "range and bearing noise are those measured in dataset 6; the vehicle starts at its true pose".to_owned(),
        );
    }
    let sensors = vec![(String::new(), None)];
    let scans = scans(seen, &[]);
    Draft { head: Some(head), sensors, odometry: rows, scans, truth, landmarks, moving, told, ..Draft::default() }
        .finish()
}
