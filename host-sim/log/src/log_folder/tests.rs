use super::*;
use crate::log::{Mounting, Nominal, Sensor, Vehicle};
use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

mod several;

const HEAD: &str = r#"name = "test"
kind = "real"
initial_pose = [1, 2.5, -0.5]

[vehicle]
model = "ackermann"
wheelbase_m = 2.83
encoder_offset_m = 0.76
sensor_forward_m = 3.78
sensor_left_m = 0.5

[sensor]
model = "range_bearing"
range_max_m = 30
bearing_min_rad = -1.5
bearing_max_rad = 1.5
range_sigma_m = 0.1
"#;

/// A folder that is removed at the end of the test.
struct Folder(PathBuf);

impl Folder {
    fn empty() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("scphd-log-{}-{number}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// A small valid log.
    fn sound() -> Self {
        let folder = Self::empty();
        folder.put("log.toml", HEAD);
        folder.put("odometry.csv", "t_s,speed_mps,steering_rad\n0,1.5,0.1\n0.5,2,-0.25\n0.5,3,0\n");
        folder.put("scans.csv", "scan,t_s\n0,0\n2,0.5\n3,1\n");
        folder.put("detections.csv", "scan,range_m,bearing_rad\n0,1,0.5\n3,2,-0.5\n3,3,0.25\n");
        folder
    }

    fn put(&self, file: &str, text: impl AsRef<[u8]>) {
        fs::write(self.0.join(file), text).unwrap();
    }

    fn error(&self) -> String {
        read(&self.0).unwrap_err().to_string()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).unwrap();
    }
}

/// The error for a valid log with one file replaced.
fn with(file: &str, text: impl AsRef<[u8]>) -> String {
    let folder = Folder::sound();
    folder.put(file, text);
    let message = folder.error();
    assert!(!message.contains('\n'), "{message}");
    message
}

/// The error for a valid log with a part of `log.toml` replaced.
fn with_head(piece: &str, other: &str) -> String {
    assert!(HEAD.contains(piece));
    with("log.toml", HEAD.replace(piece, other))
}

#[test]
fn a_valid_folder_is_read() {
    let log = read(&Folder::sound().0).unwrap();
    let row = |t_s, speed, steering| Odometry { t_s, control: [speed, steering, 0.0] };
    let expected = Log {
        name: "test".into(),
        initial_pose: [1.0, 2.5, -0.5],
        vehicle: Vehicle::Ackermann {
            wheelbase_m: 2.83,
            encoder_offset_m: 0.76,
            sensor_forward_m: 3.78,
            sensor_left_m: 0.5,
        },
        sensor: Sensor { range_max_m: 30.0, bearing_min_rad: -1.5, bearing_max_rad: 1.5, ..Sensor::default() },
        nominal: Nominal { range_sigma_m: Some(0.1), ..Nominal::default() },
        odometry: vec![row(0.0, 1.5, 0.1), row(0.5, 2.0, -0.25), row(0.5, 3.0, 0.0)],
        scans: vec![
            Scan { t_s: 0.0, detections: vec![[1.0, 0.5]], ..Scan::default() },
            Scan { t_s: 0.5, detections: vec![], ..Scan::default() },
            Scan { t_s: 1.0, detections: vec![[2.0, -0.5], [3.0, 0.25]], ..Scan::default() },
        ],
        ..Log::default()
    };
    assert_eq!(log, expected);
}

#[test]
fn optional_files_and_other_columns() {
    let folder = Folder::sound();
    // Other order, a byte order mark, Windows line ends, blanks, a label, and an additional column.
    folder.put(
        "detections.csv",
        "\u{feff}label_subject,bearing_rad, range_m ,odd,scan\r\n-1,0.5,1,,0\r\n7,-0.5, 2,nan,3\r\n\r\n8,0.25,3,,3\r\n",
    );
    folder.put("truth.csv", "t_s,x_m,y_m,heading_rad\n0,1,2,0.5\n1,2,3,\n");
    folder.put("landmarks.csv", "x_m,y_m\n4,5\n");
    folder.put("moving.csv", "subject,t_s,x_m,y_m\n2,0,1,1\n2,1,1,2\n-1,0,3,3\n");
    let log = read(&folder.0).unwrap();
    let mut unlabelled = log.scans.clone();
    unlabelled.iter_mut().for_each(|scan| scan.labels.clear());
    assert_eq!(unlabelled, read(&Folder::sound().0).unwrap().scans);
    let labels: Vec<i64> = log.scans.iter().flat_map(|scan| scan.labels.clone()).collect();
    assert_eq!(labels, [-1, 7, 8]);
    let headings: Vec<_> = log.truth.iter().map(|row| row.heading_rad).collect();
    assert_eq!(headings, [Some(0.5), None]);
    assert_eq!(log.landmarks, [[4.0, 5.0]]);
    assert_eq!(log.moving[2], MovingLandmark { subject: -1, t_s: 0.0, position: [3.0, 3.0] });
}

#[test]
fn missing_files_columns_and_keys_are_reported() {
    let folder = Folder::empty();
    assert_eq!(folder.error(), "log.toml: missing");
    let nowhere = folder.0.join("nowhere");
    assert_eq!(read(&nowhere).unwrap_err().to_string(), format!("{}: missing", nowhere.display()));
    for file in ["odometry.csv", "scans.csv", "detections.csv"] {
        let folder = Folder::sound();
        fs::remove_file(folder.0.join(file)).unwrap();
        assert_eq!(folder.error(), format!("{file}: missing"));
    }
    let message = with("odometry.csv", "t_s,v_mps,steering_rad\n");
    assert_eq!(message, "odometry.csv, row 1, column speed_mps: missing");
    for file in ["log.toml", "odometry.csv", "scans.csv", "detections.csv", "truth.csv"] {
        assert_eq!(with(file, "\u{feff}\n"), format!("{file}: empty"));
    }
    assert_eq!(with("scans.csv", "scan,t_s\n"), "scans.csv: no scans");
    assert_eq!(with("truth.csv", "t_s,x_m\n"), "truth.csv, row 1, column y_m: missing");
    let message = with("scans.csv", "scan,t_s,t_s\n");
    assert_eq!(message, "scans.csv, row 1, column t_s: named twice in the header");
}

#[test]
fn invalid_cells_are_reported_with_row_and_column() {
    for bad in ["nan", "inf", "-inf", "1e999", "x", "", "1 2"] {
        let message = with("odometry.csv", format!("t_s,speed_mps,steering_rad\n0,1,0\n1,{bad},0\n"));
        assert_eq!(message, format!("odometry.csv, row 3, column speed_mps: not a finite number: '{bad}'"));
    }
    let message = with("truth.csv", "t_s,x_m,y_m,heading_rad\n0,0,0,east\n");
    assert_eq!(message, "truth.csv, row 2, column heading_rad: not a finite number: 'east'");
    let message = with("scans.csv", "scan,t_s\n0,0\n1.5,1\n");
    assert_eq!(message, "scans.csv, row 3, column scan: not a whole number: '1.5'");
    let message = with("odometry.csv", "t_s,speed_mps,steering_rad\n0,1,0\n1,1\n");
    assert_eq!(message, "odometry.csv, row 3: wrong number of fields: 2, the header has 3");
    let message = with("odometry.csv", b"t_s,speed_mps,steering_rad\n0,\xff,0\n");
    assert_eq!(message, "odometry.csv: not UTF-8 text");
}

#[test]
fn rows_are_lines_of_the_file_for_all_line_ends() {
    for (mark, end, blank) in [("", "\n", 0), ("", "\r\n", 0), ("\u{feff}", "\n", 2), ("\u{feff}", "\r\n", 3)] {
        let header = format!("{mark}scan,t_s");
        let blanks = end.repeat(blank);
        let rows = [header.clone(), format!("{blanks}0,0"), format!("1,1{blanks}"), "2,x".into()];
        let message = with("scans.csv", rows.join(end));
        let expected = format!("scans.csv, row {}, column t_s: not a finite number: 'x'", 4 + 2 * blank);
        assert_eq!(message, expected);
        let rows = [header.clone(), format!("{blanks}0,0"), format!("1,1{blanks}"), "2".into()];
        let message = with("scans.csv", rows.join(end));
        assert!(message.starts_with(&format!("scans.csv, row {}: wrong", 4 + 2 * blank)), "{message}");
    }
}

#[test]
fn order_is_checked() {
    let message = with("odometry.csv", "t_s,speed_mps,steering_rad\n0,1,0\n2,1,0\n1.5,1,0\n");
    assert_eq!(message, "odometry.csv, row 4, column t_s: time goes backwards from 2 to 1.5");
    let message = with("scans.csv", "scan,t_s\n0,1\n1,0\n");
    assert_eq!(message, "scans.csv, row 3, column t_s: time goes backwards from 1 to 0");
    let message = with("truth.csv", "t_s,x_m,y_m\n0,0,0\n-1,0,0\n");
    assert_eq!(message, "truth.csv, row 3, column t_s: time goes backwards from 0 to -1");
    let message = with("moving.csv", "subject,t_s,x_m,y_m\n1,5,0,0\n2,1,0,0\n1,4,0,0\n");
    assert_eq!(message, "moving.csv, row 4, column t_s: time goes backwards from 5 to 4");
    for (twice, least) in [("0,0\n0,1", 1), ("0,0\n4,1\n3,2", 5), ("-1,0", 0)] {
        let message = with("scans.csv", format!("scan,t_s\n{twice}\n"));
        assert!(message.ends_with(&format!("out of order, expected {least} or more")), "{message}");
    }
    let message = with("detections.csv", "scan,range_m,bearing_rad\n0,1,0\n1,1,0\n");
    assert_eq!(message, "detections.csv, row 3, column scan: scan 1 is not in scans.csv");
    let message = with("detections.csv", "scan,range_m,bearing_rad\n2,1,0\n0,1,0\n");
    assert_eq!(message, "detections.csv, row 3, column scan: scan 0 out of order, expected 2 or more");
}

#[test]
fn negative_ranges_are_noise_in_a_simulation_and_errors_otherwise() {
    let negative = "scan,range_m,bearing_rad\n0,-0.5,0\n";
    let message = with("detections.csv", negative);
    let expected = "detections.csv, row 2, column range_m: negative range -0.5 in a log that is not simulated";
    assert_eq!(message, expected);
    let folder = Folder::sound();
    folder.put("detections.csv", negative);
    folder.put("log.toml", HEAD.replace("\"real\"", "\"simulated, by hand\""));
    let log = read(&folder.0).unwrap();
    assert!(log.simulated);
    assert_eq!(log.scans[0].detections, [[-0.5, 0.0]]);
}

#[test]
fn the_head_is_checked() {
    let message = with_head("kind = \"real\"", "kind = ");
    assert!(message.starts_with("log.toml, row 2: "), "{message}");
    assert_eq!(with_head("name = \"test\"", ""), "log.toml, key name: missing");
    assert_eq!(with_head("name = \"test\"", "name = 3"), "log.toml, key name: not a string but 3");
    assert_eq!(with_head("wheelbase_m = 2.83", ""), "log.toml, key vehicle.wheelbase_m: missing");
    let message = with_head("2.83", "\"long\"");
    assert_eq!(message, "log.toml, key vehicle.wheelbase_m: not a finite number but \"long\"");
    assert_eq!(with_head("2.83", "nan"), "log.toml, key vehicle.wheelbase_m: not a finite number but nan");
    assert_eq!(with_head("2.83", "0"), "log.toml, key vehicle.wheelbase_m: 0, expected more than 0");
    let message = with_head("[1, 2.5, -0.5]", "[1, 2.5]");
    assert_eq!(message, "log.toml, key initial_pose: not three finite numbers but [1, 2.5]");
    let message = with_head("range_max_m = 30", "range_max_m = 30\nrange_min_m = 40");
    assert_eq!(message, "log.toml, key sensor.range_max_m: 30, expected more than the least range");
    let message = with_head("bearing_max_rad = 1.5", "bearing_max_rad = -2");
    assert_eq!(message, "log.toml, key sensor.bearing_max_rad: -2, expected more than bearing_min_rad");
    let message = with_head("range_sigma_m = 0.1", "detection_probability = 0");
    assert_eq!(message, "log.toml, key sensor.detection_probability: 0, expected more than 0 and at most 1");
    let message = with_head("range_sigma_m = 0.1", "detection_probability = 1.5");
    assert_eq!(message, "log.toml, key sensor.detection_probability: 1.5, expected more than 0 and at most 1");
    let message = with_head("range_sigma_m = 0.1", "range_sigma_m = -1");
    assert_eq!(message, "log.toml, key sensor.range_sigma_m: -1, expected 1e-6 to 1000 m");
    let message = with_head("range_sigma_m = 0.1", "range_sigma_m = 0");
    assert_eq!(message, "log.toml, key sensor.range_sigma_m: 0, expected 1e-6 to 1000 m");
    let message = with_head("range_sigma_m = 0.1", "range_sigma_ratio = 1.5");
    assert_eq!(message, "log.toml, key sensor.range_sigma_ratio: 1.5, expected 0 to 1");
    let message = with_head("range_sigma_m = 0.1", "bearing_sigma_rad = 0.0");
    assert_eq!(message, "log.toml, key sensor.bearing_sigma_rad: 0, expected 1e-6 to 3 rad");
    let message = with_head("wheelbase_m = 2.83", "wheelbase_m = 2.83\nspeed_sigm_mps = 1.0");
    assert!(message.starts_with("log.toml, key vehicle.speed_sigm_mps: unknown, there are model, "), "{message}");
}

#[test]
fn keys_without_effect_are_refused() {
    let message = with_head("name = \"test\"", "name = \"test\"\nsimulatd = true");
    assert!(message.starts_with("log.toml, key simulatd: unknown, there are name, kind, simulated, "), "{message}");
    let message = with("log.toml", format!("{HEAD}[noise]\nrange_sigma_m = 1\n"));
    assert!(message.starts_with("log.toml, key noise: unknown, there are "), "{message}");
    let message = with_head("wheelbase_m = 2.83", "wheelbase_m = 2.83\nrate_sigma_radps = 0.1");
    let expected = "log.toml, key vehicle.rate_sigma_radps: not a key of the model ackermann, which has model, ";
    assert!(message.starts_with(expected), "{message}");
    let geometry = HEAD.split("wheelbase_m").nth(1).unwrap().split("\n\n[sensor]").next().unwrap();
    for model in ["unicycle", "unicycle_arc"] {
        let head =
            HEAD.replace("\"ackermann\"", &format!("\"{model}\"")).replace(&format!("wheelbase_m{geometry}"), "");
        for key in ["encoder_offset_m", "wheelbase_m", "steering_sigma_rad"] {
            let message = with("log.toml", head.replace("[sensor]", &format!("{key} = 0.5\n[sensor]")));
            let expected = format!(
                "log.toml, key vehicle.{key}: not a key of the model {model}, which has model, sensor_forward_m, \
                 sensor_left_m, sensor_yaw_rad, speed_sigma_mps, rate_sigma_radps"
            );
            assert_eq!(message, expected);
        }
    }
}

#[test]
fn one_key_states_whether_a_log_is_simulated() {
    let simulated = |kind: &str| {
        let folder = Folder::sound();
        folder.put("log.toml", HEAD.replace("kind = \"real\"", kind));
        read(&folder.0).map(|log| log.simulated).map_err(|error| error.to_string())
    };
    for (kind, expected) in [
        ("simulated = true", true),
        ("simulated = false", false),
        ("simulated = true\nkind = \"real, but for the vehicle\"", true),
        ("simulated = false\nkind = \"Simulated\"", false),
        ("kind = \"simulated\"", true),
        ("kind = \"simulated, noise by hand\"", true),
        ("kind = \"real, outdoor\"", false),
        ("kind = \"real: a yard\"", false),
        ("kind = \"simulated; by hand\"", true),
        ("", false),
    ] {
        assert_eq!(simulated(kind), Ok(expected), "{kind}");
    }
    for kind in
        ["Simulated", "simulation", "SIMULATED", "synthetic", "realistic simulation", "not simulated", "", "reality"]
    {
        let expected = format!(
            "log.toml, key kind: '{kind}' says neither real nor simulated: say simulated = true or simulated = false"
        );
        assert_eq!(simulated(&format!("kind = \"{kind}\"")), Err(expected));
    }
    let expected = "log.toml, key simulated: not true or false but \"yes\"";
    assert_eq!(simulated("simulated = \"yes\""), Err(expected.into()));
    assert_eq!(simulated("kind = 1"), Err("log.toml, key kind: not a string but 1".into()));
}

#[test]
fn names_are_one_line_of_characters() {
    let named = |name: &str| with_head("name = \"test\"", &format!("name = \"{name}\""));
    let expected = "log.toml, key name: a name has 1 to 200 characters, none of them a control character";
    for name in ["a\\u0000b", "two\\nlines", "\\u001b[31mred", "tab\\t", "\\u009b", "\\uffff", "", &"x".repeat(201)] {
        assert_eq!(named(name), expected, "{name}");
    }
    let folder = Folder::sound();
    folder.put("log.toml", HEAD.replace("name = \"test\"", "name = \"Überfahrt <3> & 'co' 測試\""));
    assert_eq!(read(&folder.0).unwrap().name, "Überfahrt <3> & 'co' 測試");
}

#[test]
fn angles_in_degrees_are_refused() {
    // The first bearing is small, the second one shows the unit.
    let message = with("detections.csv", "scan,range_m,bearing_rad\n0,1,2.5\n3,2,-3.5\n3,2,40\n");
    let expected = "detections.csv, row 3, column bearing_rad: -3.5, expected -3.1426 to 3.1426: angles are in radians, \
        these look like degrees";
    assert_eq!(message, expected);
    let message = with("detections.csv", "scan,range_m,bearing_rad\n0,1,2.5\n3,2,6.1\n");
    assert!(
        message.contains("6.1, expected -3.1426 to 3.1426: angles are in radians, take whole turns off"),
        "{message}"
    );
    let message = with("odometry.csv", "t_s,speed_mps,steering_rad\n0,1,1\n1,1,25\n");
    let expected = "odometry.csv, row 3, column steering_rad: 25, expected -1.5708 to 1.5708: ";
    assert!(message.starts_with(expected), "{message}");
    let message = with_head("bearing_min_rad = -1.5", "bearing_min_rad = -90");
    assert!(message.starts_with("log.toml, key sensor.bearing_min_rad: -90, expected "), "{message}");
    let message = with_head("[1, 2.5, -0.5]", "[1, 2.5, 270]");
    assert!(message.starts_with("log.toml, key initial_pose: 270, expected "), "{message}");
    assert!(message.ends_with("these look like degrees"), "{message}");
    // π with few digits.
    let folder = Folder::sound();
    folder.put("detections.csv", "scan,range_m,bearing_rad\n0,1,3.142\n3,2,-3.1416\n");
    assert!(read(&folder.0).is_ok());
}

/// The written time for a time, s.
type Written = fn(f64) -> f64;

/// A log of 10 Hz with times in other units.
fn timed(odometry: Written, scans: Written) -> Folder {
    let folder = Folder::sound();
    let times = || (0..40).map(|k| 0.1 * f64::from(k));
    let rows: String = times().map(|t| format!("{},1,0\n", odometry(t))).collect();
    folder.put("odometry.csv", format!("t_s,speed_mps,steering_rad\n{rows}"));
    let rows: String = times().enumerate().map(|(k, t)| format!("{k},{}\n", scans(t))).collect();
    folder.put("scans.csv", format!("scan,t_s\n{rows}"));
    folder
}

#[test]
fn times_in_other_units_are_refused() {
    fn same(t: f64) -> f64 {
        t
    }
    assert!(read(&timed(same, same).0).is_ok());
    // Seconds since another epoch are valid.
    assert!(read(&timed(|t| t + 1.7e9, |t| t + 1.7e9).0).is_ok());
    let cases: [(Written, &str); 3] =
        [(|t| 1e3 * t, "milliseconds"), (|t| 1e6 * t, "microseconds"), (|t| 1.7e18 + 1e9 * t, "nanoseconds")];
    for (time, unit) in cases {
        let message = timed(time, time).error();
        assert!(message.starts_with("odometry.csv, row 3, column t_s: rows are "), "{message}");
        assert!(message.ends_with(&format!("times are in seconds, these look like {unit}")), "{message}");
        let message = timed(same, time).error();
        assert!(message.starts_with("scans.csv, row 3, column t_s: rows are "), "{message}");
        assert!(message.ends_with(unit), "{message}");
    }
    // Intervals of a second are plausible in seconds and in milliseconds; the scans show the unit.
    let message = timed(|t| 10.0 * t, |t| 1000.0 * t).error();
    assert!(message.starts_with("scans.csv, row 3, column t_s: rows are 100 s apart in the median"), "{message}");
    let folder = timed(same, |t| 50.0 * t);
    let rows: String = (0..2000).map(|k| format!("{},20,0\n", 0.1 * f64::from(k))).collect();
    folder.put("odometry.csv", format!("t_s,speed_mps,steering_rad\n{rows}"));
    let message = folder.error();
    assert!(message.starts_with("odometry.csv, column speed_mps: the vehicle drives 100 m"), "{message}");
    assert!(message.contains("speeds are in metres a second"), "{message}");
    // Times since boot and times since the epoch.
    let message = timed(same, |t| t + 1.7e9).error();
    assert!(message.starts_with("scans.csv, row 2, column t_s: a scan at 1700000000 s"), "{message}");
}

#[test]
fn odometry_outside_the_time_of_the_scans_is_refused() {
    let message = with("odometry.csv", "t_s,speed_mps,steering_rad\n");
    assert_eq!(message, "odometry.csv: no odometry");
    let message = with("odometry.csv", "t_s,speed_mps,steering_rad\n1.5,1,0\n1.6,1,0\n");
    assert_eq!(message, "odometry.csv, row 2, column t_s: the odometry begins at 1.5 s, after the last scan at 1 s");
    let message = with("odometry.csv", "t_s,speed_mps,steering_rad\n-1,1,0\n0.1,1,0\n");
    let expected = "scans.csv, row 3, column t_s: a scan at 0.5 s, and most scans are not between the first row of \
        odometry at -1 s and the last at 0.1 s: ";
    assert!(message.starts_with(expected), "{message}");
    // A single row holds for ever.
    let folder = Folder::sound();
    folder.put("odometry.csv", "t_s,speed_mps,steering_rad\n0,0,0\n");
    assert!(read(&folder.0).is_ok());
}

#[test]
fn ranges_in_millimetres_are_refused() {
    let message = with("detections.csv", "scan,range_m,bearing_rad\n0,1000,0.5\n3,2000,-0.5\n3,30,0.25\n");
    let expected = "detections.csv, column range_m: 1000 m in the median, twice the sensor's greatest range is 60 m: ";
    assert!(message.starts_with(expected), "{message}");
}

#[test]
fn any_scan_numbers_are_read() {
    let greatest = i64::MAX;
    let folder = Folder::sound();
    folder.put("scans.csv", format!("scan,t_s\n0,0\n2,0.5\n{greatest},1\n"));
    folder.put("detections.csv", format!("scan,range_m,bearing_rad\n0,1,0\n{greatest},2,0.5\n"));
    assert_eq!(read(&folder.0).unwrap().scans[2].detections, [[2.0, 0.5]]);
    folder.put("scans.csv", format!("scan,t_s\n0,0\n{greatest},1\n{greatest},2\n"));
    let expected =
        format!("scans.csv, row 4, column scan: scan {greatest} out of order, expected 9223372036854775808 or more");
    assert_eq!(folder.error(), expected);
    let message = with("scans.csv", "scan,t_s\n9223372036854775808,0\n");
    assert_eq!(message, "scans.csv, row 2, column scan: not a whole number: '9223372036854775808'");
}

#[test]
fn excerpts_in_messages_are_short_and_printable() {
    let message = with("scans.csv", format!("scan,t_s\n0,\"a\n\u{1b}[2J{}\"\n", "x".repeat(10_000)));
    assert!(message.starts_with("scans.csv, row 2, column t_s: not a finite number: 'a\\n\\u{1b}[2Jxxx"), "{message}");
    assert!(message.ends_with("x …'") && message.len() < 250, "{message}");
    let message = with_head("2.83", &format!("[{}]", "1, ".repeat(10_000)));
    assert!(message.len() < 250, "{message}");
}

#[test]
fn unsupported_models_are_reported() {
    let message = with_head("\"ackermann\"", "\"hovercraft\"");
    let expected = "log.toml, key vehicle.model: 'hovercraft' is not supported yet, only ackermann, unicycle, unicycle_arc and holonomic";
    assert_eq!(message, expected);
    let message = with_head("\"range_bearing\"", "\"stereo\"");
    assert_eq!(message, "log.toml, key sensor.model: 'stereo' is not supported yet, only range_bearing");
    let message = with("log.toml", "name = \"camera\"\n[camera]\nfu = 484.5\n");
    assert_eq!(message, "log.toml, key camera: 'camera' is not supported yet, only range_bearing");
    if let Some(dir) = scphd_shared_data::find("starry_night") {
        assert_eq!(read(&dir).unwrap_err().to_string(), message);
    }
}

#[test]
fn written_logs_are_read_bit_for_bit() {
    let third = 1.0 / 3.0;
    let mut log = read(&Folder::sound().0).unwrap();
    log.name = "quotes \" and \\ 'strokes'".into();
    log.simulated = true;
    log.vehicle = Vehicle::UnicycleArc;
    log.sensor.range_min_m = 0.1 + 0.2;
    log.nominal = Nominal {
        range_sigma_m: Some(third),
        range_sigma_ratio: third,
        bearing_sigma_rad: Some(third * 1e-5),
        speed_sigma_mps: Some(0.0),
        rate_sigma_radps: Some(2e-20),
        steering_sigma_rad: None,
        detection_probability: Some(1.0),
        clutter_per_scan: Some(20.0),
    };
    log.odometry[1].control = [-third * 1e-9, f64::MAX, 0.0];
    log.scans[2].detections[0] = [-third, f64::MIN_POSITIVE / 8.0];
    log.truth = vec![
        TruePose { t_s: -1.0, position: [third, 1e300], heading_rad: Some(third) },
        TruePose { t_s: 0.0, position: [0.0, 1.0], heading_rad: None },
    ];
    log.truth_sigma_m = third;
    log.landmarks = vec![[third, -third]];
    log.moving = vec![MovingLandmark { subject: -3, t_s: third, position: [1.0, third] }];
    let folder = Folder::empty();
    write(&log, &folder.0).unwrap();
    assert_eq!(read(&folder.0).unwrap(), log);

    let again = write(&log, &folder.0).unwrap_err();
    assert_eq!(again.kind(), std::io::ErrorKind::AlreadyExists);

    log.vehicle = Vehicle::Holonomic;
    log.odometry[1].control[2] = -third;
    let folder = Folder::empty();
    write(&log, &folder.0).unwrap();
    let text = fs::read_to_string(folder.0.join("odometry.csv")).unwrap();
    assert!(text.starts_with("t_s,vx_mps,vy_mps,omega_radps\n"), "{text}");
    assert_eq!(read(&folder.0).unwrap(), log);
    fs::write(folder.0.join("odometry.csv"), text.replace("vy_mps", "left")).unwrap();
    assert!(read(&folder.0).unwrap_err().to_string().contains("vy_mps"));

    log.odometry[1].control[2] = 0.0;
    log.vehicle = Vehicle::Unicycle;
    log.truth.remove(0);
    let folder = Folder::empty();
    let inner = folder.0.join("made/on/the/way");
    write(&log, &inner).unwrap();
    assert_eq!(read(&inner).unwrap(), log);
    assert!(!fs::read_to_string(inner.join("truth.csv")).unwrap().contains("heading"));
}

/// Every value of a numeric CSV file, by rows, read without the tested code.
fn plain(dir: &Path, file: &str) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(dir.join(file)).unwrap();
    text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

#[test]
fn the_published_logs_read_exactly() {
    let mut names = vec!["victoria_park".into(), "car_park".into()];
    names.extend((1..=3).map(|k| format!("mrclam_ds6_robot{k}")));
    names.extend((0..6).map(|k| format!("phd_slam3_a0{k}")));
    names.extend((0..5).map(|k| format!("thesis_cmp_a0{k}")));
    for name in names {
        let Some(dir) = scphd_shared_data::find(&name) else {
            return;
        };
        let log = read(&dir).unwrap();
        let odometry: Vec<_> = log.odometry.iter().map(|row| vec![row.t_s, row.control[0], row.control[1]]).collect();
        assert_eq!(odometry, plain(&dir, "odometry.csv"), "{name}");
        let times: Vec<_> = log.scans.iter().map(|scan| scan.t_s).collect();
        let scans = plain(&dir, "scans.csv");
        assert_eq!(times, scans.iter().map(|row| row[1]).collect::<Vec<_>>(), "{name}");
        let detections: Vec<_> = log
            .scans
            .iter()
            .zip(&scans)
            .flat_map(|(scan, row)| scan.detections.iter().map(|z| [row[0], z[0], z[1]]))
            .collect();
        let expected: Vec<_> = plain(&dir, "detections.csv").iter().map(|row| [row[0], row[1], row[2]]).collect();
        assert_eq!(detections, expected, "{name}");
        let truth: Vec<_> = log
            .truth
            .iter()
            .map(|row| {
                [row.t_s, row.position[0], row.position[1]].into_iter().chain(row.heading_rad).collect::<Vec<_>>()
            })
            .collect();
        assert_eq!(truth, plain(&dir, "truth.csv"), "{name}");
        assert_eq!(log.simulated, name.starts_with("phd_slam3") || name.starts_with("thesis_cmp"));

        let folder = Folder::empty();
        write(&log, &folder.0).unwrap();
        assert_eq!(read(&folder.0).unwrap(), log, "{name}");
    }
}
