//! Invalid input is refused with exit code 2 and one line that has file, row and key.

use crate::folders::{self, stereo};
use crate::place::{Place, row, timeless};
use scphd_log::log_folder;
use scphd_worlds::scenario;
use serde_json::Value;
use std::fs;

/// A folder with a log in the plane in `log` and one of a stereo camera in `stereo`.
fn workplace() -> Place {
    let place = Place::with_log(41);
    folders::put(&place.path("stereo"), &stereo());
    place
}

fn change(place: &Place, file: &str, change: impl FnOnce(String) -> String) {
    let old = fs::read_to_string(place.path(file)).unwrap();
    let new = change(old.clone());
    assert_ne!(new, old, "{file}");
    place.write(file, new);
}

/// The rows below the header with one column changed.
fn column(text: &str, place: usize, change: impl Fn(f64) -> String) -> String {
    let mut lines = text.lines();
    let mut new = format!("{}\n", lines.next().unwrap());
    for line in lines {
        let cells = line
            .split(',')
            .enumerate()
            .map(|(index, cell)| if index == place { change(cell.parse().unwrap()) } else { cell.to_owned() });
        new.push_str(&(cells.collect::<Vec<_>>().join(",") + "\n"));
    }
    new
}

/// A log, its file, the change, and the required parts of the message.
type Case = (&'static str, &'static str, fn(String) -> String, &'static [&'static str]);

#[test]
fn invalid_logs_are_refused() {
    let degrees: fn(String) -> String = |text| column(&text, 2, |bearing| bearing.to_degrees().to_string());
    let milliseconds: fn(String) -> String = |text| column(&text, 0, |t| (1e3 * t).to_string());
    let header: fn(String) -> String = |text| format!("{}\n", text.lines().next().unwrap());
    let late: fn(String) -> String = |text| column(&text, 0, |t| (t + 100.0).to_string());
    let cases: [Case; 11] = [
        ("log", "detections.csv", degrees, &["detections.csv, row ", "column bearing_rad", "look like degrees"]),
        ("log", "log.toml", |text| format!("colour = 1\n{text}"), &["log.toml, key colour", "unknown", "simulated"]),
        ("log", "odometry.csv", late, &["odometry.csv, row 2", "column t_s", "after the last scan at 4 s"]),
        ("stereo", "odometry.csv", milliseconds, &["odometry.csv, row 3", "column t_s", "look like milliseconds"]),
        (
            "stereo",
            "scans.csv",
            |text| column(&text, 1, |t| (1e9 * t).to_string()),
            &["scans.csv, row 3", "column t_s", "look like nanoseconds"],
        ),
        ("stereo", "log.toml", |text| format!("{text}[gps]\nsigma_m = 1\n"), &["log.toml, key gps", "unknown"]),
        ("stereo", "log.toml", |text| format!("{text}fw = 1\n"), &["log.toml, key camera.fw", "unknown"]),
        (
            "stereo",
            "log.toml",
            |text| format!("simulated = \"no\"\n{text}"),
            &["log.toml, key simulated", "true or false"],
        ),
        (
            "stereo",
            "log.toml",
            |text| text.replace("\"stereo\"", "\"ste\\u0000reo\""),
            &["log.toml, key name", "control character"],
        ),
        ("stereo", "odometry.csv", header, &["odometry.csv", "no odometry"]),
        ("stereo", "odometry.csv", late, &["odometry.csv, row 2", "column t_s", "after the last scan"]),
    ];
    for (log, file, change, parts) in cases {
        let place = workplace();
        self::change(&place, &format!("{log}/{file}"), change);
        let error = place.fails(&["replay", log, "--json", "run.json", "--out", "out"]);
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        assert!(!place.path("run.json").exists() && !place.path("out").exists(), "{error}");
    }
}

#[test]
fn settings_without_possible_births_are_refused() {
    let place = workplace();
    let cases = [
        (
            "log",
            "[sensor]\ndetection_near = 0\ndetection_far = 0",
            ["sensor.detection_near = 0", "nothing is ever detected"],
        ),
        (
            "log",
            "[filter]\nbirth_intensity = 1e-9",
            ["filter.birth_intensity = 0.000000001", "no feature is ever born"],
        ),
        ("log", "[filter]\nprune_weight = 0.9", ["filter.birth_intensity = ", "filter.prune_weight"]),
        ("stereo", "[camera]\ndetection = 0", ["camera.detection = 0", "more than 0"]),
        ("stereo", "[filter]\nbirth_intensity = 1e-30", ["filter.birth_intensity = ", "no feature is ever born"]),
    ];
    for (log, text, parts) in cases {
        place.write("bad.toml", text);
        let error = place.fails(&["replay", log, "--settings", "bad.toml", "--json", "run.json"]);
        assert!(parts.iter().all(|part| error.contains(part)), "{text}: {error}");
    }
}

#[test]
fn an_estimate_worse_than_dead_reckoning_is_reported() {
    let place = workplace();
    // The odometry is the truth, but the filter has settings with large odometry noise.
    let mut log = scenario::survey(1);
    log.scans.truncate(41);
    log.truth.truncate(41);
    log.odometry.truncate(82);
    for (place, row) in log.odometry.iter_mut().enumerate() {
        row.control = [3.0, if place < 80 { 0.0 } else { row.control[1] }, 0.0];
    }
    log_folder::write(&log, &place.path("exact")).unwrap();
    fs::write(
        place.path("loose.toml"),
        "[filter]\nproposal = \"blind\"\nproposal_sampled_fraction = 1.0\n[vehicle]\nspeed_sigma_mps = 20\nturn_sigma = 1\n",
    )
    .unwrap();
    let args = ["replay", "exact", "--particles", "2", "--settings", "loose.toml", "--json", "run.json"];
    let output = place.succeeds(&args);
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(
        told.starts_with("warning: survey by scphd f32: the estimate is worse than dead reckoning (seed 1: "),
        "{told}"
    );
    let json = |file: &str| -> Value { place.json(file) };
    assert_eq!(json("run.json")["worse_than_dead_reckoning"], true);
    let output = place.succeeds(&[&args[..], &["--repeat", "2"]].concat());
    assert!(String::from_utf8(output.stderr).unwrap().contains("worse than dead reckoning in 2 of 2 runs"));
    let output =
        place.succeeds(&["monte-carlo", "exact", "--particles", "2", "--settings", "loose.toml", "--runs", "3"]);
    assert!(String::from_utf8(output.stderr).unwrap().contains("worse than dead reckoning in 3 of 3 runs"));

    let output = place.succeeds(&["replay", "exact", "--json", "run.json"]);
    let expected = json("run.json")["position_rmse_m"].as_f64() > json("run.json")["dead_reckoning_rmse_m"].as_f64();
    assert_eq!(json("run.json")["worse_than_dead_reckoning"], expected);
    assert_eq!(String::from_utf8(output.stderr).unwrap().contains("worse"), expected);
}

#[test]
fn unknown_names_list_all_scenarios() {
    let place = workplace();
    let cases: [&[&str]; 7] = [
        &["run", "nosuch"],
        &["export", "nosuch", "dir"],
        &["monte-carlo", "nosuch"],
        &["compare", "nosuch"],
        &["tune", "nosuch"],
        &["settings", "nosuch"],
        &["stream", "nosuch", "file"],
    ];
    for args in cases {
        let error = place.fails(args);
        let names = ["nosuch", "survey", "thesis-dynamic", "thesis-compare", "girona-tank"];
        assert!(names.iter().all(|name| error.contains(name)), "{error}");
    }
    let error = place.fails(&["export", "girona-tank", "dir"]);
    assert!(error.contains("girona-tank") && error.contains("no compass"), "{error}");
}

/// All commands prefer a scenario to a folder with its name, and use the folder for `./NAME`.
#[test]
fn a_scenario_takes_precedence_over_a_folder_with_its_name() {
    let place = workplace();
    for name in ["survey", "girona-tank"] {
        // An empty folder: a command that reads it fails.
        fs::create_dir(place.path(name)).unwrap();
    }
    place.write("few.toml", "[filter]\nmax_components = 5\n");
    let few = ["--particles", "1", "--settings", "few.toml"];
    let commands: [&[&str]; 5] = [
        &["settings", "survey"],
        &["settings", "girona-tank"],
        &["stream", "survey", "file"],
        &["monte-carlo", "survey", "--runs", "1"],
        &["tune", "survey", "--rounds", "1", "--runs", "1", "--until", "3"],
    ];
    for args in commands {
        place.succeeds(&[args, &few].concat());
        let mut folder = args.to_vec();
        let path = format!("./{}", folder[1]);
        folder[1] = &path;
        let error = place.fails(&[&folder, &few[..]].concat());
        assert!(error.contains("log.toml: missing"), "{folder:?}: {error}");
    }
    let error = place.fails(&["compare", "./survey"]);
    assert!(error.contains("log.toml: missing"), "{error}");
    place.succeeds(&[&["compare", "survey", "--precision", "f64"][..], &few].concat());
}

#[test]
fn invalid_numbers_are_reported() {
    let place = workplace();
    let cases: [(&[&str], &[&str]); 9] = [
        (&["run", "survey", "--particles", "-1"], &["'-1'", "--particles", "must be a whole number and not negative"]),
        (&["run", "survey", "--particles", "1.5"], &["'1.5'", "--particles", "must be a whole number"]),
        (&["--particles", "-1"], &["'-1'", "--particles", "must be a whole number and not negative"]),
        (&["run", "survey", "--samples", "-2"], &["'-2'", "--samples", "must be a whole number"]),
        (&["run", "survey", "--seed", "-1"], &["'-1'", "--seed", "must be a whole number from 0 to"]),
        (&["run", "survey", "--repeat", "-1"], &["'-1'", "--repeat", "-1 is not in 1.."]),
        (&["monte-carlo", "survey", "--runs", "-5"], &["'-5'", "--runs", "-5 is not in 1.."]),
        (&["run", "girona-tank", "--threads", "-1"], &["'-1'", "--threads", "-1 is not in 1.."]),
        (&["stream", "survey", "file", "--scans", "-1"], &["'-1'", "--scans", "must be a whole number"]),
    ];
    place.refuses(&cases);
}

#[test]
fn the_program_without_a_command_has_the_settings_of_its_scenario() {
    let place = workplace();
    // The default number of particles, and few components for a short run.
    place.write("quick.toml", "[filter]\nmax_components = 3\n");
    let line = "settings: those that `scphd-sim settings survey --settings quick.toml` prints";
    let quick = ["--settings", "quick.toml", "--json", "run.json"];
    let json = || -> Value { place.json("run.json") };
    let output = place.succeeds(&[&["run", "survey", "--filter", "core"][..], &quick].concat());
    assert_eq!(String::from_utf8(output.stdout).unwrap().lines().last(), Some(line));
    let run = json();
    let output = place.succeeds(&quick);
    assert_eq!(String::from_utf8(output.stdout).unwrap().lines().last(), Some(line));
    let list = json();
    let core = list.as_array().unwrap().iter().find(|of| of["filter"] == "scphd").unwrap();
    assert_eq!(timeless(core.clone()), timeless(run));
}

#[test]
fn threads_are_used_in_space() {
    let place = workplace();
    let run = |threads: &str| -> Value {
        let sizes = ["--particles", "12", "--samples", "2", "--json", "run.json"];
        place.succeeds(&[&["replay", "stereo", "--threads", threads][..], &sizes].concat());
        timeless(place.json("run.json"))
    };
    let alone = run("1");
    assert!(alone["digest"].is_string());
    assert_eq!(run("3"), alone);
    let error = place.fails(&["replay", "stereo", "--threads", "2", "--filter", "reference"]);
    assert!(error.contains("--threads"), "{error}");
    let error = place.fails(&["replay", "stereo", "--repeat", "2", "--seed", "18446744073709551615"]);
    assert!(error.contains("--seed") && error.contains("--repeat 2"), "{error}");
}

#[test]
fn a_joint_map_works_in_space() {
    let place = workplace();
    let run = |precision: &str| {
        let args = ["replay", "stereo", "--filter", "joint", "--precision", precision, "--json", "run.json"];
        place.succeeds(&args);
        place.json("run.json")
    };
    let (single, double) = (run("f32"), run("f64"));
    assert_eq!((&single["filter"], &single["particles"]), (&"joint".into(), &1.into()));
    let error = |run: &Value| run["position_rmse_m"].as_f64().unwrap();
    assert!((error(&single) - error(&double)).abs() < 1e-3, "{} {}", error(&single), error(&double));
    assert!(single["features_estimated"].as_f64().unwrap() > 0.0, "{single}");
}

#[test]
fn studies_of_stereo_logs_work() {
    let place = workplace();
    let with = |json: &str, more: &[&str]| {
        let study = ["monte-carlo", "stereo", "--particles", "3", "--json", json];
        place.succeeds(&[&study[..], more].concat());
        place.json(json)
    };
    let one = with("one.json", &[]);
    assert_eq!((&one["runs"], &one["filter"]), (&1.into(), &"scphd".into()));
    let both = with("both.json", &["stereo", "--runs", "4", "--filter", "core,joint"]);
    assert_eq!((&both[0]["runs"], &both[1]["filter"]), (&4.into(), &"joint".into()));
    // A single run is equal to the first of a study.
    place.succeeds(&["replay", "stereo", "--particles", "3", "--seed", "0", "--json", "run.json"]);
    let run: Value = place.json("run.json");
    let [error, expected] =
        [&one["position_error_final_m"], &run["final_position_error_m"]].map(|value| value.as_f64().unwrap());
    assert!((error - expected).abs() < 1e-12, "{error} {expected}");

    let cases: [(&[&str], &[&str]); 6] = [
        (&["monte-carlo", "stereo", "--filter", "core,core"], &["--filter", "scphd is there twice"]),
        (&["monte-carlo", "girona-tank", "--filter", "core,core"], &["--filter", "scphd is there twice"]),
        (&["monte-carlo", "stereo", "stereo", "--runs", "3"], &["--runs 3", "2 input sets"]),
        (&["monte-carlo", "stereo", "log"], &["in the plane and of a stereo camera"]),
        (&["replay", "stereo", "log"], &["in the plane and of a stereo camera"]),
        (&["monte-carlo", "log", "survey"], &["survey", "one scenario or of several folders"]),
    ];
    place.refuses(&cases);
}

#[test]
fn stereo_logs_are_compared_with_the_reference() {
    let place = workplace();
    let printed = place.prints(&["compare", "stereo", "--precision", "f64", "--particles", "3"]);
    assert_eq!(row(&printed, "scans"), [folders::FRAMES.to_string()]);
    for name in ["ln likelihood (relative)", "component weight (relative)", "component mean (relative)"] {
        assert!(row(&printed, name)[0].parse::<f64>().unwrap() < 1e-9, "{name}: {printed}");
    }
}

/// Commands that supported only the plane at first.
#[test]
fn stereo_logs_are_tuned_and_studied_in_variants() {
    let place = workplace();
    let few = ["--rounds", "1", "--runs", "1", "--truth", "--out", "tuned.toml"];
    let printed = place.succeeds(&[&["tune", "stereo"][..], &few].concat());
    let printed = String::from_utf8(printed.stdout).unwrap();
    for part in ["camera.pixel_sigmas", "camera.detection", "nats a measurement", "held-out RMSE (m)"] {
        assert!(printed.contains(part), "{printed}");
    }
    place.succeeds(&["replay", "stereo", "--settings", "tuned.toml"]);
    assert!(place.fails(&["tune", "stereo", "--filter", "reference"]).contains("in space"));

    let variants = "[[variant]]\nname = 'as it is'\n[[variant]]\nname = 'coarse'\nset.camera = { detection = 0.5 }\n";
    place.write("v.toml", variants);
    place.succeeds(&["monte-carlo", "stereo", "--particles", "3", "--variants", "v.toml", "--json", "v.json"]);
    let list: Value = place.json("v.json");
    assert_eq!((&list[0]["filter"], &list[1]["filter"]), (&"as it is".into(), &"coarse".into()));
    assert_eq!(list[1]["settings"]["camera"]["detection"], 0.5);
}

/// A folder without the module for a GPU, or a build without that feature.
#[test]
fn runs_on_a_device_say_what_they_need() {
    let place = workplace();
    let needs: &[&str] = if cfg!(feature = "gpu") { &["cargo xtask module"] } else { &["--features gpu"] };
    place.refuses(&[
        (&["monte-carlo", "survey", "--device", "ptx"], needs),
        (&["monte-carlo", "worlds", "--device", "ptx"], needs),
        (&["monte-carlo", "girona-tank", "--device", "ptx"], &["in the plane"]),
    ]);
}
