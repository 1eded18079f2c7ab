//! Findings of the check in logs with damage by people, editors and scripts: each is reported or read correctly, never silently
//! wrong.

use scphd_check as check;
use scphd_check::{Report, Severity};
use scphd_log::log::Log;
use scphd_log::log_folder;
use scphd_worlds::scenario;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

mod folders;

struct Place(TempDir);

impl Place {
    fn of(log: &Log) -> Self {
        let place = Self(TempDir::new().unwrap());
        log_folder::write(log, &place.log()).unwrap();
        place
    }

    /// A log of an Ackermann vehicle with truth and landmarks.
    fn car() -> Self {
        Self::of(&scenario::survey(1))
    }

    /// A log of a unicycle with measurements only, without truth.
    fn robot_without_truth() -> Self {
        let mut log = scenario::by_name("worlds", 900_002).unwrap();
        assert!(!matches!(log.vehicle, scphd_log::log::Vehicle::Ackermann { .. }));
        log.truth.clear();
        log.landmarks.clear();
        log.moving.clear();
        Self::of(&log)
    }

    fn stereo() -> Self {
        let place = Self(TempDir::new().unwrap());
        folders::put(&place.log(), &folders::stereo());
        place
    }

    fn log(&self) -> PathBuf {
        self.0.path().join("log")
    }

    fn text(&self, file: &str) -> String {
        fs::read_to_string(self.log().join(file)).unwrap()
    }

    fn change(&self, file: &str, change: impl FnOnce(&str) -> String) {
        let text = self.text(file);
        let changed = change(&text);
        assert_ne!(text, changed, "{file}");
        fs::write(self.log().join(file), changed).unwrap();
    }

    /// Converts ranges, and those of the view in `log.toml`, to another unit.
    fn ranges(&self, times: f64) {
        self.column("detections.csv", "range_m", |x| x * times);
        self.change("log.toml", |text| {
            let row = |line: &str| match line.split_once(" = ") {
                Some((key, value)) if key.starts_with("range_") => {
                    format!("{key} = {:?}\n", times * value.parse::<f64>().unwrap())
                }
                _ => format!("{line}\n"),
            };
            text.lines().map(row).collect()
        });
    }

    fn column(&self, file: &str, name: &str, change: impl Fn(f64) -> f64) {
        self.change(file, |text| {
            let mut lines = text.lines();
            let header = lines.next().unwrap();
            let at = header.split(',').position(|title| title == name).unwrap();
            let row = |line: &str| {
                let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
                if let Ok(number) = cells[at].parse::<f64>() {
                    cells[at] = change(number).to_string();
                }
                cells.join(",")
            };
            std::iter::once(header.to_owned()).chain(lines.map(row)).map(|line| line + "\n").collect()
        });
    }

    /// Replaces a cell; the header is line 0.
    fn cell(&self, file: &str, line: usize, column: usize, cell: &str) {
        self.change(file, |text| {
            let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
            let mut cells: Vec<&str> = lines[line].split(',').collect();
            cells[column] = cell;
            lines[line] = cells.join(",");
            lines.join("\n") + "\n"
        });
    }

    fn times(&self, change: impl Fn(f64) -> f64 + Copy) {
        for file in ["odometry.csv", "scans.csv", "truth.csv", "moving.csv", "fixes.csv"] {
            if self.log().join(file).exists() {
                self.column(file, "t_s", change);
            }
        }
    }

    fn check(&self) -> Report {
        check::folder(&self.log())
    }

    fn run(&self, args: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_scphd-sim")).args(args).current_dir(self.0.path()).output().unwrap()
    }
}

/// Severity and code of the findings, without notes.
fn found(report: &Report) -> Vec<(Severity, &'static str)> {
    let worse = report.findings.iter().filter(|one| one.severity > Severity::Note);
    worse.map(|one| (one.severity, one.code)).collect()
}

#[test]
fn good_logs_have_no_findings() {
    for place in [Place::car(), Place::of(&scenario::two_sensors(2)), Place::stereo()] {
        let report = place.check();
        assert!(report.findings.is_empty(), "{:?}", report.findings);
        assert!(report.facts.unwrap().dead_reckoning_rmse_m.is_some());
    }
    let report = Place::robot_without_truth().check();
    assert_eq!(report.findings.iter().map(|one| one.code).collect::<Vec<_>>(), ["no-truth"]);
    for seed in 900_010..900_020 {
        let report = Place::of(&scenario::by_name("worlds", seed).unwrap()).check();
        assert_eq!(found(&report), [], "world {seed}: {:?}", report.findings);
    }
}

#[test]
fn recorded_logs_have_no_false_findings() {
    let Some(dir) = scphd_shared_data::find("victoria_park") else { return };
    let all: Vec<PathBuf> = fs::read_dir(dir.parent().unwrap()).unwrap().map(|entry| entry.unwrap().path()).collect();
    let logs = all.iter().filter(|dir| dir.join("log.toml").exists());
    for log in logs {
        let report = check::folder(log);
        assert_eq!(found(&report), [], "{}: {:?}", log.display(), report.findings);
    }
}

#[test]
fn windows_line_ends_and_byte_order_marks_are_read() {
    let place = Place::car();
    let plain = place.check();
    for file in ["log.toml", "odometry.csv", "scans.csv", "detections.csv", "truth.csv", "landmarks.csv"] {
        place.change(file, |text| format!("\u{feff}{}", text.replace('\n', "\r\n")));
    }
    let report = place.check();
    assert_eq!(report.facts, plain.facts);
    assert_eq!(report.findings.iter().filter(|one| one.code == "text-form").count(), 6);
    assert_eq!(found(&report), []);
}

/// The damage of a log, and the finding that is required.
type Case = (&'static str, fn(&Place), Severity, &'static str);

fn all_are_found(make: impl Fn() -> Place, cases: &[Case]) {
    for (name, damage, severity, code) in cases {
        let place = make();
        damage(&place);
        let report = place.check();
        let found = found(&report);
        println!("{name}: {:?}", report.findings);
        assert!(found.contains(&(*severity, *code)), "{name}: {:?}", report.findings);
        assert!(report.findings.iter().all(|one| !one.advice.is_empty() && !one.what.is_empty()), "{name}");
        // A log that cannot be read has no facts.
        assert_eq!(report.facts.is_none(), found[0].0 == Severity::Error, "{name}");
    }
}

const TO_DEGREES: f64 = 180.0 / std::f64::consts::PI;

#[test]
fn damaged_logs_of_a_car() {
    use Severity::{Error, Warning};
    let cases: [Case; 31] = [
        ("steering in degrees", |p| p.column("odometry.csv", "steering_rad", |x| x * TO_DEGREES), Error, "angle-unit"),
        ("bearings in degrees", |p| p.column("detections.csv", "bearing_rad", |x| x * TO_DEGREES), Error, "angle-unit"),
        ("times in milliseconds", |p| p.times(|t| t * 1e3), Error, "time-unit"),
        ("times in microseconds", |p| p.times(|t| t * 1e6), Error, "time-unit"),
        ("times in nanoseconds", |p| p.times(|t| 1.7e18 + t * 1e9), Error, "time-unit"),
        ("times in minutes", |p| p.times(|t| t / 60.0), Warning, "way-unit"),
        ("times in days", |p| p.times(|t| t / 86400.0), Warning, "time-unit"),
        ("odometry with another clock", |p| p.column("odometry.csv", "t_s", |t| t + 1e4), Error, "other-clock"),
        ("truth with another clock", |p| p.column("truth.csv", "t_s", |t| t + 1e6), Warning, "truth-other-clock"),
        (
            "truth in millimetres",
            |p| {
                p.column("truth.csv", "x_m", |x| x * 1e3);
                p.column("truth.csv", "y_m", |x| x * 1e3);
            },
            Warning,
            "way-unit",
        ),
        (
            "true headings in degrees",
            |p| p.column("truth.csv", "heading_rad", |x| x * TO_DEGREES),
            Warning,
            "heading-unit",
        ),
        ("speeds in km/h", |p| p.column("odometry.csv", "speed_mps", |x| x * 3.6), Warning, "way-unit"),
        ("ranges in millimetres", |p| p.column("detections.csv", "range_m", |x| x * 1e3), Error, "range-unit"),
        ("ranges in kilometres", |p| p.column("detections.csv", "range_m", |x| x / 1e3), Warning, "range-unit"),
        ("steering to the right", |p| p.column("odometry.csv", "steering_rad", |x| -x), Warning, "turn-sign"),
        (
            "the start turned",
            |p| {
                p.change("log.toml", |text| {
                    let at = text.find("initial_pose").unwrap();
                    let end = at + text[at..].find(']').unwrap();
                    format!("{}initial_pose = [0.0, 0.0, 2.0{}", &text[..at], &text[end..])
                })
            },
            Warning,
            "start-heading",
        ),
        (
            "the view narrowed",
            |p| p.change("log.toml", |text| text.replace("range_max_m = 15.0", "range_max_m = 9.0")),
            Warning,
            "out-of-view",
        ),
        (
            "every scan twice",
            |p| {
                let number = |text: &str, twice: bool| {
                    let mut lines = text.lines();
                    let mut out = vec![lines.next().unwrap().to_owned()];
                    let mut rows: Vec<(u64, String)> = lines
                        .map(|line| {
                            let (scan, rest) = line.split_once(',').unwrap();
                            (scan.parse().unwrap(), rest.to_owned())
                        })
                        .collect();
                    if twice {
                        rows = rows
                            .iter()
                            .flat_map(|(scan, rest)| [(2 * scan, rest.clone()), (2 * scan + 1, rest.clone())])
                            .collect();
                        rows.sort_by_key(|(scan, _)| *scan);
                    }
                    out.extend(rows.into_iter().map(|(scan, rest)| format!("{scan},{rest}")));
                    out.join("\n") + "\n"
                };
                p.change("scans.csv", |text| number(text, true));
                p.change("detections.csv", |text| number(text, true));
            },
            Warning,
            "scans-doubled",
        ),
        (
            "every detection twice",
            |p| {
                p.change("detections.csv", |text| {
                    let mut lines = text.lines();
                    let header = lines.next().unwrap();
                    lines.fold(format!("{header}\n"), |all, line| format!("{all}{line}\n{line}\n"))
                })
            },
            Warning,
            "detections-doubled",
        ),
        ("scans numbered twice", |p| p.change("scans.csv", |text| text.replacen("\n3,", "\n2,", 1)), Error, "order"),
        (
            "five seconds of odometry lost",
            |p| {
                p.change("odometry.csv", |text| {
                    let keep = |line: &&str| {
                        line.split(',').next().unwrap().parse::<f64>().is_ok_and(|t| !(20.0..25.0).contains(&t))
                    };
                    let header = text.lines().next().unwrap();
                    text.lines().filter(keep).fold(format!("{header}\n"), |all, line| format!("{all}{line}\n"))
                })
            },
            Warning,
            "odometry-gap",
        ),
        (
            "odometry that ends early",
            |p| {
                p.change("odometry.csv", |text| {
                    let keep: Vec<&str> = text.lines().take(1000).collect();
                    keep.join("\n")
                })
            },
            Warning,
            "scans-without-odometry",
        ),
        (
            "semicolons",
            |p| p.change("odometry.csv", |text| text.replace('.', ",").replace(",\n", "\n").replace(',', ";")),
            Error,
            "separator",
        ),
        (
            "UTF-16",
            |p| {
                let words: Vec<u8> = p.text("scans.csv").encode_utf16().flat_map(u16::to_le_bytes).collect();
                fs::write(p.log().join("scans.csv"), [&[0xff, 0xfe], &words[..]].concat()).unwrap();
            },
            Error,
            "encoding",
        ),
        (
            "a column in degrees by name",
            |p| p.change("detections.csv", |text| text.replace("bearing_rad", "bearing_deg")),
            Error,
            "column-missing",
        ),
        ("no detections", |p| fs::remove_file(p.log().join("detections.csv")).unwrap(), Error, "file-missing"),
        ("an empty file", |p| p.change("detections.csv", |_| String::new()), Error, "file-empty"),
        (
            "nothing but a header",
            |p| p.change("detections.csv", |text| text.lines().next().unwrap().to_owned() + "\n"),
            Warning,
            "no-detections",
        ),
        ("a range beyond single precision", |p| p.cell("detections.csv", 77, 1, "1e300"), Error, "unreadable"),
        (
            "every row of odometry three times",
            |p| {
                p.change("odometry.csv", |text| {
                    let (header, rows) = text.split_once('\n').unwrap();
                    rows.lines().fold(format!("{header}\n"), |all, row| all + &format!("{row}\n").repeat(3))
                })
            },
            Warning,
            "time-unit",
        ),
        ("a single time of all scans", |p| p.column("scans.csv", "t_s", |_| 5.0), Warning, "time-unit"),
    ];
    all_are_found(Place::car, &cases);
}

#[test]
fn a_spike_of_the_odometry_is_reported_with_its_row_and_gives_no_other_finding() {
    let cases = [(1, "1000"), (1, "1e5"), (1, "-32768"), (1, "1e30"), (2, "1e8")];
    for (truth, column, cell) in [true, false].iter().flat_map(|truth| cases.map(|(at, cell)| (*truth, at, cell))) {
        let place = Place::of(&scenario::by_name("worlds", 900_002).unwrap());
        if !truth {
            fs::remove_file(place.log().join("truth.csv")).unwrap();
        }
        place.cell("odometry.csv", 77, column, cell);
        let report = place.check();
        assert_eq!(found(&report), [(Severity::Warning, "odometry-spike")], "{cell}: {:?}", report.findings);
        assert!(report.findings.iter().any(|one| one.place == "odometry.csv, row 78"), "{:?}", report.findings);
    }
    // It has no effect on default settings either.
    let place = Place::of(&scenario::by_name("worlds", 900_002).unwrap());
    place.cell("odometry.csv", 77, 1, "1e5");
    let replayed = place.run(&["replay", "log"]);
    assert!(replayed.status.success(), "{replayed:?}");
}

/// Worlds 900 020 to 900 025: three times the greatest usual speed in one row, without truth.
#[test]
fn a_small_spike_is_reported_with_its_row() {
    for seed in 900_020..900_026 {
        let mut log = scenario::by_name("worlds", seed).unwrap();
        log.truth.clear();
        let place = Place::of(&log);
        let usual = log.odometry.iter().map(|row| row.control[0].abs()).fold(0.0, f64::max);
        place.cell("odometry.csv", 120, 1, &format!("{}", 3.0 * usual));
        let report = place.check();
        let spikes: Vec<_> = report.findings.iter().filter(|one| one.code == "odometry-spike").collect();
        let [spike] = spikes[..] else { panic!("world {seed}: {:?}", report.findings) };
        assert_eq!(spike.place, "odometry.csv, row 121", "world {seed}: {spike:?}");
    }
}

/// Worlds 900 020 to 900 025, without truth: scans a second late and a second early.
#[test]
fn a_clock_shift_of_the_scans_is_reported_with_its_size() {
    for seed in 900_020..900_026 {
        let mut log = scenario::by_name("worlds", seed).unwrap();
        log.truth.clear();
        for (shift_s, told) in [(1.0, "1.00 s earlier"), (-1.0, "1.00 s later")] {
            let place = Place::of(&log);
            place.column("scans.csv", "t_s", |t_s| t_s + shift_s);
            let report = place.check();
            let shift = report.findings.iter().find(|one| one.code == "clock-shift");
            assert!(shift.is_some_and(|one| one.what.contains(told)), "world {seed}: {:?}", report.findings);
        }
    }
}

/// World 900 002 with a position of 0.5 m a second, damaged like those of receivers.
#[test]
fn positions_are_compared_with_odometry() {
    use scphd_log::log::{Fix, FixNoise, PoseFix};
    let mut log = scenario::by_name("worlds", 900_002).unwrap();
    let begin_s = log.odometry[0].t_s;
    let mut next_s = begin_s;
    for (place, row) in log.truth.iter().enumerate().filter(|(_, row)| row.t_s > begin_s) {
        if row.t_s >= next_s {
            next_s += 1.0;
            let off = [0.5, -0.3, 0.1, -0.4, 0.2][place % 5];
            log.fixes.push(Fix {
                t_s: row.t_s,
                measured: PoseFix::Position([row.position[0] + off, row.position[1] - off]),
            });
        }
    }
    log.fix_noise = FixNoise { position_sigma_m: Some(0.5), ..FixNoise::default() };
    assert_eq!(found(&Place::of(&log).check()), []);
    let each = |change: fn([f64; 2]) -> [f64; 2]| {
        let mut log = log.clone();
        for fix in &mut log.fixes {
            let PoseFix::Position(place) = &mut fix.measured else { continue };
            *place = change(*place);
        }
        Place::of(&log)
    };
    let codes = |place: &Place| found(&place.check()).into_iter().map(|(_, code)| code).collect::<Vec<_>>();
    assert_eq!(codes(&each(|[x, y]| [1000.0 * x, 1000.0 * y])), ["fix-unit"]);
    assert_eq!(codes(&each(|[x, y]| [48.0 + y / 111_000.0, 11.0 + x / 74_000.0])), ["fix-unit"]);
    assert_eq!(codes(&each(|[x, y]| [y, x])), ["fix-axes"]);
    assert_eq!(codes(&each(|[x, y]| [x + 500_000.0, y + 5_500_000.0])), ["fix-frame"]);
    let mut sure = log.clone();
    sure.fix_noise.position_sigma_m = Some(0.02);
    assert_eq!(codes(&Place::of(&sure)), ["fix-noise"]);
    let mut held = log.clone();
    held.fixes = log.fixes.iter().flat_map(|fix| [*fix, *fix]).collect();
    assert_eq!(codes(&Place::of(&held)), ["fixes-doubled"]);
}

/// Worlds 900 020 to 900 025, without truth.
#[test]
fn bearings_from_an_axis_of_the_map_are_reported() {
    let mut told = 0;
    for seed in 900_020..900_026 {
        let mut log = scenario::by_name("worlds", seed).unwrap();
        let truth = std::mem::take(&mut log.truth);
        for scan in &mut log.scans {
            let row = truth.partition_point(|row| row.t_s <= scan.t_s).saturating_sub(1);
            let heading = truth[row].heading_rad.unwrap();
            for [_, bearing] in &mut scan.detections {
                *bearing = libm::remainder(*bearing + heading, std::f64::consts::TAU);
            }
        }
        log.sensor.bearing_min_rad = -std::f64::consts::PI;
        log.sensor.bearing_max_rad = std::f64::consts::PI;
        let codes: Vec<_> = found(&Place::of(&log).check()).into_iter().map(|(_, code)| code).collect();
        assert!(!codes.is_empty(), "world {seed}");
        told += usize::from(codes.contains(&"bearing-frame"));
    }
    assert_eq!(told, 6);
}

#[test]
fn a_comment_above_the_header_is_reported_once() {
    let place = Place::car();
    place.change("odometry.csv", |text| format!("# of my logger\n{text}"));
    assert_eq!(found(&place.check()), [(Severity::Error, "comment")]);
}

#[test]
fn a_table_without_rows_is_not_reported_as_missing() {
    let place = Place::car();
    place.change("truth.csv", |text| text.lines().next().unwrap().to_owned() + "\n");
    let report = place.check();
    let [note] = &report.findings[..] else { panic!("{:?}", report.findings) };
    assert_eq!((note.code, note.what.contains("missing")), ("no-truth", false), "{note:?}");
    // A stereo log starts at its first row.
    let place = Place::stereo();
    place.change("truth.csv", |text| text.lines().next().unwrap().to_owned() + "\n");
    assert_eq!(found(&place.check()), [(Severity::Error, "file-empty")]);
}

/// The check uses the capacity of a replay for detections in a scan.
#[test]
fn a_scan_with_too_many_detections_is_reported_before_the_replay_refuses_it() {
    for (count, fits) in [(256, true), (257, false)] {
        let place = Place::car();
        place.change("detections.csv", |text| {
            let row = |k: usize| {
                format!(
                    "3,{},0.1{}\n",
                    1.0 + 0.05 * k as f64,
                    ",-1".repeat(text.lines().next().unwrap().matches(',').count() - 2)
                )
            };
            let header = text.lines().next().unwrap();
            std::iter::once(format!("{header}\n")).chain((0..count).map(row)).collect()
        });
        let report = place.check();
        let crowded = report.findings.iter().find(|one| one.code == "scan-crowded");
        assert_eq!(crowded.is_none(), fits, "{:?}", report.findings);
        assert!(crowded.is_none_or(|one| one.what.starts_with("scan 3, ") && one.what.contains("257 detections")));
        for filter in ["joint", "core"] {
            let few = if filter == "core" { &["--particles", "2"][..] } else { &[] };
            let replayed = place.run(&[&["replay", "log", "--filter", filter], few].concat());
            assert_eq!(replayed.status.success(), fits, "{replayed:?}");
        }
        let replayed = place.run(&["replay", "log", "--filter", "ekf"]);
        assert!(replayed.status.success(), "{replayed:?}");
    }
}

#[test]
fn damaged_logs_of_a_robot_without_truth() {
    use Severity::{Error, Warning};
    let cases: [Case; 12] = [
        (
            "turn rates in degrees",
            |p| p.column("odometry.csv", "omega_radps", |x| x * TO_DEGREES),
            Warning,
            "turn-unit",
        ),
        ("ranges in mm", |p| p.ranges(1000.0), Warning, "range-unit"),
        ("ranges in cm", |p| p.ranges(100.0), Warning, "range-unit"),
        ("ranges in feet", |p| p.ranges(3.28084), Warning, "range-unit"),
        ("turn rates to the right", |p| p.column("odometry.csv", "omega_radps", |x| -x), Warning, "mirrored"),
        ("bearings to the right", |p| p.column("detections.csv", "bearing_rad", |x| -x), Warning, "mirrored"),
        ("speeds in km/h", |p| p.column("odometry.csv", "v_mps", |x| x * 3.6), Warning, "speed-unit"),
        ("speeds in cm/s", |p| p.column("odometry.csv", "v_mps", |x| x * 100.0), Error, "way-unit"),
        ("speeds in mm/s", |p| p.column("odometry.csv", "v_mps", |x| x * 1000.0), Error, "way-unit"),
        ("times in milliseconds", |p| p.times(|t| t * 1e3), Error, "time-unit"),
        ("times in nanoseconds", |p| p.times(|t| t * 1e9), Error, "time-unit"),
        (
            "two columns missing",
            |p| {
                p.change("odometry.csv", |text| text.replace("omega_radps", "omega_dps"));
                p.change("scans.csv", |text| text.replace("t_s", "t_ms"));
            },
            Error,
            "column-missing",
        ),
    ];
    all_are_found(Place::robot_without_truth, &cases);
    let place = Place::robot_without_truth();
    cases[11].1(&place);
    let report = place.check();
    let advice: Vec<&str> = report.findings.iter().map(|one| one.advice.as_str()).collect();
    assert!(
        advice.iter().any(|text| text.contains("0.0174533")) && advice.iter().any(|text| text.contains("1e3")),
        "{advice:?}"
    );
}

#[test]
fn damaged_logs_of_a_stereo_camera() {
    use Severity::{Error, Warning};
    let cases: [Case; 7] = [
        (
            "images exchanged",
            |p| {
                p.change("detections.csv", |text| {
                    text.replace("ul_px", "other").replace("ur_px", "ul_px").replace("other", "ur_px")
                })
            },
            Warning,
            "images-exchanged",
        ),
        (
            "a larger image",
            |p| {
                ["ul_px", "vl_px", "ur_px", "vr_px"]
                    .iter()
                    .for_each(|name| p.column("detections.csv", name, |x| 3.0 * x))
            },
            Warning,
            "out-of-view",
        ),
        (
            "baseline in millimetres",
            |p| p.change("log.toml", |text| text.replace("baseline_m = 0.24", "baseline_m = 240.0")),
            Warning,
            "depth",
        ),
        ("times in nanoseconds", |p| p.times(|t| t * 1e9), Error, "time-unit"),
        ("velocities in mm/s", |p| p.column("odometry.csv", "vx_mps", |x| x * 1e3), Error, "way-unit"),
        (
            "a column missing",
            |p| p.change("truth.csv", |text| text.replace("rz_rad", "rz_deg")),
            Error,
            "column-missing",
        ),
        (
            "every frame as the first",
            |p| {
                p.change("detections.csv", |text| {
                    let mut lines = text.lines();
                    let header = lines.next().unwrap();
                    let first: Vec<&str> = lines.take_while(|line| line.starts_with("0,")).collect();
                    let all =
                        (0..folders::FRAMES).flat_map(|k| first.iter().map(move |line| format!("{k}{}\n", &line[1..])));
                    std::iter::once(format!("{header}\n")).chain(all).collect()
                })
            },
            Warning,
            "scans-doubled",
        ),
    ];
    all_are_found(Place::stereo, &cases);
}

#[test]
fn the_command_prints_writes_and_fails_like_others() {
    let place = Place::car();
    let good = place.run(&["check", "log", "--strict"]);
    assert_eq!((good.status.code(), good.stderr.len()), (Some(0), 0), "{good:?}");
    assert!(String::from_utf8(good.stdout).unwrap().contains("nothing found"));

    place.column("odometry.csv", "steering_rad", |x| -x);
    let warned = place.run(&["check", "log", "--json", "-"]);
    assert_eq!(warned.status.code(), Some(0), "{warned:?}");
    let report: serde_json::Value = serde_json::from_slice(&warned.stdout).unwrap();
    assert_eq!(
        (&report["findings"][0]["code"], &report["findings"][0]["severity"]),
        (&"mirrored".into(), &"warning".into())
    );
    assert_eq!(place.run(&["check", "log", "--strict"]).status.code(), Some(2));
    // The same text before a replay.
    let replayed = place.run(&["replay", "log"]);
    let said = String::from_utf8(replayed.stderr).unwrap();
    assert!(replayed.status.success() && said.contains("turn-sign"), "{said}");

    place.times(|t| t * 1e9);
    let bad = place.run(&["check", "log", "missing"]);
    assert_eq!(bad.status.code(), Some(2));
    let (told, error) = (String::from_utf8(bad.stdout).unwrap(), String::from_utf8(bad.stderr).unwrap());
    assert!(told.contains("nanoseconds") && told.contains("do: divide"), "{told}");
    assert_eq!(error, "error: 2 of 2 logs are not as they should be\n");
    assert!(Path::new(&place.log()).exists());
}
