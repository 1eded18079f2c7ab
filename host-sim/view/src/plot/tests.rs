//! Tests of whole figures of artificial runs.

use super::*;
use resvg::tiny_skia::Pixmap;
use scphd_log::dimensions::Planar;
use scphd_log::log::{Log, Scan, Sensor, TruePose};
use scphd_score::record::{MapFeature, ScanRecord};
use scphd_shared_data::Folder;
use std::f64::consts::{PI, TAU};
use svg::node::element::path::{Command, Data};
use svg::parser::Event;

/// Deterministic noise in [−1, 1] (the fractional part of a sine of high frequency).
fn noise(index: usize, stream: f64) -> f64 {
    let value = ((index as f64 + 1.0) * 12.9898 + stream * 78.233).sin() * 43_758.545_3;
    2.0 * (value - value.floor()) - 1.0
}

fn empty_log() -> Log {
    Log {
        name: "test".into(),
        sensor: Sensor { range_max_m: 8.0, bearing_min_rad: -PI / 2.0, bearing_max_rad: PI / 2.0, ..Sensor::default() },
        simulated: true,
        ..Log::default()
    }
}

fn feature(mean: [f64; 2], sigma: f64, weight: f64) -> MapFeature {
    let variance = sigma * sigma;
    MapFeature { id: 1, weight, mean, covariance: [[variance, 0.6 * variance], [0.6 * variance, 0.5 * variance]] }
}

/// A run along `path` (pose at an index), with an error of about `error` m and a drift of dead reckoning of `drift` m.
fn record(log: &Log, path: impl Fn(usize) -> [f64; 3], error: f64, drift: f64) -> Record {
    let count = log.scans.len();
    let scans = log.scans.iter().enumerate().map(|(i, scan)| {
        let pose = path(i);
        let share = i as f64 / count as f64;
        let covered = log.truth.iter().any(|row| (row.t_s - scan.t_s).abs() < 1e-6);
        let wave = (8.0 * share).sin();
        let variance = (0.6 * error).powi(2) * (1.1 + wave) / 2.0;
        ScanRecord {
            t_s: scan.t_s,
            pose: [
                pose[0] + error * (0.8 * wave * share + 0.1 * noise(i, 1.0)),
                pose[1] + error * (0.5 * wave + 0.1 * noise(i, 2.0)),
                pose[2] + 0.03 * wave + 0.01 * noise(i, 3.0),
            ],
            pose_covariance: [[variance, 0.0, 0.0], [0.0, variance, 0.0], [0.0, 0.0, 1e-3]],
            dead_reckoning: [pose[0] + drift * share * share, pose[1] - 0.7 * drift * share, pose[2] + 0.2 * share],
            true_position: covered.then_some([pose[0], pose[1]]),
            true_heading_rad: covered.then_some(pose[2]),
            measurements: 5,
            features_estimated: log.landmarks.len() as f64 * (1.0 - (-4.0 * share).exp()),
            n_eff: 20.0 + 20.0 * noise(i, 4.0),
            landmarks_seen: covered.then_some(log.landmarks.len()),
            ..ScanRecord::at(scan.t_s, pose)
        }
    });
    let map = log.landmarks.iter().enumerate().map(|(i, landmark)| {
        let at = [0, 1].map(|k| landmark[k] + 0.4 * error * noise(i, 5.0 + k as f64));
        feature(at, 0.4 * error * (1.2 + noise(i, 7.0)), 0.55 + 0.45 * noise(i, 8.0))
    });
    Record { scans: scans.collect(), map: map.collect() }
}

/// Pose on a circle of 10 m, 300 scans a turn.
fn circle(index: usize) -> [f64; 3] {
    let angle = TAU * index as f64 / 300.0;
    [10.0 * angle.sin(), 10.0 - 10.0 * angle.cos(), angle]
}

/// One turn on the circle, with truth at all scans.
fn circle_log() -> Log {
    let mut log = empty_log();
    log.name = "circle".into();
    for i in 0..=300 {
        let t_s = 0.2 * i as f64;
        let pose = circle(i);
        log.scans.push(Scan { t_s, detections: vec![], ..Scan::default() });
        log.truth.push(TruePose { t_s, position: [pose[0], pose[1]], heading_rad: Some(pose[2]) });
    }
    log.landmarks = (0..20)
        .map(|i| {
            let angle = TAU * i as f64 / 20.0;
            let radius = 10.0 + 4.0 * noise(i, 0.0);
            [radius * angle.sin(), 10.0 - radius * angle.cos()]
        })
        .collect();
    log
}

/// Pose on a winding trajectory of about 4 km, 7000 scans.
fn way(index: usize) -> [f64; 3] {
    let angle = 3.0 * TAU * index as f64 / 7000.0;
    let [x, y] =
        [200.0 * angle.cos() + 40.0 * (2.3 * angle).cos() - 240.0, 120.0 * angle.sin() + 50.0 * (1.7 * angle).sin()];
    [x, y, angle + PI / 2.0]
}

/// A long drive whose truth has several gaps, a third of it altogether.
fn long_log() -> Log {
    let mut log = empty_log();
    log.name = "long drive".into();
    for i in 0..7000 {
        let t_s = 1.0e9 + 0.2 * i as f64;
        let pose = way(i);
        log.scans.push(Scan { t_s, detections: vec![], ..Scan::default() });
        if i % 1500 < 1000 {
            log.truth.push(TruePose { t_s, position: [pose[0], pose[1]], heading_rad: Some(pose[2]) });
        }
    }
    log.landmarks = (0..300)
        .map(|i| {
            let pose = way(i * 23);
            [pose[0] + 25.0 * noise(i, 9.0), pose[1] + 25.0 * noise(i, 10.0)]
        })
        .collect();
    log
}

/// The folder for figures: a temporary one unless the environment names one.
fn with_folder(name: &str, check: impl FnOnce(&Path)) {
    match std::env::var_os("SCPHD_PLOTS") {
        Some(dir) => check(&Path::new(&dir).join(name)),
        None => check(&Folder::new(name).0),
    }
}

/// The PNG, after checking that it has the usual width, is opaque, and neither blank nor full.
fn decoded(path: &Path) -> Pixmap {
    let pixels = Pixmap::decode_png(&fs::read(path).unwrap()).unwrap();
    assert_eq!(f64::from(pixels.width()), figure::WIDTH_PX);
    assert!((300..2000).contains(&pixels.height()));
    assert!(pixels.pixels().iter().all(|p| p.alpha() == 255));
    let inked = pixels.pixels().iter().filter(|p| p.green() < 128).count();
    let all = pixels.pixels().len();
    assert!(inked > 1000 && inked < all / 3, "{inked} of {all}");
    pixels
}

/// Widths and heights of the curves of an SVG in the colour `stroke`, px.
fn extents(svg: &str, stroke: Colour) -> Vec<[f64; 2]> {
    let mut extents = Vec::new();
    for event in svg::read(svg).unwrap() {
        let Event::Tag("path", _, attributes) = event else {
            continue;
        };
        if attributes.get("stroke").map(|v| v.to_string()) != Some(stroke.to_string()) {
            continue;
        }
        let mut ends = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for command in Data::parse(&attributes["d"]).unwrap().iter() {
            if let Command::Move(_, p) | Command::Line(_, p) = command {
                for (axis, value) in p.iter().enumerate() {
                    let end = &mut ends[axis % 2];
                    *end = [end[0].min(f64::from(*value)), end[1].max(f64::from(*value))];
                }
            }
        }
        extents.push(ends.map(|end| end[1] - end[0]));
    }
    extents
}

#[test]
fn a_circle_with_two_filters() {
    let log = circle_log();
    let f32_run = record(&log, circle, 0.5, 4.0);
    let mut f64_run = record(&log, circle, 0.45, 4.0);
    f64_run.map.truncate(15);
    let runs = [("filter f32", &f32_run), ("reference f64", &f64_run)];
    with_folder("circle", |dir| {
        let paths = write_plots::<Planar>(dir, &log, &runs).unwrap();
        let names: Vec<_> = paths.iter().map(|p| p.file_name().unwrap()).collect();
        assert_eq!(names, ["trajectory.svg", "trajectory.png", "error.svg", "error.png"]);
        assert_eq!(fs::read_dir(dir).unwrap().count(), 4, "nothing else is left");
        for png in [&paths[1], &paths[3]] {
            decoded(png);
        }
        let trajectory = fs::read_to_string(&paths[0]).unwrap();
        for text in [
            "circle: trajectory and map",
            "truth",
            "dead reckoning",
            "filter f32",
            "reference f64: features, 95 %",
            "filter f32: pose at times, 95 %",
            "true landmarks",
            "x (m)",
        ] {
            assert!(trajectory.contains(text), "{text}");
        }
        let error = fs::read_to_string(&paths[2]).unwrap();
        for text in [
            "position error (m)", "heading error (deg)", "filter f32: ±2σ", "features N̂",
            "true landmarks in view so far", "N_eff",
        ] {
            assert!(error.contains(text), "{text}");
        }

        // The true circle is the only large black curve, and it is round.
        let curves = extents(&trajectory, Colour::TRUTH);
        let round: Vec<_> = curves.iter().filter(|e| e[1] > 100.0).collect();
        assert_eq!(round.len(), 1);
        assert!((round[0][0] - round[0][1]).abs() < 0.2, "{round:?}");
        // Features, poses at seventeen times, and one of each in the legends.
        assert_eq!(trajectory.matches("<ellipse").count(), 20 + 15 + 2 * 17 + 4);
    });
}

#[test]
fn equal_bytes_for_equal_runs() {
    let log = circle_log();
    let run = record(&log, circle, 0.5, 4.0);
    let read = |name| {
        let folder = Folder::new(name);
        let paths = write_plots::<Planar>(&folder.0, &log, &[("f32", &run)]).unwrap();
        paths.iter().map(|p| fs::read(p).unwrap()).collect::<Vec<_>>()
    };
    assert!(read("equal-1") == read("equal-2"));
}

#[test]
fn a_long_drive_with_gaps_and_large_drift() {
    let log = long_log();
    let run = record(&log, way, 3.0, 2000.0);
    with_folder("long", |dir| {
        let paths = write_plots::<Planar>(dir, &log, &[("filter f32", &run)]).unwrap();
        decoded(&paths[1]);
        decoded(&paths[3]);
        let trajectory = fs::read_to_string(&paths[0]).unwrap();
        assert!(trajectory.len() < 400_000, "{}", trajectory.len());
        let truth = extents(&trajectory, Colour::TRUTH);
        let widest = truth.iter().map(|e| e[0]).fold(0.0, f64::max);
        assert!(widest > 500.0, "dead reckoning does not shrink the rest: {widest}");
        let error = fs::read_to_string(&paths[2]).unwrap();
        assert!(error.contains("dead reckoning (up to "), "its reach is told");
        assert!(!error.contains("in view so far"), "unknown over gaps");
        assert!(error.len() < 1_500_000, "{}", error.len());
    });
}

#[test]
fn nearly_empty_runs() {
    let log = empty_log();
    let empty = Record { scans: vec![], map: vec![] };
    let mut one_log = empty_log();
    one_log.scans.push(Scan { t_s: 3.0, detections: vec![], ..Scan::default() });
    let one = record(&one_log, |_| [0.0; 3], 1.0, 0.0);
    let mut broken = one.clone();
    broken.scans[0].pose = [f64::NAN; 3];
    broken.scans[0].pose_covariance = [[f64::NEG_INFINITY; 3]; 3];
    broken.scans[0].dead_reckoning = [f64::INFINITY; 3];
    broken.map = vec![
        feature([f64::NAN, 0.0], 1.0, 1.0),
        feature([0.0, 0.0], 1e200, 1.0),
        feature([0.0, 0.0], 0.0, f64::NAN),
        feature([0.0, 0.0], 1e9, -1.0),
    ];
    type Case<'a> = (&'a str, &'a Log, Vec<(&'a str, &'a Record)>);
    let mut far = broken.clone();
    far.scans[0].pose = [1e308, -1e308, 0.0];
    far.scans[0].dead_reckoning = [-1e299, 1e299, 0.0];
    let cases: [Case<'_>; 5] = [
        ("no-run", &log, vec![]),
        ("empty-run", &log, vec![("filter f32", &empty)]),
        ("one-scan", &one_log, vec![("filter <f32> & co", &one)]),
        ("not-finite", &one_log, vec![("filter f32", &broken)]),
        ("far", &one_log, vec![("filter f32", &far)]),
    ];
    for (name, log, runs) in cases {
        with_folder(name, |dir| {
            let paths = write_plots::<Planar>(dir, log, &runs).unwrap();
            decoded(&paths[1]);
            decoded(&paths[3]);
        });
    }
}

#[test]
fn a_folder_that_cannot_be_created_is_an_error() {
    let folder = Folder::new("plot-error");
    let file = folder.0.join("file");
    fs::write(&file, "").unwrap();
    let error = write_plots::<Planar>(&file.join("sub"), &empty_log(), &[]).unwrap_err();
    assert!(matches!(error, PlotError::Io { .. }), "{error}");
}
