//! A log as a folder of files: `log.toml` and plain CSV tables.
//!
//! | file | content |
//! |---|---|
//! | `log.toml` | name, whether it is simulated, initial pose, `[vehicle]` and `[sensor]` with what is known of their noise |
//! | `odometry.csv` | `t_s` and the controls: `speed_mps,steering_rad` (Ackermann) or `v_mps,omega_radps` (unicycles) |
//! | `scans.csv` | `scan,t_s`, one row a scan |
//! | `detections.csv` | `scan,range_m,bearing_rad`, one row a detection; optional: `label_landmark` or `label_subject` |
//! | `truth.csv` | optional: `t_s,x_m,y_m` and, where known, `heading_rad` |
//! | `landmarks.csv` | optional: `x_m,y_m` |
//! | `moving.csv` | optional: `subject,t_s,x_m,y_m` |
//!
//! A log with a `[camera]` section is an underwater one, read by [`read_underwater`].
//!
//! Columns are found by name, in any order; others are not looked at. Labels say which landmark a detection is of, negative for
//! none; a subject of `moving.csv` moves. They are for yardsticks and scores, never an input of the filter.
//!
//! Keys of `log.toml` are all looked at: one that is not known, or that the vehicle's model has no use for, is an error.
//!
//! `[vehicle]` says where the sensor sits. Of an Ackermann vehicle the pose is its sensor's, `sensor_forward_m` ahead of the rear axle and
//! `sensor_left_m` to the left of the centreline (5.25). Of a unicycle it is its axle's, and both keys, which may be left out, say where
//! the sensor sits from there. `sensor_yaw_rad`, which may be left out too, is how any sensor is turned to the left.
//!
//! `simulated = true` says that the stated noise is exact. In logs without this key the first word of `kind`, up to a comma, says so:
//! `simulated` or `real`, and nothing else; where there is neither key the log is real. With the key, `kind` is free text and
//! decides nothing, as `source`, `note` and `truth` never do.
//!
//! All is in metres, seconds and radians. What can only be another unit is refused: `units.rs` has the bounds.

mod error;
mod head;
mod scans;
mod table;
mod underwater;
mod units;
mod write;

pub use error::{LogError, Place, Problem};
pub use underwater::{has_camera, read_underwater};
pub use write::write;

use crate::log::{Log, MovingLandmark, Odometry, Scan, TruePose, Vehicle};
use head::Head;
use scans::{Clock, each_detection, scan_times};
use std::collections::HashMap;
use std::path::Path;
use table::Table;
use units::{Angles, ODOMETRY_INTERVAL_S, Stamp};

/// Reads a folder.
///
/// Numbers come as they are written; nothing is sorted, cut or corrected. Scans are numbered anew from 0
/// where the folder leaves numbers out, as folders without their empty scans do. An empty cell in the
/// column `heading_rad` of `truth.csv` is an unknown heading.
///
/// # Errors
///
/// The first thing wrong with the folder and where it is: see [`Problem`].
pub fn read(dir: &Path) -> Result<Log, LogError> {
    if !dir.is_dir() {
        return Err(Place::Folder(dir.to_path_buf()).error(Problem::Missing));
    }
    let head = Head::read(dir)?;
    let (odometry, rows) = odometry(dir, &head)?;
    let (scans, stamps) = scans(dir, &head)?;
    units::common_clock(&rows, &stamps)?;
    let speeds = odometry.iter().map(|row| row.control[0]);
    units::way(&rows, speeds, &stamps, head.sensor.range_max_m, head.control_columns()[0])?;
    Ok(Log {
        name: head.name,
        initial_pose: head.initial_pose,
        vehicle: head.vehicle,
        sensor: head.sensor,
        nominal: head.nominal,
        simulated: head.simulated,
        odometry,
        scans,
        truth: truth(dir)?,
        landmarks: landmarks(dir)?,
        moving: moving(dir)?,
    })
}

fn odometry(dir: &Path, head: &Head) -> Result<(Vec<Odometry>, Vec<Stamp>), LogError> {
    let table = Table::read(dir, "odometry.csv")?;
    let names = head.control_columns();
    let time = table.column("t_s")?;
    let (first, second) = (table.column(names[0])?, table.column(names[1])?);
    let (mut clock, mut steering) = (Clock::new(), Angles::steering());
    let (mut odometry, mut stamps) = (Vec::new(), Vec::new());
    for row in table.rows() {
        let t_s = clock.tick(&row, row.number(&time)?)?;
        let control = [row.number(&first)?, row.number(&second)?];
        if matches!(head.vehicle, Vehicle::Ackermann { .. }) {
            steering.add(control[1], || row.cell(names[1]));
        }
        odometry.push(Odometry { t_s, control });
        stamps.push(Stamp { place: row.cell("t_s"), t_s });
    }
    steering.check()?;
    units::interval(&stamps, ODOMETRY_INTERVAL_S)?;
    Ok((odometry, stamps))
}

fn scans(dir: &Path, head: &Head) -> Result<(Vec<Scan>, Vec<Stamp>), LogError> {
    let (numbers, stamps) = scan_times(dir)?;
    let mut scans: Vec<Scan> = stamps.iter().map(|stamp| Scan { t_s: stamp.t_s, ..Scan::default() }).collect();
    let (mut bearings, mut ranges) = (Angles::bearings(), Vec::new());
    each_detection(dir, &numbers, ["range_m", "bearing_rad"], |index, row, [range_m, bearing], label| {
        // Simulations add noise to short ranges and keep what comes out.
        if range_m < 0.0 && !head.simulated {
            return Err(row.cell("range_m").error(Problem::NegativeRange(range_m)));
        }
        bearings.add(bearing, || row.cell("bearing_rad"));
        ranges.push(range_m);
        scans[index].detections.push([range_m, bearing]);
        scans[index].labels.extend(label);
        Ok(())
    })?;
    bearings.check()?;
    units::ranges(ranges, head.sensor.range_max_m)?;
    Ok((scans, stamps))
}

fn truth(dir: &Path) -> Result<Vec<TruePose>, LogError> {
    let Some(table) = Table::read_optional(dir, "truth.csv")? else {
        return Ok(Vec::new());
    };
    let (time, x, y) = (table.column("t_s")?, table.column("x_m")?, table.column("y_m")?);
    let heading = table.column_if_any("heading_rad")?;
    let mut clock = Clock::new();
    table
        .rows()
        .map(|row| {
            Ok(TruePose {
                t_s: clock.tick(&row, row.number(&time)?)?,
                position: [row.number(&x)?, row.number(&y)?],
                heading_rad: match &heading {
                    Some(heading) => row.number_if_any(heading)?,
                    None => None,
                },
            })
        })
        .collect()
}

fn landmarks(dir: &Path) -> Result<Vec<[f64; 2]>, LogError> {
    let Some(table) = Table::read_optional(dir, "landmarks.csv")? else {
        return Ok(Vec::new());
    };
    let (x, y) = (table.column("x_m")?, table.column("y_m")?);
    table.rows().map(|row| Ok([row.number(&x)?, row.number(&y)?])).collect()
}

fn moving(dir: &Path) -> Result<Vec<MovingLandmark>, LogError> {
    let Some(table) = Table::read_optional(dir, "moving.csv")? else {
        return Ok(Vec::new());
    };
    let (subject, time) = (table.column("subject")?, table.column("t_s")?);
    let (x, y) = (table.column("x_m")?, table.column("y_m")?);
    let mut clocks: HashMap<i64, Clock> = HashMap::new();
    table
        .rows()
        .map(|row| {
            let subject = row.integer(&subject)?;
            let clock = clocks.entry(subject).or_insert_with(Clock::new);
            Ok(MovingLandmark {
                subject,
                t_s: clock.tick(&row, row.number(&time)?)?,
                position: [row.number(&x)?, row.number(&y)?],
            })
        })
        .collect()
}

#[cfg(test)]
mod tests;
