//! Several sensors and fixes.

use super::*;
use crate::log::{Fix, PoseFix};

/// The head of a valid log with its `[sensor]` as two sensors.
fn of_two() -> String {
    let (before, sensor) = HEAD.split_once("[sensor]").unwrap();
    let named = |name: &str, more: &str| format!("[[sensors]]\nname = \"{name}\"\n{more}{}\n", sensor.trim());
    format!("{before}{}{}", named("rear", "yaw_rad = 3.1\nforward_m = -1\n"), named("front", ""))
}

/// A valid log of two sensors with fixes.
fn sound_of_two() -> Folder {
    let folder = Folder::sound();
    folder.put("log.toml", of_two() + "[fixes]\nposition_sigma_m = 2\nheading_sigma_rad = 0.1\n");
    folder.put("scans.csv", "scan,t_s,sensor\n0,0,rear\n2,0.5,front\n3,1,rear\n");
    folder.put("fixes.csv", "t_s,x_m,y_m,heading_rad\n0,1,2.5,\n0.75,,,0.5\n0.75,2,3,0.5\n");
    folder
}

#[test]
fn two_sensors_and_fixes() {
    let log = read(&sound_of_two().0).unwrap();
    let names: Vec<&str> = log.sensors().map(|(name, ..)| name).collect();
    // In order of the names, not of the sections.
    assert_eq!(names, ["front", "rear"]);
    assert_eq!(log.scans.iter().map(|scan| scan.sensor).collect::<Vec<_>>(), [1, 0, 1]);
    let at = Mounting { forward_m: -1.0, left_m: 0.0, yaw_rad: 3.1 };
    assert_eq!((log.sensor.mounting, log.others[0].sensor.mounting), (Mounting::NONE, at));
    assert_eq!((log.nominal.range_sigma_m, log.others[0].nominal.range_sigma_m), (Some(0.1), Some(0.1)));
    let fix = |t_s, measured| Fix { t_s, measured };
    let expected = [
        fix(0.0, PoseFix::Position([1.0, 2.5])),
        fix(0.75, PoseFix::Heading(0.5)),
        fix(0.75, PoseFix::Position([2.0, 3.0])),
        fix(0.75, PoseFix::Heading(0.5)),
    ];
    assert_eq!(log.fixes, expected);
    assert_eq!((log.fix_noise.position_sigma_m, log.fix_noise.gate), (Some(2.0), None));
}

#[test]
fn errors_of_sensors_and_fixes_are_reported() {
    let refused = |file: &str, text: &str, expected: &str| {
        let folder = sound_of_two();
        folder.put(file, text);
        let message = folder.error();
        let begins = message.strip_prefix(file).and_then(|rest| rest.strip_prefix(", "));
        assert!(
            begins.is_some_and(|rest| rest.starts_with(expected)) && !message.contains('\n'),
            "{message}\n{expected}"
        );
    };
    let fixes = "[fixes]\nposition_sigma_m = 2\nheading_sigma_rad = 0.1\n";
    let head = of_two() + fixes;
    // A part of the head, and its replacement.
    for (piece, other, expected) in [
        ("name = \"rear\"", "name = \"front\"", "key sensors[2].name: 'front' is the name of two sensors"),
        ("name = \"rear\"", "name = \"my radar\"", "key sensors[1].name: a sensor's name has"),
        ("name = \"rear\"\n", "", "key sensors[1].name: missing"),
        (
            "yaw_rad = 3.1",
            "yaw_rad = 90",
            "key sensors.rear.yaw_rad: 90, expected -6.2842 to 6.2842: angles are in radians, these look like degrees",
        ),
        ("forward_m = -1", "forwards_m = -1", "key sensors.rear.forwards_m: unknown"),
        ("sensor_left_m = 0.5", "sensor_left_m = 0.5\nsensor_yaw_rad = 1", "key vehicle.sensor_yaw_rad: not a key"),
        ("position_sigma_m = 2\n", "", "key fixes.position_sigma_m: missing"),
        ("heading_sigma_rad = 0.1", "heading_sigma_rad = 5", "key fixes.heading_sigma_rad: 5, expected"),
        ("heading_sigma_rad = 0.1", "yaw_rad = 0.1", "key fixes.yaw_rad: unknown"),
        ("heading_sigma_rad = 0.1", "gate = 0", "key fixes.gate: 0, expected more than 0"),
        ("heading_sigma_rad = 0.1", "patience_s = -1", "key fixes.patience_s: -1, expected 0 or more"),
        (fixes, "", "key fixes: missing: it says how good"),
    ] {
        assert!(head.contains(piece), "{piece}");
        refused("log.toml", &head.replacen(piece, other, 1), expected);
    }
    let both = HEAD.to_owned() + &of_two()[of_two().find("[[").unwrap()..];
    refused("log.toml", &both, "key sensor: either one [sensor] or several");
    for (file, text, expected) in [
        (
            "scans.csv",
            "scan,t_s,sensor\n0,0,rear\n2,0.5,sonar\n",
            "row 3, column sensor: no sensor 'sonar', log.toml has front, rear",
        ),
        ("scans.csv", "scan,t_s\n0,0\n", "row 1, column sensor: missing"),
        (
            "fixes.csv",
            "t_s,x_m,y_m\n-0.5,1,2\n",
            "row 2, column t_s: a fix at -0.5 s, before the odometry, which begins at 0 s",
        ),
        ("fixes.csv", "t_s,x_m,y_m\n0.5,1,inf\n", "row 2, column y_m: not a finite number: 'inf'"),
        ("fixes.csv", "t_s,x_m,y_m\n0.5,1,\n", "row 2, column y_m: not a finite number: ''"),
        ("fixes.csv", "t_s,x_m,y_m\n0.5,,\n", "row 2, column t_s: no fix"),
        ("fixes.csv", "t_s,x_m\n0.5,1\n", "row 1, column y_m: missing"),
        (
            "fixes.csv",
            "t_s,heading_rad\n0.5,90\n",
            "row 2, column heading_rad: 90, expected -6.2842 to 6.2842: angles are in radians, these look like degrees",
        ),
        ("fixes.csv", "t_s,heading_rad\n0.5,1\n0.25,1\n", "row 3, column t_s: time goes backwards"),
        ("fixes.csv", "t_s,heading_rad\n500,1\n", "column t_s: the first fix is at 500 s, after the last scan at 1 s"),
    ] {
        refused(file, text, expected);
    }
    let folder = sound_of_two();
    fs::remove_file(folder.0.join("fixes.csv")).unwrap();
    assert_eq!(folder.error(), "fixes.csv: missing");
}
