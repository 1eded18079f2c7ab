//! The program as its users see it: exit codes, messages, files.

use crate::folders::{self, stereo};
use crate::place::{Place, names, row, timeless};
use serde_json::Value;
use std::fs;

/// Files in the folder of `--out` after a single run.
const FILES: [&str; 9] = [
    "error.png", "error.svg", "estimate.tum", "map.csv", "moving.csv", "scans.csv", "trajectory.png", "trajectory.svg",
    "truth.tum",
];

/// The first four seconds of the survey in `log`, and an empty folder `results`.
fn workplace() -> Place {
    let place = Place::with_log(41);
    fs::create_dir(place.path("results")).unwrap();
    place
}

/// The JSON object of a replay of the log.
fn replay(place: &Place, more: &[&str]) -> Value {
    place.succeeds(&[&["replay", "log", "--particles", "4", "--json", "results/run.json"], more].concat());
    place.json("results/run.json")
}

#[test]
fn nees_includes_the_covariance_of_the_truth() {
    let place = workplace();
    let exact = replay(&place, &[]);
    let noisy = replay(&place, &["--truth-sigma", "1"]);
    let nees = |run: &Value| run["nees_median"].as_f64().unwrap();
    assert!(nees(&noisy) < 0.1 * nees(&exact), "{} {}", nees(&noisy), nees(&exact));
    assert_eq!((&noisy["digest"], &noisy["position_rmse_m"]), (&exact["digest"], &exact["position_rmse_m"]));
    // The log may state it, too.
    let head = fs::read_to_string(place.path("log/log.toml")).unwrap();
    fs::write(place.path("log/log.toml"), format!("truth_sigma_m = 1\n{head}")).unwrap();
    assert_eq!(replay(&place, &[])["nees_median"], noisy["nees_median"]);
    assert_eq!(replay(&place, &["--truth-sigma", "0"])["nees_median"], exact["nees_median"]);
    fs::remove_file(place.path("results/run.json")).unwrap();
    let error = place.fails(&["replay", "log", "--truth-sigma", "-1"]);
    assert!(error.contains("--truth-sigma"), "{error}");
    fs::write(place.path("log/log.toml"), format!("truth_sigma_m = -1\n{head}")).unwrap();
    let error = place.fails(&["replay", "log"]);
    assert!(error.contains("truth_sigma_m: -1, expected 0 or more"), "{error}");
}

#[test]
fn bad_settings_are_refused_by_file_field_and_range() {
    let place = workplace();
    let cases: [(&str, &[&str]); 8] = [
        ("[filter]\nparticles = 0", &["filter.particles", "1 to 65536"]),
        ("[filter]\nparticles = 5000", &["5000 particles", "1024"]),
        ("[sensor]\nrange_sigma_m = -0.5", &["bad.toml", "sensor.range_sigma_m", "1e-6 to 1000 m"]),
        ("[sensor]\ndetection_far = nan", &["bad.toml", "sensor.detection_far", "0 to 0.9999"]),
        ("[vehicle]\nturn_sigma = 'wide'", &["bad.toml", "vehicle.turn_sigma", "wide"]),
        ("[filter]\nparticels = 5", &["bad.toml", "particels"]),
        ("[filtre]\nparticles = 5", &["bad.toml", "filtre"]),
        ("[filter]\n\nparticles 5", &["bad.toml", "row 3"]),
    ];
    for (settings, parts) in cases {
        fs::write(place.path("bad.toml"), settings).unwrap();
        let outputs = ["--json", "results/run.json", "--out", "results/out"];
        let error =
            place.fails(&[&["replay", "log", "--filter", "core", "--settings", "bad.toml"][..], &outputs].concat());
        assert!(parts.iter().all(|part| error.contains(part)), "{settings}: {error}");
        place.fails(&[&["run", "survey", "--settings", "bad.toml"][..], &outputs].concat());
        place.fails(&[&["--settings", "bad.toml"][..], &outputs].concat());
    }
}

#[test]
fn bad_arguments_are_refused() {
    let place = workplace();
    fs::write(place.path("file"), "").unwrap();
    let cases: [(&[&str], &[&str]); 28] = [
        (&["replay", "nowhere"], &["nowhere", "missing"]),
        (&["replay"], &["<DIR>"]),
        (&["replay", "log", "--particles", "0"], &["--particles 0", "1 to 65536"]),
        (&["replay", "log", "--particles", "5000"], &["5000 particles", "1024"]),
        (&["replay", "log", "--particles", "1000", "--samples", "3"], &["3000 candidates", "2048"]),
        (&["replay", "log", "--samples", "2000"], &["--samples 2000", "1 to 1024"]),
        (&["replay", "log", "--particles", "-3"], &["-3"]),
        (&["replay", "log", "--seed", "one"], &["--seed", "one"]),
        (&["replay", "log", "--filter", "kalman"], &["kalman"]),
        (&["replay", "log", "--filter", "reference", "--precision", "f32"], &["f32", "f64 only"]),
        (&["replay", "log", "--settings", "nowhere.toml"], &["nowhere.toml", "cannot be read"]),
        (&["replay", "log", "--json", "nowhere/run.json"], &["--json", "nowhere"]),
        (&["replay", "log", "--json", "results"], &["--json", "is a folder"]),
        (&["replay", "log", "--out", "file/out"], &["--out", "file is not a folder"]),
        (&["run", "atlantis"], &["atlantis", "survey"]),
        (&["export", "survey", "log"], &["log is not empty"]),
        (&["replay", "log", "--repeat", "0"], &["--repeat", "0"]),
        (&["replay", "log", "--jobs", "0"], &["--jobs", "0"]),
        (&["replay", "log", "--threads", "0"], &["--threads", "0"]),
        (&["replay", "log", "--threads", "2", "--filter", "reference"], &["--threads"]),
        (&["replay", "log", "--repeat", "2", "--out", "results/out"], &["--out", "single run"]),
        (&["replay", "log", "log", "--out", "results/out"], &["--out", "single run"]),
        (&["replay", "log", "nowhere"], &["nowhere", "missing"]),
        (&["replay", "log", "--repeat", "2", "--seed", "18446744073709551615"], &["--seed", "--repeat 2"]),
        (&["compare", "atlantis"], &["atlantis", "survey"]),
        (&["compare", "log", "--precision", "f16"], &["--precision", "f16"]),
        (&["compare", "log", "--particles", "5000"], &["5000 particles", "1024"]),
        (&["--particels", "3"], &["--particels", "--particles"]),
    ];
    place.refuses(&cases);
}

#[test]
fn a_replay_writes_its_figures_tables_and_plots() {
    let place = workplace();
    let args = ["replay", "log", "--particles", "4", "--json", "results/run.json", "--out", "results/a/b"];
    let printed = place.prints(&args);
    for part in ["survey", "scphd", "f32", "position RMSE (m)", "health, scphd f32: "] {
        assert!(printed.contains(part), "{printed}");
    }
    assert_eq!(names(&place.path("results")), ["a", "run.json"]);
    assert_eq!(names(&place.path("results/a/b")), FILES);

    let text = fs::read_to_string(place.path("results/run.json")).unwrap();
    // Keys of the object itself are indented by two spaces.
    let keys: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("  \"")?.split('"').next()).collect();
    assert_eq!((keys.len(), keys[0]), (43, "format"));
    let summary: Value = serde_json::from_str(&text).unwrap();
    assert_eq!((&summary["particles"], &summary["settings"]["filter"]["particles"]), (&4.into(), &4.into()));
    assert_eq!((&summary["seed"], &summary["scans"]), (&1.into(), &41.into()));
    for key in ["position_rmse_m", "heading_rmse_deg", "ospa_m", "gospa_m", "features_estimated", "state_bytes"] {
        assert!(summary[key].as_f64().is_some_and(f64::is_finite), "{key}: {text}");
    }
}

#[test]
fn all_results_except_times_depend_only_on_the_seed() {
    let place = workplace();
    for precision in ["f32", "f64"] {
        let first = replay(&place, &["--precision", precision, "--seed", "7"]);
        let second = replay(&place, &["--precision", precision, "--seed", "7"]);
        let other = replay(&place, &["--precision", precision, "--seed", "8"]);
        assert!(first["digest"].is_string());
        assert_eq!(timeless(first.clone()), timeless(second));
        assert_ne!(first["digest"], other["digest"]);
        assert_eq!(first["precision"], precision);
    }
    let first = replay(&place, &["--filter", "reference", "--seed", "7"]);
    assert_eq!(timeless(first.clone()), timeless(replay(&place, &["--filter", "reference", "--seed", "7"])));
    assert!(first["digest"].is_null() && first["state_bytes"].is_null());
    assert_eq!(first["filter"], "reference");
}

#[test]
fn only_times_depend_on_the_threads() {
    let place = workplace();
    let alone = replay(&place, &["--seed", "7"]);
    assert_eq!(timeless(alone), timeless(replay(&place, &["--seed", "7", "--threads", "3"])));
}

#[test]
fn an_exported_scenario_replays_as_it_runs() {
    let place = workplace();
    // By default a scenario has the recursion of the thesis, a log also extensions.
    let few = "[filter]\nparticles = 2\nproposal = \"informed\"\nunconfirmed_weight = 0.5\nextraction = \"peaks\"\n\
        [sensor]\nclutter_per_scan = 25\n";
    fs::write(place.path("few.toml"), few).unwrap();
    let tuned = ["--settings", "few.toml", "--seed", "5", "--json", "run.json"];
    let summary = || -> Value { place.json("run.json") };
    place.prints(&[&["run", "survey", "--scenario-seed", "9"][..], &tuned].concat());
    let run = summary();
    place.prints(&["export", "survey", "exported", "--seed", "9"]);
    place.prints(&[&["replay", "exported", "--filter", "core"][..], &tuned].concat());
    assert_eq!(timeless(summary()), timeless(run.clone()));
    assert_eq!((&run["seed"], &run["particles"]), (&5.into(), &2.into()));
    // Without a scenario seed, the seed is that of the filter.
    place.prints(&[&["run", "survey"][..], &tuned].concat());
    assert_ne!(summary()["dead_reckoning_rmse_m"], run["dead_reckoning_rmse_m"]);
}

#[test]
fn a_log_gets_a_joint_map_where_nothing_asks_for_what_it_has_not() {
    let place = workplace();
    let filter = |args: &[&str]| {
        place.prints(&[&["replay", "log", "--json", "run.json"][..], args].concat());
        let run: Value = place.json("run.json");
        (run["filter"].as_str().unwrap().to_owned(), run["particles"].as_u64().unwrap())
    };
    assert_eq!(filter(&[]), ("joint".into(), 1));
    for mixture in [&["--particles", "2"][..], &["--filter", "core"], &["--threads", "2"]] {
        assert_eq!(filter(mixture).0, "scphd", "{mixture:?}");
    }
    fs::write(place.path("moving.toml"), "[moving]\nbirth_intensity = 0.01").unwrap();
    assert_eq!(filter(&["--settings", "moving.toml"]), ("joint".into(), 1));
    let learning =
        "[calibration]\nspeed_scale_sigma = 0.05\nturn_scale_sigma = 0.05\nturn_offset_sigma = 0.02\nlasts_s = 1e9";
    fs::write(place.path("learning.toml"), learning).unwrap();
    assert_eq!(filter(&["--settings", "learning.toml"]), ("joint".into(), 1));
    let error = place.fails(&["replay", "log", "--filter", "core", "--settings", "learning.toml"]);
    assert!(error.contains("learning.toml: calibration.") && error.contains("by joint"), "{error}");
}

/// Every option, and a setting of every section, is used by a filter or refused with its name, for every filter. None is ignored.
#[test]
fn unused_options_and_settings_are_refused_with_their_name() {
    let place = workplace();
    let files = [
        ("filter.prune_weight", "[filter]\nprune_weight = 0.004", "core reference"),
        ("filter.proposal_rounds", "[filter]\nproposal_rounds = 2", "core"),
        ("filter.birth_intensity", "[filter]\nbirth_intensity = 0.02", "core joint reference"),
        ("vehicle.turn_sigma", "[vehicle]\nturn_sigma = 0.3", "core joint reference"),
        ("sensor.range_sigma_m", "[sensor]\nrange_sigma_m = 0.7", "core joint reference"),
        ("moving.birth_intensity", "[moving]\nbirth_intensity = 0.01", "core joint reference"),
        ("joint.occlusion_factor", "[joint]\nocclusion_factor = 0.5", "joint"),
        ("filter.likelihood", "[filter]\nlikelihood = \"rb-multi\"", "reference"),
    ];
    let options: [(&[&str], &str); 6] = [
        (&["--particles", "3"], "core reference rb-empty"),
        (&["--samples", "2"], "core reference rb-empty"),
        (&["--threads", "2"], "core"),
        (&["--moving", "on"], "core joint reference rb-empty"),
        (&["--moving", "off"], "core joint reference rb-empty ekf"),
        (&["--save-map", "kept.map"], "joint"),
    ];
    for filter in ["core", "joint", "reference", "rb-empty", "ekf"] {
        let check = |args: &[&str], what: &str, users: &str| {
            let args = [&["replay", "log", "--filter", filter], args].concat();
            if users.split(' ').any(|user| user == filter) {
                place.prints(&args);
            } else {
                let error = place.fails(&args);
                assert!(error.contains(what) && error.contains("not used by --filter"), "{filter} {what}: {error}");
            }
        };
        for (args, users) in options {
            check(args, args[0], users);
        }
        for (field, text, users) in files {
            fs::write(place.path("one.toml"), text).unwrap();
            let users = if field == "filter.likelihood" {
                users.to_owned()
            } else {
                users.replace("reference", "reference rb-empty")
            };
            check(&["--settings", "one.toml"], field, &users);
        }
    }
    // A file with unchanged settings is accepted.
    let all = place.prints(&["settings", "log"]);
    assert!(all.contains("for --filter core, reference alone"), "{all}");
    fs::write(place.path("all.toml"), all).unwrap();
    for filter in ["core", "joint", "ekf"] {
        place.prints(&["replay", "log", "--filter", filter, "--settings", "all.toml"]);
    }
    // It suffices if one of several filters uses the setting.
    fs::write(place.path("one.toml"), files[3].1).unwrap();
    place.prints(&[
        "monte-carlo", "log", "--filter", "joint,ekf", "--settings", "one.toml", "--runs", "1", "--moving", "off",
    ]);
}

#[test]
fn settings_proposed_by_tune_can_be_replayed() {
    let place = workplace();
    place.prints(&["export", "survey", "exported"]);
    let few = ["--rounds", "1", "--runs", "1", "--until", "6", "--particles", "2", "--truth"];
    let printed = place.prints(&[&["tune", "exported", "--out", "tuned.toml"][..], &few].concat());
    for part in ["sensor.range_sigma_m", "proposed", "nats a measurement", "held-out RMSE (m)"] {
        assert!(printed.contains(part), "{printed}");
    }
    let tuned = fs::read_to_string(place.path("tuned.toml")).unwrap();
    let particles = tuned.lines().find(|line| line.starts_with("particles = 2 ")).unwrap();
    assert!(particles.ends_with("# command line, --particles"), "{tuned}");
    // Every filter keeps its own defaults.
    assert!(!tuned.contains("default") && !tuned.contains("hypotheses"), "{tuned}");
    let printed = place.prints(&[&["tune", "survey", "--count", "2"][..], &few].concat());
    assert!(printed.contains("2 logs, proposals in ") && printed.lines().count() == 3, "{printed}");
    assert!(place.fails(&["tune", "exported", "--count", "2"]).contains("--count"));
    assert!(place.fails(&["tune", "exported", "--until", "0"]).contains("--until"));
    assert!(place.fails(&["tune", "exported", "--filter", "ekf"]).contains("--filter"));
    place.prints(&["replay", "exported", "--filter", "core", "--settings", "tuned.toml"]);
    place.fails(&["tune", "nowhere"]);
    place.fails(&["tune", "exported", "--rounds", "0"]);
}

#[test]
fn the_program_without_a_command_shows_the_recommended_filter_first() {
    let place = workplace();
    let printed = place.prints(&["--particles", "2", "--json", "results/all.json"]);
    assert!(printed.contains("reference"), "{printed}");
    let folders = ["joint-f32", "reference-f64", "scphd-f32"];
    let plots = ["error.png", "error.svg", "report.html", "trajectory.png", "trajectory.svg"];
    let mut all = [&folders[..], &plots].concat();
    all.sort_unstable();
    assert_eq!(names(&place.path("out")), all);
    for folder in folders {
        let folder = place.path("out").join(folder);
        assert_eq!(names(&folder), ["estimate.tum", "map.csv", "moving.csv", "scans.csv", "truth.tum"]);
    }
    let list: Value = place.json("results/all.json");
    let list = list.as_array().unwrap();
    let filters: Vec<&Value> = list.iter().map(|run| &run["filter"]).collect();
    assert_eq!(filters, ["joint", "scphd", "reference"]);
    assert!(list.iter().all(|run| run["dead_reckoning_rmse_m"] == list[0]["dead_reckoning_rmse_m"]));
    // With a right covariance, 95 % of the errors are within its bounds.
    let within = list[0]["nees_within_95"].as_f64().unwrap();
    assert!(within >= 0.9, "{within}");
}

#[test]
fn filter_and_reference_agree_in_lockstep() {
    let place = workplace();
    let sizes = ["compare", "log", "--particles", "4", "--samples", "3", "--seed", "5"];
    let printed = place.prints(&sizes);
    let row = |name: &str| row(&printed, name);
    assert_eq!((row("log"), row("precision")), (vec!["survey"; 2], vec!["f32", "f64"]));
    assert_eq!((row("particles × samples").concat(), row("seed")), ("4×34×3".into(), vec!["5"; 2]));
    assert_eq!((row("scans"), row("scans short of room").len()), (vec!["41"; 2], 2));
    assert!(row("static components compared")[1].parse::<u32>().unwrap() > 0);
    for name in [
        "ln likelihood (relative)", "particle weight (relative)", "component weight (relative)",
        "component mean (relative)",
    ] {
        assert!(row(name)[1].parse::<f64>().unwrap() < 1e-9, "{name}: {printed}");
    }
    for name in ["component covariance (relative)", "map mass (relative)"] {
        assert!(row(name)[1].parse::<f64>().unwrap() < 1e-9, "{name}: {printed}");
    }
    let printed = place.prints(&["compare", "log", "--precision", "f64", "--particles", "2"]);
    assert!(printed.contains("f64") && !printed.contains("f32"), "{printed}");
}

#[test]
fn repeated_runs_are_single_runs_with_consecutive_seeds() {
    let place = workplace();
    let list = |args: &[&str]| -> Vec<Value> {
        place.prints(&[args, &["--particles", "4", "--json", "results/list.json"]].concat());
        let list: Value = place.json("results/list.json");
        list.as_array().unwrap().iter().cloned().map(timeless).collect()
    };
    let three = list(&["replay", "log", "--seed", "7", "--repeat", "3"]);
    let singly = ["7", "8", "9"].map(|seed| timeless(replay(&place, &["--seed", seed])));
    assert_eq!(three, singly);
    assert_eq!(list(&["replay", "log", "--seed", "7", "--repeat", "3", "--jobs", "2"]), three);

    let logs = list(&["replay", "log", "log", "--seed", "7", "--repeat", "2", "--jobs", "3"]);
    assert_eq!(logs, [&three[..2], &three[..2]].concat());
    let printed = place.prints(&["replay", "log", "log", "--particles", "4"]);
    assert_eq!(printed.lines().filter(|line| line.trim_start().starts_with("survey")).count(), 2, "{printed}");
    assert!(printed.contains("mean over logs"), "{printed}");
}

#[test]
fn a_repeated_scenario_has_noise_with_the_seed_of_the_run() {
    let place = workplace();
    let dead_reckoning = |more: &[&str]| -> Vec<Value> {
        let args = ["run", "survey", "--particles", "2", "--repeat", "2", "--json", "results/list.json"];
        place.prints(&[&args[..], more].concat());
        let list: Value = place.json("results/list.json");
        list.as_array().unwrap().iter().map(|run| run["dead_reckoning_rmse_m"].clone()).collect()
    };
    let own = dead_reckoning(&[]);
    assert_ne!(own[0], own[1]);
    let shared = dead_reckoning(&["--scenario-seed", "1"]);
    assert_eq!(shared, [own[0].clone(), own[0].clone()]);
}

/// The figures of a study without the times.
fn figures(place: &Place, file: &str) -> Value {
    timeless(place.json(file))
}

#[test]
fn a_study_is_the_same_on_any_number_of_threads() {
    let place = workplace();
    let study = ["monte-carlo", "log", "--runs", "5", "--particles", "4"];
    let with = |more: &[&str]| place.prints(&[&study[..], more].concat());
    let printed = with(&["--jobs", "1", "--json", "results/one.json", "--out", "results/study"]);
    for part in ["survey", "scphd", "4 × 1", "position error, mean (m)", "OSPA (c 10 m), last third (m)"] {
        assert!(printed.contains(part), "{printed}");
    }
    assert_eq!(names(&place.path("results/study")), ["runs.csv", "series-scphd.csv", "study.png", "study.svg"]);
    with(&["--jobs", "3", "--json", "results/three.json"]);
    let whole = figures(&place, "results/one.json");
    assert_eq!(figures(&place, "results/three.json"), whole);

    assert_eq!((&whole["runs"], &whole["samples"]), (&5.into(), &1.into()));
    assert!(whole["ospa_last_third_m"].is_number() && whole["moving_hit_rate"].is_null());
    // Run 0 has the seed of the study.
    place.prints(&["monte-carlo", "log", "--particles", "4", "--seed", "7", "--json", "results/first.json"]);
    let run = replay(&place, &["--seed", "7"]);
    let error = figures(&place, "results/first.json")["position_error_final_m"].as_f64().unwrap();
    assert!((error - run["final_position_error_m"].as_f64().unwrap()).abs() < 1e-12);
}

#[test]
fn a_study_under_water_has_each_filter() {
    let place = workplace();
    folders::put(&place.path("stereo"), &stereo());
    let study = ["--runs", "2", "--particles", "1", "--filter", "core,joint", "--json", "results/study.json"];
    place.prints(&[&["monte-carlo", "stereo"], &study[..]].concat());
    let filters: Value = place.json("results/study.json");
    assert_eq!((&filters[1]["filter"], &filters[1]["runs"]), (&"joint".into(), &2.into()));
}

#[test]
fn filters_are_compared_on_the_same_inputs() {
    let place = workplace();
    let printed = place.prints(&[
        "monte-carlo", "log", "log", "--runs", "4", "--particles", "3", "--filter", "core,rb-single", "--json",
        "results/both.json",
    ]);
    assert!(printed.contains("better than rb-single in") && printed.contains("of 4 runs"), "{printed}");
    let list: Value = place.json("results/both.json");
    assert_eq!((&list[0]["filter"], &list[1]["filter"]), (&"scphd".into(), &"rb-single".into()));
    assert_eq!(list[0]["dead_reckoning_error_mean_m"], list[1]["dead_reckoning_error_mean_m"]);
    let summary = replay(&place, &["--filter", "rb-empty"]);
    assert_eq!(summary["filter"], "rb-empty");
}

#[test]
fn variants_of_the_settings_are_compared() {
    let place = workplace();
    let variants = "[[variant]]\nname = 'as they are'\n\
        [[variant]]\nname = 'noise x 2'\ntimes.sensor = { range_sigma_m = 2 }\n\
        [[variant]]\nname = 'few'\nfilter = 'rb-multi'\nset.filter = { particles = 2 }\n";
    fs::write(place.path("variants.toml"), variants).unwrap();
    let study = |filters: &str| {
        let args = ["--runs", "2", "--particles", "3", "--variants", "variants.toml", "--json", "results/list.json"];
        let printed = place.prints(&[&["monte-carlo", "log", "--filter", filters], &args[..]].concat());
        let list: Value = place.json("results/list.json");
        let names: Vec<String> =
            list.as_array().unwrap().iter().map(|one| one["filter"].as_str().unwrap().to_owned()).collect();
        (printed, list, names)
    };
    let (printed, list, names) = study("core");
    assert_eq!(names, ["as they are", "noise x 2", "few"]);
    assert!(printed.contains("as they are better than noise x 2 in"), "{printed}");
    let range = |place: usize| list[place]["settings"]["sensor"]["range_sigma_m"].as_f64().unwrap();
    assert_eq!((range(1), range(2)), (2.0 * range(0), range(0)));
    assert_eq!((&list[1]["particles"], &list[2]["particles"]), (&3.into(), &2.into()));
    assert_eq!(list[2]["settings"]["filter"]["likelihood"], "rb-multi");
    assert_ne!(list[0]["position_error_mean_m"], list[1]["position_error_mean_m"]);
    let (_, _, names) = study("core,rb-empty");
    assert_eq!(
        names,
        ["scphd: as they are", "scphd: noise x 2", "rb-empty: as they are", "rb-empty: noise x 2", "few"]
    );
}

#[test]
fn bad_studies_are_refused() {
    let place = workplace();
    fs::write(place.path("hopeless.toml"), "[[variant]]\nname = 'none'\nset.filter = { particles = 0 }\n").unwrap();
    fs::write(place.path("unknown.toml"), "[[variant]]\nname = 'one'\nfilter = 'kalman'\n").unwrap();
    let cases: [(&[&str], &[&str]); 9] = [
        (&["monte-carlo", "survey", "--variants", "no.toml"], &["no.toml", "cannot be read"]),
        (&["monte-carlo", "worlds", "--variants", "hopeless.toml"], &["hopeless.toml: none", "filter.particles"]),
        (&["monte-carlo", "survey", "--variants", "unknown.toml"], &["one", "no filter 'kalman'", "rb-multi"]),
        (&["monte-carlo", "girona-tank", "--variants", "hopeless.toml"], &["hopeless.toml: none", "filter.particles"]),
        (&["monte-carlo", "atlantis"], &["atlantis", "survey"]),
        (&["monte-carlo", "survey", "--runs", "5", "--input-sets", "2"], &["--runs 5", "2 input sets"]),
        (&["monte-carlo", "log", "log", "--runs", "3"], &["--runs 3", "2 input sets"]),
        (&["monte-carlo", "log", "--input-sets", "2"], &["--input-sets 2", "the logs make 1"]),
        (&["monte-carlo", "survey", "--filter", "core,core"], &["--filter", "scphd is there twice"]),
    ];
    place.refuses(&cases);
}

#[test]
fn figures_are_listed_and_drawn() {
    let place = workplace();
    let list = place.prints(&["figure"]);
    for number in ["5.4", "5.5", "5.8"] {
        assert!(list.lines().any(|line| line.starts_with(number)), "{list}");
    }
    place.prints(&["figure", "5.4", "--particles", "2", "--out", "results/f"]);
    place.prints(&["figure", "5.5", "--runs", "2", "--particles", "2", "--out", "results/f"]);
    assert_eq!(
        names(&place.path("results/f")),
        ["5.4a.png", "5.4a.svg", "5.4b.png", "5.4b.svg", "5.5.png", "5.5.svg"].map(|name| format!("figure-{name}"))
    );
    let place = workplace();
    assert!(place.fails(&["figure", "9.9"]).contains("no figure 9.9"));
}

#[test]
fn printed_settings_are_a_settings_file() {
    let place = workplace();
    let printed = place.prints(&["settings", "log", "--particles", "9"]);
    assert!(printed.contains("particles = 9"), "{printed}");
    fs::write(place.path("all.toml"), &printed).unwrap();
    // The values are the same; their origins have changed.
    let again = place.prints(&["settings", "survey", "--settings", "all.toml"]);
    let values =
        |text: &str| text.lines().map(|line| line.split("  #").next().unwrap().trim().to_owned()).collect::<Vec<_>>();
    assert_eq!(values(&again), values(&printed));
    assert!(printed.contains("# command line, --particles") && again.contains("# file all.toml"), "{printed}{again}");
}

/// All kinds of origins, in the plane and in space.
#[test]
fn printed_settings_have_their_origins() {
    let place = workplace();
    let origin = |args: &[&str], key: &str| {
        let text = place.prints(&[&["settings"], args].concat());
        let line = text.lines().find(|line| line.starts_with(&format!("{key} = "))).unwrap();
        line.split_once("  # ").unwrap().1.to_owned()
    };
    assert_eq!(origin(&["survey"], "range_sigma_m"), "stated");
    assert_eq!(origin(&["survey"], "merge_distance"), "default");
    assert_eq!(origin(&["survey"], "proposal"), "experiment of the thesis");
    assert_eq!(origin(&["worlds"], "clutter_per_scan"), "default");
    assert!(origin(&["worlds"], "range_sigma_m").ends_with(", × 1.1 by default"));
    assert_eq!(origin(&["survey", "--moving", "on", "--samples", "2"], "samples"), "command line, --samples");
    fs::write(place.path("noise.toml"), "[vehicle]\nturn_sigma = 0.02\n").unwrap();
    assert_eq!(origin(&["worlds", "--settings", "noise.toml"], "turn_sigma"), "file noise.toml");
    fs::write(
        place.path("own.toml"),
        "learnt = [\"sensor.range_sigma_m\"]\n[sensor]\nrange_sigma_m = 0.3\nrange_edge_m = 1\n",
    )
    .unwrap();
    let own = ["survey", "--settings", "own.toml"];
    assert_eq!(origin(&own, "range_sigma_m"), "learnt");
    assert_eq!(origin(&own, "range_edge_m"), "file own.toml");
    assert_eq!(origin(&own, "clutter_per_scan"), "stated");
    assert_eq!(origin(&["girona-tank"], "detection"), "stated");
    assert_eq!(origin(&["girona-tank", "--particles", "3"], "particles"), "command line, --particles");
    fs::write(place.path("tank.toml"), "[camera]\ndetection = 0.5\n").unwrap();
    assert_eq!(origin(&["girona-tank", "--settings", "tank.toml"], "detection"), "file tank.toml");
}

#[test]
fn help_version_and_lists() {
    let place = workplace();
    let version = format!("scphd-sim {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(place.prints(&["--version"]), version);
    // Line breaks depend on the terminal.
    let help = place.prints(&["--help"]).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(help.contains("OSPA (order 1, cut-off 10 m)"), "{help}");
    for command in ["replay", "run", "monte-carlo", "figure", "compare", "export", "settings", "tune"] {
        assert!(place.prints(&[command, "--help"]).contains("Usage: scphd-sim"), "{command}");
    }
    let list = place.prints(&["scenarios"]);
    assert!(list.starts_with("survey "), "{list}");
}

#[test]
fn a_closed_output_is_not_a_failure() {
    let place = workplace();
    for args in [&["settings", "log"][..], &["scenarios"], &["--help"], &["replay", "log", "--particles", "2"]] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = place.command(args);
        let child = command.stdout(writer).stderr(std::process::Stdio::piped());
        let output = child.spawn().unwrap().wait_with_output().unwrap();
        assert!(output.status.success() && output.stderr.is_empty(), "{args:?}: {output:?}");
    }
}

#[test]
fn a_published_log_replays() {
    let Some(log) = scphd_shared_data::find("car_park") else { return };
    let place = workplace();
    let args = ["replay", log.to_str().unwrap(), "--filter", "reference", "--particles", "4", "--json", "run.json"];
    place.prints(&args);
    let summary: Value = place.json("run.json");
    assert_eq!((&summary["log"], &summary["scans"]), (&"Car park".into(), &506.into()));
    assert!(summary["heading_rmse_deg"].is_null() && summary["gospa_m"].is_number());
    assert!((summary["dead_reckoning_rmse_m"].as_f64().unwrap() - 2.51).abs() < 0.01);
}

#[test]
fn a_quiet_run_writes_its_files_and_prints_nothing() {
    let place = workplace();
    assert!(place.fails(&["replay", "missing", "-q"]).contains("missing"));
    let args = ["replay", "log", "--particles", "2", "--json", "results/run.json", "--out", "results/out", "--quiet"];
    let output = place.run(&args);
    assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty(), "{output:?}");
    assert_eq!(names(&place.path("results")), ["out", "run.json"]);
    assert!(!place.prints(&["scenarios", "-q"]).is_empty());
    assert!(!place.prints(&["check", "log", "-q"]).is_empty());
}

#[test]
fn output_has_no_colours() {
    let place = workplace();
    for args in [&["--help"][..], &["replay", "log", "--particles", "2"], &["check", "log"], &["replay", "missing"]] {
        let output = place.run(args);
        assert!(![output.stdout, output.stderr].concat().contains(&0x1b), "{args:?}");
    }
}
