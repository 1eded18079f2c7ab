//! Damaged log folders: the reader reports the error, or the run has finite numbers; there is never a panic.
//!
//! Good folders of either kind are damaged by a seeded generator, as by transfers, editors, scripts and people. Folders that can
//! still be read are run over their first scans.

use scphd_filters::settings::Settings;
use scphd_filters::slam::Precision;
use scphd_log::dimensions::{Dimensions, Planar, Underwater};
use scphd_log::log::{Fix, Log, PoseFix, Vehicle};
use scphd_log::log_folder;
use scphd_run::session::{self, Filter, Session, SessionError};
use scphd_score::record::{MapFeature, Record, ScanRecord};
use scphd_worlds::scenario;
use std::fs;
use std::panic::catch_unwind;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

mod folders;
use folders::Files;

/// Number of damaged folders in a run of this test; SCPHD_DAMAGED_FOLDERS sets it.
const FOLDERS: u64 = 2000;
/// Number of those that are given to the program, too.
const THROUGH_THE_PROGRAM: u64 = 48;
const SCANS: usize = 4;

/// SplitMix64 (Steele, Lea and Flood 2014): a sequence of numbers for a seed.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `sides`; 0 if `sides` is 0.
    fn roll(&mut self, sides: usize) -> usize {
        (self.next() % (sides.max(1) as u64)) as usize
    }

    fn one<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.roll(of.len())]
    }
}

fn read_folder(dir: &Path) -> Files {
    let names = [
        "log.toml", "odometry.csv", "scans.csv", "detections.csv", "fixes.csv", "truth.csv", "landmarks.csv",
        "moving.csv",
    ];
    names.into_iter().filter_map(|name| Some((name, fs::read(dir.join(name)).ok()?))).collect()
}

/// The good folders, each with a few scans and all kinds of files.
fn good() -> Vec<Files> {
    let written = |log: &Log| {
        let dir = TempDir::new().unwrap();
        let folder = dir.path().join("log");
        log_folder::write(log, &folder).unwrap();
        read_folder(&folder)
    };
    let mut car = scenario::thesis_dynamic(1);
    car.scans.truncate(12);
    car.odometry.truncate(24);
    car.truth.truncate(12);
    let last_s = car.scans[11].t_s;
    car.moving.retain(|row| row.t_s <= last_s);
    let mut robot = car.clone();
    robot.vehicle = Vehicle::UnicycleArc;
    (robot.simulated, robot.nominal.steering_sigma_rad) = (false, None);
    for detection in robot.scans.iter_mut().flat_map(|scan| &mut scan.detections) {
        detection[0] = detection[0].abs();
    }
    robot.nominal.rate_sigma_radps = Some(0.05);
    let mut two = scenario::two_sensors(1);
    two.scans.truncate(12);
    two.odometry.truncate(24);
    two.truth.truncate(12);
    two.fixes = vec![
        Fix { t_s: 0.1, measured: PoseFix::Position([0.5, -0.5]) },
        Fix { t_s: 0.15, measured: PoseFix::Heading(0.1) },
    ];
    two.fix_noise.position_sigma_m = Some(1.0);
    two.fix_noise.heading_sigma_rad = Some(0.1);
    let stereo = folders::stereo();
    assert_eq!((stereo.len(), folders::LANDMARKS), (6, 12));
    vec![written(&car), written(&robot), written(&two), stereo.clone(), stereo]
}

const FIELDS: [&str; 32] = [
    "", " ", "-", "nan", "NaN", "inf", "-inf", "infinity", "1e308", "-1e308", "1e18", "-1e18", "1e9", "1e-320", "-0",
    "0", "-1", "3.5", "180", "9223372036854775807", "9223372036854775808", "-9223372036854775808",
    "18446744073709551616", "0x10", "1,5", "\"1\n2\"", "\"", "1e400", "١٢", "true", "\u{0}", "1_000",
];

/// Unusual lines of a head.
const LINES: [&str; 22] = [
    "[vehicle]",
    "[sensor]",
    "[camera]",
    "[camera.deep.er]",
    "[[sensor]]",
    "[[sensors]]",
    "[fixes]",
    "name = 1",
    "name = \"\\u0000\"",
    "kind = \"Simulated\"",
    "simulated = 1",
    "initial_pose = [1, 2]",
    "initial_pose = [1e300, -1e300, 1e300]",
    "range_max_m = 1e300",
    "range_sigma_m = 1e-300",
    "wheelbase_m = 1e-300",
    "detection_probability = nan",
    "clutter_per_scan = 1e308",
    "= 3",
    "\"\" = {}",
    "x = 1979-05-27T07:32:00Z",
    "fu = inf",
];

fn is_table(name: &str) -> bool {
    name.ends_with(".csv")
}

/// The lines of a table, each with its cells.
fn cells(bytes: &[u8]) -> Vec<Vec<String>> {
    let text = String::from_utf8_lossy(bytes);
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn joined(table: &[Vec<String>]) -> Vec<u8> {
    table.iter().flat_map(|row| (row.join(",") + "\n").into_bytes()).collect()
}

/// Damages one file of the folder in one way.
fn damage(files: &mut Files, dice: &mut Dice) -> String {
    if dice.roll(20) == 0 {
        let (name, _) = files.remove(dice.roll(files.len()));
        return format!("{name} is missing");
    }
    let place = dice.roll(files.len());
    let Some((name, bytes)) = files.get_mut(place) else { return "no files".into() };
    let what = if dice.roll(3) == 0 {
        damage_bytes(bytes, dice)
    } else if is_table(name) {
        let mut table = cells(bytes);
        let what = damage_table(&mut table, dice);
        *bytes = joined(&table);
        what
    } else {
        damage_head(bytes, dice)
    };
    format!("{name}: {what}")
}

fn damage_bytes(bytes: &mut Vec<u8>, dice: &mut Dice) -> String {
    if bytes.is_empty() {
        return "no bytes left".into();
    }
    let at = dice.roll(bytes.len());
    match dice.roll(9) {
        0 => {
            for _ in 0..=dice.roll(4) {
                if let Some(byte) = {
                    let at = dice.roll(bytes.len());
                    bytes.get_mut(at)
                } {
                    *byte ^= 1 << dice.roll(8);
                }
            }
            "flipped bits".into()
        }
        1 => {
            bytes.truncate(at);
            format!("cut at byte {at}")
        }
        2 => {
            bytes.clear();
            "empty".into()
        }
        3 => {
            let text = String::from_utf8_lossy(bytes).replace('\n', "\r\n");
            *bytes = text.into_bytes();
            "line ends of Windows".into()
        }
        4 => {
            bytes.splice(0..0, [0xef, 0xbb, 0xbf]);
            "byte order mark".into()
        }
        5 => {
            bytes.splice(at..at, [0xff, 0xfe, 0xc0]);
            "not UTF-8".into()
        }
        6 => {
            let piece: Vec<u8> = bytes[at..].iter().take(1 + dice.roll(200)).copied().collect();
            bytes.splice(at..at, piece);
            format!("a piece twice at byte {at}")
        }
        7 => {
            bytes.splice(at..at, vec![*dice.one(b"9x, \"\0"); 1 << (4 + dice.roll(14))]);
            format!("a very long line at byte {at}")
        }
        _ => {
            *bytes = (0..bytes.len()).map(|_| dice.next() as u8).collect();
            "noise".into()
        }
    }
}

fn damage_table(table: &mut Vec<Vec<String>>, dice: &mut Dice) -> String {
    if table.is_empty() {
        return "no rows left".into();
    }
    let columns = table[0].len();
    let (row, column) = (dice.roll(table.len()), dice.roll(columns));
    let scaled = |table: &mut Vec<Vec<String>>, factor: f64| {
        for cell in table.iter_mut().skip(1).filter_map(|row| row.get_mut(column)) {
            if let Ok(number) = cell.parse::<f64>() {
                *cell = (factor * number).to_string();
            }
        }
    };
    match dice.roll(12) {
        0 => {
            table.iter_mut().for_each(|row| drop((column < row.len()).then(|| row.remove(column))));
            format!("without column {column}")
        }
        1 => {
            let last = (row + 1 + dice.roll(20)).min(table.len());
            table.drain(row..last);
            format!("without rows {row} to {last}")
        }
        2 => {
            let other = dice.roll(columns);
            for cells in table.iter_mut().filter(|cells| cells.len() > column.max(other)) {
                cells.swap(column, other);
            }
            format!("columns {column} and {other} swapped")
        }
        3 => {
            let other = dice.roll(columns);
            if let Some(header) = table.first_mut().filter(|header| header.len() > column.max(other)) {
                header.swap(column, other);
            }
            format!("names of columns {column} and {other} swapped")
        }
        4 => {
            let copy = table[row].clone();
            table.insert(row, copy);
            format!("row {row} twice")
        }
        5 => {
            let other = dice.roll(table.len());
            table.swap(row, other);
            format!("rows {row} and {other} swapped")
        }
        6 => {
            let factor = *dice.one(&[1e3, 1e6, 1e9, 1e-3, 180.0 / std::f64::consts::PI, -1.0, 0.0, 1e30, 1e300]);
            scaled(table, factor);
            format!("column {column} times {factor:e}")
        }
        7 => {
            let field = *dice.one(&FIELDS);
            table.iter_mut().skip(1).filter_map(|row| row.get_mut(column)).for_each(|cell| *cell = field.into());
            format!("column {column} all {field:?}")
        }
        8 => {
            table.truncate(1);
            "header alone".into()
        }
        _ => {
            let field = *dice.one(&FIELDS);
            if let Some(cell) = table.get_mut(row).and_then(|cells| cells.get_mut(column)) {
                *cell = field.into();
            }
            format!("row {row}, column {column} is {field:?}")
        }
    }
}

fn damage_head(bytes: &mut Vec<u8>, dice: &mut Dice) -> String {
    let mut lines: Vec<String> = String::from_utf8_lossy(bytes).lines().map(str::to_owned).collect();
    if lines.is_empty() {
        return "no lines left".into();
    }
    let line = dice.roll(lines.len());
    let what = match dice.roll(6) {
        0 => format!("without line {:?}", lines.remove(line)),
        1 => {
            let other = dice.one(&LINES).to_string();
            lines.insert(line, other.clone());
            format!("with line {other:?}")
        }
        2 => {
            let depth = 1 << dice.roll(18);
            lines.insert(0, format!("deep = {}1{}", "[".repeat(depth), "]".repeat(depth)));
            format!("nested {depth} deep")
        }
        3 => {
            let depth = 1 << dice.roll(14);
            lines.push(format!("{} = 1", vec!["a"; depth].join(".")));
            format!("a key of {depth} parts")
        }
        4 => {
            lines.swap(line, 0);
            format!("line {line} first")
        }
        _ => {
            let field = *dice.one(&FIELDS);
            if let Some((key, _)) = lines[line].clone().split_once('=') {
                lines[line] = format!("{key}= {field}");
            }
            format!("line {line} is {field:?}")
        }
    };
    *bytes = lines.join("\n").into_bytes();
    what
}

/// A folder with one or two damages, and their descriptions.
fn damaged(good: &[Files], seed: u64) -> (Files, String) {
    let mut dice = Dice(seed);
    let mut files = dice.one(good).clone();
    let mut what = damage(&mut files, &mut dice);
    if dice.roll(3) == 0 {
        what = format!("{what}; {}", damage(&mut files, &mut dice));
    }
    (files, what)
}

#[derive(Debug, PartialEq)]
enum Outcome {
    /// The reader, the settings or the filter reported the error in one line: exit code 2.
    Refused,
    /// It was run, and all numbers are finite.
    Run,
    /// Neither of the two.
    Bad(String),
}

fn refused(line: &str) -> Outcome {
    if line.chars().any(char::is_control) || line.len() > 1000 { Outcome::Bad(line.into()) } else { Outcome::Refused }
}

fn of_session<D: Dimensions>(session: Result<Session<D>, SessionError>) -> Outcome {
    match session {
        Ok(session) if is_finite(&session) => Outcome::Run,
        Ok(_) => Outcome::Bad("an estimate is not finite".into()),
        Err(error @ (SessionError::Start(_) | SessionError::Step { .. })) => refused(&error.to_string()),
        Err(other) => Outcome::Bad(other.to_string()),
    }
}

const FILTER: Filter = Filter::Core(Precision::F32);

/// Reads a folder like `replay`, and runs it if it can be read.
fn outcome(dir: &Path) -> Outcome {
    if log_folder::has_camera(dir) {
        let mut log = match log_folder::read_underwater(dir) {
            Ok(log) => log,
            Err(error) => return refused(&error.to_string()),
        };
        log.scans.truncate(SCANS);
        let settings = scphd_filters::underwater::settings::Settings::for_real_log(&log);
        if let Err(error) = settings.check() {
            return refused(&error.to_string());
        }
        let session = session::run::<Underwater>(&log, &settings, FILTER, 1, &mut |_| ());
        return of_session(session);
    }
    let mut log = match log_folder::read(dir) {
        Ok(log) => log,
        Err(error) => return refused(&error.to_string()),
    };
    log.scans.truncate(SCANS);
    let mut settings = Settings::for_log(&log);
    settings.filter.particles = 4;
    if let Err(error) = settings.check() {
        return refused(&error.to_string());
    }
    of_session(session::run::<Planar>(&log, &settings, FILTER, 1, &mut |_| ()))
}

/// Whether all estimates of a session are finite.
fn is_finite<D: Dimensions>(session: &Session<D>) -> bool {
    let Record { scans, map } = &session.record;
    let of_pose = |scan: &ScanRecord<D>| finite(&scan.pose) && scan.pose_covariance.as_ref().iter().all(finite);
    let of_map = |place: &MapFeature<D>| finite(&place.mean) && place.covariance.as_ref().iter().all(finite);
    scans.iter().all(of_pose) && map.iter().all(of_map)
}

fn finite(numbers: &impl AsRef<[f64]>) -> bool {
    numbers.as_ref().iter().all(|number| number.is_finite())
}

#[test]
fn damaged_folders_are_refused_or_run() {
    let folders = std::env::var("SCPHD_DAMAGED_FOLDERS").map_or(FOLDERS, |text| text.parse().unwrap());
    let good = good();
    let dir = TempDir::new().unwrap();
    let (mut refused, mut run, mut bad) = (0, 0, Vec::new());
    for seed in 0..folders {
        let (files, what) = damaged(&good, seed);
        let folder = dir.path().join(seed.to_string());
        folders::put(&folder, &files);
        match catch_unwind(|| outcome(&folder)) {
            Ok(Outcome::Refused) => refused += 1,
            Ok(Outcome::Run) => run += 1,
            Ok(Outcome::Bad(why)) => bad.push(format!("seed {seed}, {what}: {why}")),
            Err(_) => bad.push(format!("seed {seed}, {what}: panic")),
        }
        fs::remove_dir_all(&folder).unwrap();
    }
    println!("{folders} damaged folders: {refused} refused, {run} run");
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    // The generator damages folders, and the reader accepts some of them.
    assert!(refused > folders / 3 && run > folders / 10, "{refused} refused, {run} run");
}

#[test]
fn the_good_folders_are_run() {
    let dir = TempDir::new().unwrap();
    for (place, files) in good().iter().enumerate() {
        let folder = dir.path().join(place.to_string());
        folders::put(&folder, files);
        assert_eq!(outcome(&folder), Outcome::Run);
    }
}

#[test]
fn the_program_has_the_outcome_of_the_reader() {
    let good = good();
    let dir = TempDir::new().unwrap();
    for seed in 0..THROUGH_THE_PROGRAM {
        let (files, what) = damaged(&good, seed);
        folders::put(&dir.path().join("log"), &files);
        let mut command = Command::new(env!("CARGO_BIN_EXE_scphd-sim"));
        let args = ["replay", "log", "--particles", "2", "--json", "run.json", "--out", "out"];
        let output = command.args(args).current_dir(dir.path()).output().unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        match output.status.code() {
            Some(0) => assert!(!told.contains("panicked"), "seed {seed}, {what}: {told}"),
            Some(2) => {
                assert!(told.starts_with("error: ") && told.lines().count() == 1, "seed {seed}, {what}: {told}");
                let inside = told.trim_end_matches('\n');
                assert!(!inside.chars().any(char::is_control), "seed {seed}, {what}: {told:?}");
            }
            other => panic!("seed {seed}, {what}: exit code {other:?}, {told}"),
        }
        fs::remove_dir_all(dir.path().join("log")).unwrap();
    }
}

/// These tests have less value without overflow checks. Cargo's test profiles have them; a release build need not.
#[test]
#[cfg(debug_assertions)]
fn overflow_is_checked() {
    let one = std::hint::black_box(1_i64);
    assert!(catch_unwind(|| i64::MAX + one).is_err());
}
