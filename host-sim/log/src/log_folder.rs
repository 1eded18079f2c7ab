//! A log as a folder of files: `log.toml` and plain CSV tables.
//!
//! | file | content |
//! |---|---|
//! | `log.toml` | name, whether simulated, initial pose, `[vehicle]`, `[sensor]` or `[[sensors]]`, known noise; `[fixes]` |
//! | `odometry.csv` | `t_s` and the controls: `speed_mps,steering_rad` (Ackermann) or `v_mps,omega_radps` (unicycles) or `vx_mps,vy_mps,omega_radps` (holonomic) |
//! | `scans.csv` | `scan,t_s`, a row for each scan; with several sensors also `sensor`, the name of its sensor |
//! | `detections.csv` | `scan,range_m,bearing_rad`, a row for each detection; optional: `label_landmark` or `label_subject` |
//! | `fixes.csv` | optional: `t_s` and `x_m,y_m` or `heading_rad` or both, a row for each fix of the pose; cells may be empty |
//! | `truth.csv` | optional: `t_s,x_m,y_m` and, if known, `heading_rad` |
//! | `landmarks.csv` | optional: `x_m,y_m` |
//! | `moving.csv` | optional: `subject,t_s,x_m,y_m` |
//!
//! A log with a `[camera]` section is an underwater one, read by [`read_underwater`].
//!
//! Columns are found by name, in any order; others are ignored. Labels are the landmarks of the detections, negative for none; a
//! subject of `moving.csv` is a moving landmark. They are for baselines and scores, never an input of the filter.
//!
//! All keys of `log.toml` are checked: a key that is unknown, or not used by the vehicle's model, is an error.
//!
//! `[vehicle]` has the mounting of the sensor. For an Ackermann vehicle the pose is that of its sensor, `sensor_forward_m` ahead
//! of the rear axle and `sensor_left_m` to the left of the centreline (5.25). For other vehicles the pose is that of the axle, or
//! of the centre of rotation, and both keys, which are optional, are the position of the sensor relative to it. `sensor_yaw_rad`,
//! which is optional too, is the angle of any sensor to the left.
//!
//! Several sensors are sections `[[sensors]]` instead of `[sensor]`, with the same keys, a `name` of letters, digits, dashes and
//! underscores, and the optional mounting `forward_m`, `left_m` and `yaw_rad`, relative to the vehicle's pose. For a unicycle
//! that is its axle. For an Ackermann vehicle it is the point at `sensor_forward_m` and `sensor_left_m` of `[vehicle]` relative
//! to the rear axle: if both are 0, the axle itself. `[vehicle]` then has no other key for a sensor's mounting. Scans of all
//! sensors are numbered together, in order of time.
//!
//! `fixes.csv` has measurements of the pose, for example of a satellite receiver and a compass: the position of an antenna in the
//! map's frame, and the heading from its x axis to its y axis. `[fixes]` has their noise: `position_sigma_m` along each axis and
//! `heading_sigma_rad`, each required if there are such fixes. `forward_m` and `left_m` are the position of the antenna, as for a
//! sensor. A fix whose squared Mahalanobis distance from the prediction exceeds `gate`, by default 25, is left out, and counted;
//! after `patience_s`, by default 7, consistent fixes are accepted. A fix comes before a scan of the same time. None may be
//! before the odometry.
//!
//! `no_return_m` of a sensor is the range that it writes if nothing was reflected; such detections are left out. Sections
//! `[[sensor.exclude]]`, with several sensors `[[sensors.exclude]]`, are zones of its view in which it sees its own vehicle:
//! `range_min_m`, `range_max_m`, `bearing_min_rad` and `bearing_max_rad`, each by default that of the view. Detections there are
//! left out. A zone of all bearings at the nearest or farthest ranges, or of all ranges at an edge, is also removed from the
//! view; in any other zone the filter expects occlusion.
//!
//! `simulated = true` means that the stated noise is exact. In logs without this key the first word of `kind` decides, which must
//! be `simulated` or `real`; without either key the log is real. With the key, `kind` is free text without effect, as `source`,
//! `note` and `truth` always are.
//!
//! `truth_sigma_m`, which is optional, is the standard deviation of each coordinate of the positions in `truth.csv`, for example
//! of a satellite receiver. It does not change the estimates; but the NEES then has the sum of both covariances.
//!
//! All numbers are in metres, seconds and radians. Numbers that can only have another unit are refused: `units.rs` has the
//! bounds.

mod error;
mod head;
mod scans;
mod table;
mod underwater;
mod units;
mod write;

pub use error::{LogError, Place, Problem};
pub use underwater::{has_camera, read_underwater};
pub use write::{head_text as head, write};

use crate::log::{Fix, Log, MovingLandmark, Odometry, PoseFix, Scan, TruePose, Vehicle};
use error::Faults;
use head::Head;
use scans::{Clock, each_detection, scan_times};
use std::collections::HashMap;
use std::path::Path;
use table::{Row, Table};
use units::{Angles, ODOMETRY_INTERVAL_S, Stamp, WHOLE_TURN_RAD};

/// Reads a folder.
///
/// Numbers are read as they are written, without sorting or correction, and only detections excluded by `log.toml` are left out.
/// Scans are renumbered from 0 if the folder omits numbers, as folders without empty scans do. An empty cell in the column
/// `heading_rad` of `truth.csv` is an unknown heading.
///
/// # Errors
///
/// All errors of the folder with their places, at least one: see [`Problem`]. For a table it is the first invalid row.
pub fn read_or_all(dir: &Path) -> Result<Log, Vec<LogError>> {
    if !dir.is_dir() {
        return Err(vec![Place::Folder(dir.to_path_buf()).error(Problem::Missing)]);
    }
    let (head, mut faults) = match Head::read(dir) {
        Ok(head) => (Some(head), Faults::default()),
        Err(errors) => (None, Faults(errors)),
    };
    let rows = head.as_ref().and_then(|head| rows(dir, head, &mut faults));
    let (truth, landmarks, moving) = (faults.take(truth(dir)), faults.take(landmarks(dir)), faults.take(moving(dir)));
    match (head, rows, truth, landmarks, moving) {
        (Some(head), Some((odometry, scans, fixes)), Some(truth), Some(landmarks), Some(moving)) => {
            let empty = empty(head).map_err(|error| vec![error])?;
            Ok(Log { odometry, scans, fixes, truth, landmarks, moving, ..empty })
        }
        _ => Err(faults.0),
    }
}

/// [`read_or_all`], with the first error only.
pub fn read(dir: &Path) -> Result<Log, LogError> {
    read_or_all(dir).map_err(first)
}

fn first(errors: Vec<LogError>) -> LogError {
    let unknown = || Place::File("log.toml").error(Problem::Missing);
    errors.into_iter().next().unwrap_or_else(unknown)
}

/// The tables that depend on the head; `None` after an error.
fn rows(dir: &Path, head: &Head, faults: &mut Faults) -> Option<(Vec<Odometry>, Vec<Scan>, Vec<Fix>)> {
    let (odometry, scans) = (faults.take(odometry(dir, head)), faults.take(scans(dir, head)));
    let ((odometry, rows), (scans, stamps)) = odometry.zip(scans)?;
    faults.take(units::common_clock(&rows, &stamps))?;
    let speeds = odometry.iter().map(Odometry::speed_mps);
    let reach_m = head.sensors.iter().map(|sensor| sensor.sensor.range_max_m).fold(0.0, f64::max);
    faults.take(units::way(&rows, speeds, &stamps, reach_m, head.control_columns().0[0]))?;
    let fixes = faults.take(fixes(dir, head, odometry.first(), scans.last()))?;
    Some((odometry, scans, fixes))
}

/// A log with the contents of a `log.toml`, without rows.
pub fn of_head(text: &str) -> Result<Log, LogError> {
    let head = Head::of(text).map_err(first)?;
    if let Some(key) = head.key_of_folders() {
        return Err(key.error(Problem::OfFolders));
    }
    empty(head)
}

fn empty(head: Head) -> Result<Log, LogError> {
    let mut sensors = head.sensors.into_iter();
    // A head has at least one sensor.
    let first = sensors.next().ok_or_else(|| Place::Key("sensor".into()).error(Problem::Missing))?;
    Ok(Log {
        name: head.name,
        initial_pose: head.initial_pose,
        vehicle: head.vehicle,
        sensor: first.sensor,
        sensor_name: first.name,
        nominal: first.nominal,
        others: sensors.collect(),
        simulated: head.simulated,
        fix_noise: head.fix_noise.unwrap_or_default(),
        truth_sigma_m: head.truth_sigma_m,
        ..Log::default()
    })
}

fn odometry(dir: &Path, head: &Head) -> Result<(Vec<Odometry>, Vec<Stamp>), LogError> {
    let table = Table::read(dir, "odometry.csv")?;
    let (names, left) = head.control_columns();
    let time = table.column("t_s")?;
    let (first, second) = (table.column(names[0])?, table.column(names[1])?);
    let left = left.map(|name| table.column(name)).transpose()?;
    let (mut clock, mut steering) = (Clock::new(), Angles::steering());
    let (mut odometry, mut stamps) = (Vec::new(), Vec::new());
    for row in table.rows() {
        let t_s = clock.tick(&row, row.number(&time)?)?;
        let aside = left.as_ref().map_or(Ok(0.0), |column| row.number(column))?;
        let control = [row.number(&first)?, row.number(&second)?, aside];
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
    let table = Table::read(dir, "scans.csv")?;
    let (numbers, stamps) = scan_times(&table)?;
    let sensors = sensors_of_scans(&table, head)?;
    let scan = |(stamp, sensor): (&Stamp, usize)| Scan { t_s: stamp.t_s, sensor, ..Scan::default() };
    let mut scans: Vec<Scan> = stamps.iter().zip(sensors).map(scan).collect();
    let mut bearings = Angles::bearings();
    let mut ranges = vec![Vec::new(); head.sensors.len()];
    each_detection(dir, &numbers, ["range_m", "bearing_rad"], |index, row, [range_m, bearing], label| {
        if head.dropped[scans[index].sensor].holds([range_m, bearing]) {
            return Ok(());
        }
        // Simulations add noise to short ranges, and the result may be negative.
        if range_m < 0.0 && !head.simulated {
            return Err(row.cell("range_m").error(Problem::NegativeRange(range_m)));
        }
        bearings.add(bearing, || row.cell("bearing_rad"));
        ranges[scans[index].sensor].push(range_m);
        scans[index].detections.push([range_m, bearing]);
        scans[index].labels.extend(label);
        Ok(())
    })?;
    bearings.check()?;
    for (ranges, sensor) in ranges.into_iter().zip(&head.sensors) {
        units::ranges(ranges, sensor.sensor.range_max_m)?;
    }
    Ok((scans, stamps))
}

fn sensors_of_scans(table: &Table, head: &Head) -> Result<Vec<usize>, LogError> {
    if let [sensor] = &head.sensors[..]
        && sensor.name.is_empty()
    {
        return Ok(vec![0; table.rows().count()]);
    }
    let column = table.column("sensor")?;
    let of = |row: Row<'_>| {
        let name = row.text(&column);
        head.sensors.iter().position(|sensor| sensor.name == name).ok_or_else(|| {
            let known = head.sensors.iter().map(|sensor| sensor.name.clone()).collect();
            row.cell("sensor").error(Problem::NoSuchSensor { found: name.to_owned(), known })
        })
    };
    table.rows().map(of).collect()
}

/// The fixes, with positions before headings of the same row.
fn fixes(dir: &Path, head: &Head, odometry: Option<&Odometry>, scan: Option<&Scan>) -> Result<Vec<Fix>, LogError> {
    let file = "fixes.csv";
    let Some(table) = Table::read_optional(dir, file)? else {
        let unused = || Place::File(file).error(Problem::Missing);
        return if head.fix_noise.is_some() { Err(unused()) } else { Ok(Vec::new()) };
    };
    let noise = head.fix_noise.ok_or_else(|| Place::Key("fixes".into()).error(Problem::NoFixNoise))?;
    let time = table.column("t_s")?;
    let heading = table.column_if_any("heading_rad")?;
    let has_places =
        heading.is_none() || table.column_if_any("x_m")?.is_some() || table.column_if_any("y_m")?.is_some();
    let places = if has_places { Some([table.column("x_m")?, table.column("y_m")?]) } else { None };
    let stated = |key: &str, known: Option<f64>| {
        known.map(drop).ok_or_else(|| Place::Key(format!("fixes.{key}")).error(Problem::NoFixNoise))
    };
    let (mut clock, mut fixes) = (Clock::new(), Vec::new());
    for row in table.rows() {
        let t_s = clock.tick(&row, row.number(&time)?)?;
        if let Some(first) = odometry.filter(|first| t_s < first.t_s) {
            return Err(row.cell("t_s").error(Problem::EarlyFix { t_s, first_s: first.t_s }));
        }
        let before = fixes.len();
        if let Some([x, y]) = &places
            && !(row.text(x).is_empty() && row.text(y).is_empty())
        {
            stated("position_sigma_m", noise.position_sigma_m)?;
            fixes.push(Fix { t_s, measured: PoseFix::Position([row.number(x)?, row.number(y)?]) });
        }
        if let Some(column) = &heading
            && let Some(heading_rad) = row.number_if_any(column)?
        {
            stated("heading_sigma_rad", noise.heading_sigma_rad)?;
            units::radians(heading_rad, WHOLE_TURN_RAD, || row.cell("heading_rad"))?;
            fixes.push(Fix { t_s, measured: PoseFix::Heading(heading_rad) });
        }
        if fixes.len() == before {
            return Err(row.cell("t_s").error(Problem::EmptyFix));
        }
    }
    if let (Some(first), Some(scan)) = (fixes.first(), scan)
        && first.t_s > scan.t_s
    {
        let problem = Problem::LateFixes { first_s: first.t_s, last_scan_s: scan.t_s };
        return Err(Place::Column(file, "t_s").error(problem));
    }
    Ok(fixes)
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
