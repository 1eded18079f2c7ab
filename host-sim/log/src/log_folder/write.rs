//! Writes a log as a folder.

use super::head::control_columns;
use crate::log::{Log, Mounting, Nominal, PoseFix, Sensor, Vehicle};
use std::fs;
use std::io;
use std::path::Path;
use toml::{Table, Value};

/// Writes `log` to `dir`, which is created or must be empty. [`read`](super::read) restores the same bits; files without data
/// (truth, landmarks, moving landmarks) are not written.
///
/// # Errors
///
/// [`io::ErrorKind::AlreadyExists`] if `dir` is not empty; otherwise an error of the file system.
pub fn write(log: &Log, dir: &Path) -> io::Result<()> {
    fs::create_dir_all(dir)?;
    if fs::read_dir(dir)?.next().is_some() {
        let what = format!("{} is not empty", dir.display());
        return Err(io::Error::new(io::ErrorKind::AlreadyExists, what));
    }
    fs::write(dir.join("log.toml"), head_text(log))?;

    let ([first, second], left) = control_columns(&log.vehicle);
    let columns = if let Some(left) = left { vec![first, left, second] } else { vec![first, second] };
    let rows = log.odometry.iter().map(|row| {
        let [speed, turn, aside] = row.control;
        if left.is_some() { vec![row.t_s, speed, aside, turn] } else { vec![row.t_s, speed, turn] }
    });
    table(&dir.join("odometry.csv"), &format!("t_s,{}", columns.join(",")), rows)?;
    let names: Vec<&str> = log.sensors().map(|(name, ..)| name).collect();
    let named = !log.sensor_name.is_empty();
    let rows = log.scans.iter().enumerate().map(|(k, scan)| {
        let sensor = if named { format!(",{}", names[scan.sensor]) } else { String::new() };
        format!("{k},{:?}{sensor}", scan.t_s)
    });
    lines(&dir.join("scans.csv"), if named { "scan,t_s,sensor" } else { "scan,t_s" }, rows)?;
    let labelled = log.scans.iter().any(|scan| !scan.labels.is_empty());
    let header = if labelled { "scan,range_m,bearing_rad,label_landmark" } else { "scan,range_m,bearing_rad" };
    let detections = log.scans.iter().enumerate().flat_map(|(k, scan)| {
        scan.detections.iter().enumerate().map(move |(place, [range, bearing])| {
            let label = if labelled { format!(",{}", scan.labels.get(place).unwrap_or(&-1)) } else { String::new() };
            format!("{k},{range:?},{bearing:?}{label}")
        })
    });
    lines(&dir.join("detections.csv"), header, detections)?;

    if !log.fixes.is_empty() {
        let rows = log.fixes.iter().map(|fix| match fix.measured {
            PoseFix::Position([x, y]) => format!("{:?},{x:?},{y:?},", fix.t_s),
            PoseFix::Heading(heading) => format!("{:?},,,{heading:?}", fix.t_s),
        });
        lines(&dir.join("fixes.csv"), "t_s,x_m,y_m,heading_rad", rows)?;
    }
    if !log.truth.is_empty() {
        let path = dir.join("truth.csv");
        if has_heading(log) {
            let rows = log.truth.iter().map(|row| {
                let heading = row.heading_rad.map_or_else(String::new, |heading| format!("{heading:?}"));
                format!("{:?},{:?},{:?},{heading}", row.t_s, row.position[0], row.position[1])
            });
            lines(&path, "t_s,x_m,y_m,heading_rad", rows)?;
        } else {
            let rows = log.truth.iter().map(|row| vec![row.t_s, row.position[0], row.position[1]]);
            table(&path, "t_s,x_m,y_m", rows)?;
        }
    }
    if !log.landmarks.is_empty() {
        table(&dir.join("landmarks.csv"), "x_m,y_m", log.landmarks.iter().map(|place| place.to_vec()))?;
    }
    if !log.moving.is_empty() {
        let rows = log
            .moving
            .iter()
            .map(|row| format!("{},{:?},{:?},{:?}", row.subject, row.t_s, row.position[0], row.position[1]));
        lines(&dir.join("moving.csv"), "subject,t_s,x_m,y_m", rows)?;
    }
    Ok(())
}

pub fn head_text(log: &Log) -> String {
    head(log).to_string()
}

fn has_heading(log: &Log) -> bool {
    log.truth.iter().any(|row| row.heading_rad.is_some())
}

fn table(path: &Path, header: &str, rows: impl Iterator<Item = Vec<f64>>) -> io::Result<()> {
    let join = |row: Vec<f64>| row.iter().map(|number| format!("{number:?}")).collect::<Vec<_>>().join(",");
    lines(path, header, rows.map(join))
}

fn lines(path: &Path, header: &str, rows: impl Iterator<Item = String>) -> io::Result<()> {
    let mut text = format!("{header}\n");
    for row in rows {
        text.push_str(&row);
        text.push('\n');
    }
    fs::write(path, text)
}

fn head(log: &Log) -> Table {
    let nominal = &log.nominal;
    let mut vehicle = Table::new();
    let (model, turn) = match log.vehicle {
        Vehicle::Ackermann { wheelbase_m, encoder_offset_m, sensor_forward_m, sensor_left_m } => {
            put(&mut vehicle, "wheelbase_m", Some(wheelbase_m));
            put(&mut vehicle, "encoder_offset_m", Some(encoder_offset_m));
            put(&mut vehicle, "sensor_forward_m", Some(sensor_forward_m));
            put(&mut vehicle, "sensor_left_m", Some(sensor_left_m));
            ("ackermann", ("steering_sigma_rad", nominal.steering_sigma_rad))
        }
        Vehicle::Unicycle => ("unicycle", ("rate_sigma_radps", nominal.rate_sigma_radps)),
        Vehicle::UnicycleArc => ("unicycle_arc", ("rate_sigma_radps", nominal.rate_sigma_radps)),
        Vehicle::Holonomic => ("holonomic", ("rate_sigma_radps", nominal.rate_sigma_radps)),
    };
    vehicle.insert("model".into(), model.into());
    put(&mut vehicle, "speed_sigma_mps", nominal.speed_sigma_mps);
    put(&mut vehicle, turn.0, turn.1);

    let mut top = Table::new();
    top.insert("name".into(), log.name.clone().into());
    top.insert("simulated".into(), log.simulated.into());
    top.insert("initial_pose".into(), log.initial_pose.to_vec().into());
    if !log.truth.is_empty() {
        top.insert("truth".into(), if has_heading(log) { "pose" } else { "position" }.into());
    }
    put(&mut top, "truth_sigma_m", Some(log.truth_sigma_m).filter(|&sigma_m| sigma_m > 0.0));
    if log.sensor_name.is_empty() {
        put_mounting(&mut vehicle, "sensor_", &log.sensor.mounting);
        top.insert("sensor".into(), Value::Table(sensor(&log.sensor, nominal)));
    } else {
        let sensors = log.sensors().map(|(name, of, nominal)| {
            let mut table = sensor(of, nominal);
            table.insert("name".into(), name.into());
            put_mounting(&mut table, "", &of.mounting);
            Value::Table(table)
        });
        top.insert("sensors".into(), Value::Array(sensors.collect()));
    }
    top.insert("vehicle".into(), Value::Table(vehicle));
    if !log.fixes.is_empty() {
        let noise = &log.fix_noise;
        let mut fixes = Table::new();
        put(&mut fixes, "position_sigma_m", noise.position_sigma_m);
        put(&mut fixes, "heading_sigma_rad", noise.heading_sigma_rad);
        put(&mut fixes, "gate", noise.gate);
        put(&mut fixes, "patience_s", noise.patience_s);
        put_mounting(&mut fixes, "", &Mounting { forward_m: noise.forward_m, left_m: noise.left_m, yaw_rad: 0.0 });
        top.insert("fixes".into(), Value::Table(fixes));
    }
    top
}

fn sensor(of: &Sensor, nominal: &Nominal) -> Table {
    let mut sensor = Table::new();
    sensor.insert("model".into(), "range_bearing".into());
    put(&mut sensor, "range_min_m", Some(of.range_min_m));
    put(&mut sensor, "range_max_m", Some(of.range_max_m));
    put(&mut sensor, "bearing_min_rad", Some(of.bearing_min_rad));
    put(&mut sensor, "bearing_max_rad", Some(of.bearing_max_rad));
    put(&mut sensor, "range_sigma_m", nominal.range_sigma_m);
    put(&mut sensor, "range_sigma_ratio", Some(nominal.range_sigma_ratio).filter(|&ratio| ratio > 0.0));
    put(&mut sensor, "bearing_sigma_rad", nominal.bearing_sigma_rad);
    put(&mut sensor, "detection_probability", nominal.detection_probability);
    put(&mut sensor, "clutter_per_scan", nominal.clutter_per_scan);
    sensor
}

/// Writes the parts of a mounting that are not 0.
fn put_mounting(table: &mut Table, prefix: &str, mounting: &Mounting) {
    let Mounting { forward_m, left_m, yaw_rad } = *mounting;
    for (key, number) in [("forward_m", forward_m), ("left_m", left_m), ("yaw_rad", yaw_rad)] {
        put(table, &format!("{prefix}{key}"), Some(number).filter(|&number| number != 0.0));
    }
}

fn put(table: &mut Table, key: &str, number: Option<f64>) {
    if let Some(number) = number {
        table.insert(key.into(), number.into());
    }
}
