//! Destinations of the program's results: files, the standard output, and others.

use crate::place::Place;
use serde_json::Value;
use std::fs;

/// A folder with a log of one second.
fn workplace() -> Place {
    Place::with_log(11)
}

/// Standard output and standard error of a command that must succeed.
fn said(place: &Place, args: &[&str]) -> (Vec<u8>, String) {
    let output = place.succeeds(args);
    (output.stdout, String::from_utf8(output.stderr).unwrap())
}

const REPLAY: [&str; 4] = ["replay", "log", "--particles", "2"];

#[test]
fn a_dash_means_the_standard_output_and_tables_go_to_stderr() {
    let place = workplace();
    let json = |args: &[&str]| -> (Value, String) {
        let (stdout, stderr) = said(&place, args);
        (serde_json::from_slice(&stdout).unwrap_or_else(|error| panic!("{args:?}: {error}")), stderr)
    };
    let (run, table) = json(&[&REPLAY[..], &["--json", "-"]].concat());
    assert_eq!(run["scans"], 11);
    assert!(table.contains("position RMSE (m)") && table.contains("health, scphd f32"), "{table}");
    let (runs, table) = json(&[&REPLAY[..], &["--repeat", "2", "--json", "-"]].concat());
    assert!(runs.as_array().is_some_and(|runs| runs.len() == 2) && table.contains("RMSE"), "{table}");
    let (_, table) = json(&["monte-carlo", "log", "--particles", "2", "--json", "-"]);
    assert!(table.contains("position error, mean (m)"), "{table}");

    let (settings, table) = said(&place, &["tune", "log", "--particles", "2", "--rounds", "1", "--out", "-"]);
    assert!(table.contains("proposed"), "{table}");
    fs::write(place.path("tuned.toml"), &settings).unwrap();
    place.succeeds(&[&REPLAY[..], &["--settings", "tuned.toml"]].concat());
    place.succeeds(&["stream", "log", "log.bin"]);
    let (bytes, said) = said(&place, &["stream", "log", "-"]);
    assert_eq!(bytes, fs::read(place.path("log.bin")).unwrap());
    assert!(said.contains("11 scans"), "{said}");
    assert!(!place.path("-").exists());
}

#[test]
fn destinations_that_must_not_be_replaced_are_refused_before_the_run() {
    let place = workplace();
    fs::create_dir(place.path("folder")).unwrap();
    fs::write(place.path("guarded"), "kept").unwrap();
    let mut permissions = fs::metadata(place.path("guarded")).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(place.path("guarded"), permissions).unwrap();
    for (file, why) in [("guarded", "read-only"), ("folder", "is a folder"), ("gone/file", "no folder gone")] {
        let cases: [&[&str]; 4] = [
            &[&REPLAY[..], &["--json", file]].concat(),
            &["monte-carlo", "log", "--json", file],
            &["tune", "log", "--out", file],
            &["stream", "log", file],
        ];
        for args in cases {
            let error = place.fails(args);
            assert!(error.contains(file) && error.contains(why), "{args:?}: {error}");
        }
    }
    assert_eq!(fs::read(place.path("guarded")).unwrap(), b"kept");
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    #[test]
    fn the_path_of_the_standard_output_means_the_standard_output() {
        let place = workplace();
        let args = [&REPLAY[..], &["--json", "/dev/stdout"]].concat();
        let (stdout, stderr) = said(&place, &args);
        let run: Value = serde_json::from_slice(&stdout).unwrap();
        assert_eq!(run["scans"], 11);
        assert!(stderr.contains("position RMSE (m)"), "{stderr}");
        // A file that is the standard output, by its name.
        let file = fs::File::create(place.path("run.json")).unwrap();
        let mut command = place.command(&args);
        command.stdout(file).stderr(std::process::Stdio::null());
        assert!(command.status().unwrap().success());
        let run: Value = place.json("run.json");
        assert_eq!(run["scans"], 11);
    }

    #[test]
    fn links_remain_and_lead_to_the_results() {
        let place = workplace();
        fs::create_dir(place.path("far")).unwrap();
        fs::write(place.path("far/run.json"), "old").unwrap();
        symlink("far/run.json", place.path("run.json")).unwrap();
        symlink("gone", place.path("nowhere")).unwrap();
        place.succeeds(&[&REPLAY[..], &["--json", "run.json"]].concat());
        let run: Value = place.json("far/run.json");
        assert_eq!(run["scans"], 11);
        assert!(fs::symlink_metadata(place.path("run.json")).unwrap().is_symlink());
        let error = place.fails(&[&REPLAY[..], &["--json", "nowhere"]].concat());
        assert!(error.contains("leads nowhere"), "{error}");
        assert!(!place.path("gone").exists());

        // All files of a folder: tables, SVG and PNG.
        let tables = ["scans.csv", "error.svg", "error.png"];
        fs::create_dir(place.path("out")).unwrap();
        for table in tables {
            fs::write(place.path("far").join(table), "old").unwrap();
            symlink(place.path("far").join(table), place.path("out").join(table)).unwrap();
        }
        place.succeeds(&[&REPLAY[..], &["--out", "out"]].concat());
        for table in tables {
            assert!(fs::symlink_metadata(place.path("out").join(table)).unwrap().is_symlink(), "{table}");
            assert!(fs::metadata(place.path("far").join(table)).unwrap().len() > 3, "{table}");
        }
        for table in tables {
            fs::set_permissions(place.path("far").join(table), fs::Permissions::from_mode(0o444)).unwrap();
            let error = place.fails(&[&REPLAY[..], &["--out", "out"]].concat());
            assert!(error.contains(table) && error.contains("read-only"), "{error}");
            fs::set_permissions(place.path("far").join(table), fs::Permissions::from_mode(0o644)).unwrap();
        }
    }
}

/// The printed table of settings for a firmware describes the joint map of a replay, in C and in Rust.
#[test]
fn settings_are_printed_as_constants() {
    use scphd_vehicle::{Description, Setting};
    let place = Place::with_log(5);
    let rust = place.prints(&["settings", "log", "--as", "rust"]);
    let mut described = Description::<f32>::robot();
    let rows: Vec<Vec<&str>> = rust
        .lines()
        .filter_map(|line| line.trim().strip_prefix('('))
        .map(|row| row.split([',', ')']).collect())
        .collect();
    assert!(rows.len() > 10, "{rust}");
    for row in &rows {
        let [name, sensor, number] = [row[0].trim_matches('"'), row[1].trim(), row[2].trim()];
        let number = if number == "f32::INFINITY" { f32::INFINITY } else { number.parse().unwrap() };
        described.set(Setting::of_name(name).unwrap(), sensor.parse().unwrap(), number).unwrap();
    }
    let log = scphd_log::log_folder::read(&place.path("log")).unwrap();
    let whole = scphd_filters::describe::description(&log, &scphd_filters::settings::Settings::for_log(&log));
    for setting in Setting::all() {
        let of = |description: &Description<f64>| description.get(setting, 0).map(|number| number as f32);
        assert_eq!(described.get(setting, 0), of(&whole), "{}", setting.name());
    }
    let c = place.prints(&["settings", "log", "--as", "c"]);
    let header = include_str!("../../../bindings/capi/include/scphd.h");
    let names = c.split(|letter: char| !(letter.is_ascii_alphanumeric() || letter == '_'));
    let names: Vec<&str> = names.filter(|word| word.starts_with("SCPHD_")).collect();
    assert!(names.len() >= rows.len());
    for name in names {
        assert!(header.contains(&format!("#define {name} ")), "{name}");
    }
    place.fails(&["settings", "girona-tank", "--as", "c"]);
}
