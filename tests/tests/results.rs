//! The output of the program has all keys and columns of `docs/results.md`, in the same order.

use scphd_check as check;
use scphd_filters::settings::Settings;
use scphd_filters::slam::Precision;
use scphd_log::dimensions::{Planar, Underwater};
use scphd_log::log_folder;
use scphd_run::monte_carlo::worlds::{self, WorldRun};
use scphd_run::monte_carlo::{Job, Plan, RunResult, Study, overview};
use scphd_run::session::{self, Filter, Session};
use scphd_score::results::json;
use scphd_shared_data::Folder;
use scphd_view::difference::{Difference, Written};
use scphd_view::output;
use scphd_view::output::{csv, studies};
use scphd_worlds::{scenario, underwater};
use std::fs;
use std::path::Path;

const FILTER: Filter = Filter::Core(Precision::F32);

/// The names below the heading with this beginning: those in a code block, or in the first column of a table.
fn documented(heading: &str) -> Vec<String> {
    let text = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/results.md")).unwrap();
    let section = text.split("\n## ").find(|section| section.starts_with(heading));
    let section = section.unwrap_or_else(|| panic!("no section {heading}"));
    if let Some((list, _)) = section.split_once("```text\n").and_then(|(_, rest)| rest.split_once("\n```")) {
        return list.split([',', '\n']).filter(|name| !name.is_empty()).map(str::to_owned).collect();
    }
    let cell = |row: &str| Some(row.strip_prefix("| `")?.split_once('`')?.0.to_owned());
    section.lines().filter_map(cell).collect()
}

fn columns(path: &Path) -> Vec<String> {
    fs::read_to_string(path).unwrap().lines().next().unwrap().split(',').map(str::to_owned).collect()
}

/// Keys of the objects at this depth of an indented JSON file, in order, without duplicates.
fn keys(path: &Path, depth: usize) -> Vec<String> {
    let text = fs::read_to_string(path).unwrap();
    let mut keys: Vec<String> = Vec::new();
    for line in text.lines() {
        let key = line.strip_prefix(&"  ".repeat(depth)).and_then(|line| line.strip_prefix('"')?.split_once("\": "));
        if let Some((key, _)) = key.filter(|(key, _)| !keys.iter().any(|known| known == key)) {
            keys.push(key.to_owned());
        }
    }
    keys
}

fn short_survey() -> (scphd_log::log::Log, Settings) {
    let mut log = scenario::survey(1);
    log.scans.truncate(9);
    let mut settings = Settings::for_log(&log);
    settings.filter.particles = 2;
    (log, settings)
}

fn survey() -> Session {
    let (log, settings) = short_survey();
    session::run::<Planar>(&log, &settings, FILTER, 1, &mut |_| ()).unwrap()
}

#[test]
fn a_run_in_the_plane() {
    let folder = Folder::new("plane");
    let session = survey();
    json::write_summary(&folder.0.join("run.json"), &session.summary).unwrap();
    assert_eq!(keys(&folder.0.join("run.json"), 1), documented("A run\n"));
    csv::write_record(&folder.0, &session.record).unwrap();
    assert_eq!(columns(&folder.0.join("scans.csv")), documented("`scans.csv` in the plane"));
    assert_eq!(columns(&folder.0.join("map.csv")), documented("`map.csv` in the plane"));
    assert_eq!(columns(&folder.0.join("moving.csv")), documented("`moving.csv`"));
    assert!(session.summary.settings["sensor"]["range_sigma_m"].is_number());
}

#[test]
fn a_run_in_space() {
    let folder = Folder::new("space");
    let mut log = underwater::by_name("girona-tank", 1).unwrap();
    log.scans.truncate(60);
    let mut settings = scphd_filters::underwater::settings::Settings::for_log(&log);
    settings.filter.particles = 8;
    let session = session::run::<Underwater>(&log, &settings, FILTER, 1, &mut |_| ()).unwrap();
    json::write_summary(&folder.0.join("run.json"), &session.summary).unwrap();
    assert_eq!(keys(&folder.0.join("run.json"), 1), documented("A run\n"));
    csv::write_record(&folder.0, &session.record).unwrap();
    assert_eq!(columns(&folder.0.join("scans.csv")), documented("`scans.csv` in space"));
    assert_eq!(columns(&folder.0.join("map.csv")), documented("`map.csv` in space"));

    let summary = &session.summary;
    assert!(summary.settings["camera"]["detection"].is_number());
    // Figures that the filter computes itself, in space too.
    let (nis, nees) = (summary.nis_mean.unwrap(), summary.nees_median.unwrap());
    assert!((0.3..3.0).contains(&nis) && nees > 0.0 && summary.ln_evidence.unwrap() < 0.0, "{summary:?}");
    // Most of the tank has not been in view: only one pair of figures depends on that.
    assert!(summary.ospa_m.unwrap() > 9.0 && summary.ospa_seen_m.unwrap() < summary.ospa_m.unwrap(), "{summary:?}");
    assert!(summary.gospa_seen_m.unwrap() < 0.5 * summary.gospa_m.unwrap(), "{summary:?}");
}

#[test]
fn a_check() {
    let folder = Folder::new("check");
    let log = folder.0.join("log");
    log_folder::write(&scenario::survey(1), &log).unwrap();
    check::write(&folder.0.join("check.json"), &[check::folder(&log)]).unwrap();
    assert_eq!(keys(&folder.0.join("check.json"), 1), documented("A check of a log"));
    assert_eq!(keys(&folder.0.join("check.json"), 2), documented("The facts of a check"));
}

#[test]
fn a_study() {
    let folder = Folder::new("study");
    let (_, settings) = short_survey();
    let plan = Plan {
        scenario: "survey".into(),
        filters: vec!["scphd".into()],
        runs: 1,
        input_sets: 1,
        seed: 1,
        settings: settings.to_toml().unwrap(),
        variants: Vec::new(),
    };
    let job: Job = plan.job(0);
    let study = Study { plan, results: vec![RunResult::of(&job, 1, survey())] };
    overview::write_json(&folder.0.join("study.json"), &study).unwrap();
    assert_eq!(keys(&folder.0.join("study.json"), 1), documented("A study"));
    let summary = survey().summary;
    let run = WorldRun::of(&summary, "settings").unwrap();
    let standing = worlds::standing(std::slice::from_ref(&run), "scphd", "scphd", &[&run.world]).unwrap();
    worlds::write_json(&folder.0.join("worlds.json"), &[standing]).unwrap();
    assert_eq!(keys(&folder.0.join("worlds.json"), 2), documented("A standing in random worlds"));
    studies::write_tables(&folder.0, &study).unwrap();
    assert_eq!(columns(&folder.0.join("runs.csv")), documented("`runs.csv`"));
    assert_eq!(columns(&folder.0.join("series-scphd.csv")), documented("`series-FILTER.csv`"));
}

#[test]
fn a_difference() {
    let folder = Folder::new("difference");
    let path = folder.0.join("run.json");
    json::write_summary(&path, &survey().summary).unwrap();
    let run = Written::read(&path).unwrap();
    output::difference::write(&folder.0.join("difference.json"), &Difference::of([&run, &run])).unwrap();
    assert_eq!(keys(&folder.0.join("difference.json"), 1), documented("A difference of two runs"));
}
