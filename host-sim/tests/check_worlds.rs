//! Findings of the check in simulated worlds with damage by loggers, receivers and vehicles, and none in the same worlds without
//! damage.
//!
//! Thresholds were chosen on the worlds 300 to 319 and the recorded logs.

use libm::{atan2, cos, hypot, sin};
use scphd_check as check;
use scphd_check::Severity;
use scphd_log::angle::wrap;
use scphd_log::dimensions::Planar;
use scphd_log::log::{Fix, FixNoise, Log, Odometry, PoseFix, Scan, TruePose, Vehicle};
use scphd_log::noise::Noise;
use scphd_log::{log_folder, truth};
use scphd_worlds::scenario;
use std::f64::consts::{FRAC_PI_2, PI};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

const SEEDS: std::ops::Range<u64> = 900_100..900_108;

fn world(seed: u64) -> Log {
    scenario::by_name("worlds", seed).unwrap()
}

/// The codes of the warnings.
fn found(log: &Log) -> Vec<&'static str> {
    let (_, findings) = check::log_of::<Planar>(log);
    findings.iter().filter(|one| one.severity > Severity::Note).map(|one| one.code).collect()
}

fn end_s(log: &Log) -> f64 {
    log.scans.last().unwrap().t_s
}

/// A drive of a world, the same backwards, and forwards again, with different noise.
fn there_and_back(seed: u64) -> Log {
    let (mut log, mut noise) = (world(seed), Noise::new(seed));
    let turn_s = 0.4 * end_s(&log);
    let rows: Vec<Odometry> = log.odometry.iter().filter(|row| row.t_s <= turn_s).copied().collect();
    let scans: Vec<Scan> = log.scans.iter().filter(|scan| scan.t_s < turn_s).cloned().collect();
    let steers = matches!(log.vehicle, Vehicle::Ackermann { .. });
    let back = (0..rows.len()).rev().map(|row| {
        let until_s = rows.get(row + 1).map_or(turn_s, |next| next.t_s);
        let [speed, turn, _] = rows[row].control;
        Odometry { t_s: 2.0 * turn_s - until_s, control: [-speed, if steers { turn } else { -turn }, 0.0] }
    });
    let again = rows.iter().map(|row| Odometry { t_s: row.t_s + 2.0 * turn_s, ..*row });
    log.odometry = rows.iter().copied().chain(back).chain(again).collect();
    let [range_sigma, bearing_sigma] = [log.nominal.range_sigma_m.unwrap(), log.nominal.bearing_sigma_rad.unwrap()];
    let mut at = |scan: &Scan, t_s: f64| {
        let moved = |[range, bearing]: &[f64; 2]| {
            [range + 0.3 * range_sigma * noise.normal(), wrap(bearing + 0.3 * bearing_sigma * noise.normal())]
        };
        Scan { t_s, detections: scan.detections.iter().map(moved).collect(), ..scan.clone() }
    };
    let back: Vec<Scan> = scans.iter().rev().map(|scan| at(scan, 2.0 * turn_s - scan.t_s)).collect();
    let again: Vec<Scan> = scans.iter().skip(1).map(|scan| at(scan, scan.t_s + 2.0 * turn_s)).collect();
    log.scans = scans.into_iter().chain(back).chain(again).collect();
    log.truth.clear();
    log
}

/// Positions and headings of the truth, with noise, every second.
fn with_fixes(seed: u64, positions: bool, heading: Option<fn(f64) -> f64>) -> Log {
    let (mut log, mut noise) = (world(seed), Noise::new(seed));
    let sigma_m = 0.02 * log.sensor.range_max_m;
    log.fix_noise = FixNoise { position_sigma_m: Some(sigma_m), heading_sigma_rad: Some(0.03), ..FixNoise::default() };
    for second in 1..end_s(&log) as u32 {
        let t_s = f64::from(second);
        let pose = truth::at(&log.truth, t_s).unwrap();
        let measured = pose.position.map(|one| one + sigma_m * noise.normal());
        let turned = pose.heading_rad.unwrap() + 0.03 * noise.normal();
        if positions {
            log.fixes.push(Fix { t_s, measured: PoseFix::Position(measured) });
        }
        if let Some(heading) = heading {
            log.fixes.push(Fix { t_s, measured: PoseFix::Heading(wrap(heading(turned))) });
        }
    }
    log
}

fn set_truth(log: &mut Log, from_s: f64, lasts_s: f64, row: impl Fn(&mut TruePose)) {
    log.truth.iter_mut().filter(|one| (from_s..from_s + lasts_s).contains(&one.t_s)).for_each(row);
}

fn in_own_body(log: &mut Log, seed: u64) -> [[f64; 2]; 2] {
    let mut noise = Noise::new(seed);
    let [range_sigma, bearing_sigma] = [log.nominal.range_sigma_m.unwrap(), log.nominal.bearing_sigma_rad.unwrap()];
    let parts = [[0.15 * log.sensor.range_max_m, 0.9], [0.2 * log.sensor.range_max_m, -0.7]];
    for scan in &mut log.scans {
        for [range, bearing] in parts {
            if noise.happens(0.9) {
                let seen = [range + 0.5 * range_sigma * noise.normal(), bearing + 0.5 * bearing_sigma * noise.normal()];
                scan.detections.push(seen);
                scan.labels.push(-1);
            }
        }
    }
    parts
}

#[test]
fn undamaged_worlds_have_no_findings() {
    for seed in SEEDS {
        for name in ["worlds", "worlds-exact", "worlds-mounted", "worlds-moving"] {
            let mut log = scenario::by_name(name, seed).unwrap();
            assert_eq!(found(&log), [""; 0], "{name} {seed}");
            log.truth.clear();
            assert_eq!(found(&log), [""; 0], "{name} {seed} without truth");
        }
        assert_eq!(found(&there_and_back(seed)), [""; 0], "reversing, {seed}");
        assert_eq!(found(&with_fixes(seed, true, Some(|heading| heading))), [""; 0], "fixes, {seed}");
        assert_eq!(found(&with_fixes(seed, false, Some(|heading| heading))), [""; 0], "headings, {seed}");
        // The positions begin late, when odometry has drifted.
        let mut late = with_fixes(seed, true, None);
        late.fixes.retain(|fix| fix.t_s > 25.0);
        assert_eq!(found(&late), [""; 0], "late fixes, {seed}");
    }
}

/// Offset of the turn rate of a robot with 30 cm between wheels that differ in size by 2 %.
#[test]
fn an_offset_of_the_turn_rate_is_a_note_and_not_a_wrong_unit() {
    for seed in SEEDS {
        for offset in [0.03, -0.05] {
            let mut log = world(seed);
            let scale = if matches!(log.vehicle, Vehicle::Ackermann { .. }) { 0.3 } else { 1.0 };
            log.odometry.iter_mut().for_each(|row| row.control[1] += scale * offset);
            log.truth.clear();
            assert_eq!(found(&log), [""; 0], "{seed} {offset}");
        }
    }
}

/// The world with this seed, in which the vehicle pauses for 20 s at a scan. `turn_rate` is that of the odometry at a time of the
/// pause, s, and `seen` are the detections then, for the true pose before the pause.
fn pausing(seed: u64, turn_rate: impl Fn(f64) -> f64, seen: impl Fn(&Log, [f64; 3], f64) -> Vec<[f64; 2]>) -> Log {
    const PAUSE_S: f64 = 20.0;
    let mut log = world(seed);
    let from_s = log.scans[log.scans.len() / 2].t_s;
    let pose = truth::at(&log.truth, from_s).unwrap();
    let pose = [pose.position[0], pose.position[1], pose.heading_rad.unwrap()];
    let held = log.odometry.iter().rfind(|row| row.t_s <= from_s).unwrap().control;
    let times = |step_s: f64| (0..(PAUSE_S / step_s) as usize).map(move |place| place as f64 * step_s);
    let rows = times(0.1).map(|after_s| Odometry { t_s: from_s + after_s, control: [0.0, turn_rate(after_s), 0.0] });
    let rows: Vec<_> = rows.chain([Odometry { t_s: from_s + PAUSE_S, control: held }]).collect();
    let scans = times(0.2).skip(1).map(|after_s| {
        let detections = seen(&log, pose, after_s);
        Scan { t_s: from_s + after_s, sensor: 0, labels: vec![-1; detections.len()], detections }
    });
    let scans: Vec<_> = scans.collect();
    log.odometry.iter_mut().filter(|row| row.t_s > from_s).for_each(|row| row.t_s += PAUSE_S);
    log.scans.iter_mut().filter(|scan| scan.t_s > from_s).for_each(|scan| scan.t_s += PAUSE_S);
    log.odometry.extend(rows);
    log.scans.extend(scans);
    log.odometry.retain(|row| row.t_s != from_s || row.control[0] == 0.0);
    log.odometry.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    log.scans.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    log.truth.clear();
    log
}

#[test]
fn a_moving_object_before_a_standing_vehicle_is_not_odometry_that_stands() {
    for seed in SEEDS {
        // A second for a third of the range, to and fro.
        let range = |after_s: f64| 0.3 + 0.4 * (after_s / 2.4 - (after_s / 2.4).floor() - 0.5).abs() * 2.0;
        let log = pausing(seed, |_| 0.0, |log, _, after_s| vec![[range(after_s) * log.sensor.range_max_m, 0.1]]);
        assert_eq!(found(&log), [""; 0], "{seed}");
    }
}

#[test]
fn a_turn_on_the_spot_by_more_than_odometry_says_is_not_odometry_that_stands() {
    // To the left and back, twice; by 0.1 rad more in the 1.6 s between compared scans.
    let is_left = |after_s: f64| after_s % 10.0 < 5.0;
    let turn_rate = |after_s: f64| if is_left(after_s) { 0.4 } else { -0.4 };
    let turned = |after_s: f64| (0.4 + 0.1 / 1.6) * if is_left(after_s) { after_s % 5.0 } else { 5.0 - after_s % 5.0 };
    let seen = |log: &Log, [x, y, heading]: [f64; 3], after_s: f64| {
        let heading = heading + turned(after_s);
        let detection = |place: &[f64; 2]| {
            let [x, y] = [place[0] - x, place[1] - y];
            [hypot(x, y), wrap(atan2(y, x) - heading)]
        };
        let all = log.landmarks.iter().map(detection);
        all.filter(|&[range, bearing]| log.sensor.sees(range, bearing)).collect()
    };
    let can_turn = |seed: &u64| matches!(world(*seed).vehicle, Vehicle::Unicycle | Vehicle::UnicycleArc);
    for seed in SEEDS.filter(can_turn) {
        assert_eq!(found(&pausing(seed, turn_rate, seen)), [""; 0], "{seed}");
    }
}

/// A log, its damage with a seed, and the only finding that it must have.
type Damage = (&'static str, fn(u64) -> Log, fn(&mut Log, u64), &'static str);

#[test]
fn every_damage_of_a_world_has_its_finding_and_no_other() {
    let whole: fn(&mut Log, u64) = |_, _| {};
    let cases: [Damage; 27] = [
        ("parts of the vehicle in view", world, |log, seed| _ = in_own_body(log, seed), "fixed-in-view"),
        (
            "speed without a sign",
            there_and_back,
            |log, _| log.odometry.iter_mut().for_each(|row| row.control[0] = row.control[0].abs()),
            "speed-unsigned",
        ),
        (
            "30 s of empty scans",
            world,
            |log, _| {
                let from_s = 0.4 * end_s(log);
                for scan in log.scans.iter_mut().filter(|scan| (from_s..from_s + 30.0).contains(&scan.t_s)) {
                    scan.detections.clear();
                    scan.labels.clear();
                }
            },
            "scans-empty",
        ),
        (
            "odometry that stands",
            world,
            |log, _| standing(log, 0.4, 12.0, |row| row.control = [0.0; 3]),
            "odometry-stands",
        ),
        (
            "wheels that are not read beside a gyroscope that is",
            world,
            |log, _| standing(log, 0.4, 20.0, |row| row.control[0] = 0.0),
            "odometry-stands",
        ),
        (
            "odometry that always stands",
            world,
            |log, _| standing(log, 0.0, f64::INFINITY, |row| row.control = [0.0; 3]),
            "odometry-stands",
        ),
        (
            "detections in the frame of the map",
            world,
            |log, _| {
                for scan in &mut log.scans {
                    let Some(pose) = truth::at(&log.truth, scan.t_s) else { continue };
                    let ([x, y], heading) = (pose.position, pose.heading_rad.unwrap());
                    for seen in &mut scan.detections {
                        let angle = heading + seen[1];
                        let place = [x + seen[0] * cos(angle), y + seen[0] * sin(angle)];
                        *seen = [hypot(place[0], place[1]), atan2(place[1], place[0])];
                    }
                }
                // The view is enlarged so that all detections are in it.
                log.sensor.range_max_m *= 4.0;
                (log.sensor.bearing_min_rad, log.sensor.bearing_max_rad) = (-PI, PI);
            },
            "detection-frame",
        ),
        ("no return as the greatest range", world, |log, seed| no_return(log, seed, 4, |_| 0.998), "no-return"),
        (
            "no return as one of three ranges",
            world,
            |log, seed| no_return(log, seed, 3, |place| 0.997 + 0.001 * (place % 3) as f64),
            "no-return",
        ),
        ("zero rows at the start of the truth", world, |log, _| set_truth(log, 0.0, 12.0, ZEROS), "truth-jumps"),
        (
            "truth that stands still and jumps",
            world,
            |log, _| {
                let from_s = 0.4 * end_s(log);
                let held = truth::at(&log.truth, from_s).unwrap();
                set_truth(log, from_s, 15.0, |row| (row.position, row.heading_rad) = (held.position, held.heading_rad));
            },
            "truth-jumps",
        ),
        (
            "truth that is elsewhere for 10 s",
            world,
            |log, _| {
                let (from_s, off_m) = (0.4 * end_s(log), 0.5 * log.sensor.range_max_m);
                set_truth(log, from_s, 10.0, |row| row.position[0] += off_m);
            },
            "truth-jumps",
        ),
        ("truth as of a compass", world, |log, _| headed(log, |heading| FRAC_PI_2 - heading), "truth-heading"),
        ("truth clockwise", world, |log, _| headed(log, |heading| -heading), "truth-heading"),
        ("truth from another axis", world, |log, _| headed(log, |heading| heading + FRAC_PI_2), "truth-heading"),
        ("truth with a declination", world, |log, _| headed(log, |heading| heading - 0.2), "truth-heading"),
        ("headings of a compass", |s| with_fixes(s, false, Some(|heading| FRAC_PI_2 - heading)), whole, "fix-heading"),
        ("headings clockwise", |s| with_fixes(s, false, Some(|heading| -heading)), whole, "fix-heading"),
        (
            "headings from another axis",
            |s| with_fixes(s, false, Some(|heading| heading - FRAC_PI_2)),
            whole,
            "fix-heading",
        ),
        ("headings with a declination", |s| with_fixes(s, false, Some(|heading| heading + 0.25)), whole, "fix-heading"),
        ("positions and a compass", |s| with_fixes(s, true, Some(|heading| FRAC_PI_2 - heading)), whole, "fix-heading"),
        ("positions and a declination", |s| with_fixes(s, true, Some(|heading| heading + 0.2)), whole, "fix-heading"),
        ("positions elsewhere for 12 s", placed, |log, _| elsewhere(log, 0.4 * end_s(log), 0.6), "fix-jump"),
        ("positions elsewhere for the last 12 s", placed, |log, _| elsewhere(log, end_s(log) - 12.0, 0.4), "fix-jump"),
        ("the start turned round, with positions", placed, |log, _| turned(log, PI), "start-heading"),
        ("the start turned, with positions", placed, |log, _| turned(log, -0.8), "start-heading"),
        (
            "two vehicles in turn",
            world,
            |log, seed| {
                let other = world(seed + 1000);
                let scale = log.sensor.range_max_m / other.sensor.range_max_m;
                let [least, most] = [log.sensor.bearing_min_rad, log.sensor.bearing_max_rad];
                let seen = |[range, bearing]: &[f64; 2]| [scale * range, bearing.clamp(least, most)];
                log.scans.extend(other.scans.iter().map(|scan| Scan {
                    t_s: scan.t_s + 0.013,
                    detections: scan.detections.iter().map(seen).collect(),
                    ..Scan::default()
                }));
                log.scans.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
                let end_s = log.odometry.last().unwrap().t_s;
                log.scans.retain(|scan| scan.t_s <= end_s);
                log.truth.clear();
            },
            "scans-mixed",
        ),
    ];
    let mut missed = Vec::new();
    for seed in SEEDS {
        // Then the initial position is wrong, too.
        let mut log = placed(seed);
        elsewhere(&mut log, 0.0, 0.4);
        let found = found(&log);
        if !found.contains(&"fix-jump") {
            missed.push(format!("positions elsewhere for the first 12 s, {seed}: {found:?}"));
        }
    }
    for (place, (name, log, damage, code)) in cases.into_iter().enumerate() {
        // Each damage in every third world.
        for seed in SEEDS.skip(place % 3).step_by(3) {
            let mut log = log(seed);
            damage(&mut log, seed);
            let found = found(&log);
            if found != [code] {
                missed.push(format!("{name}, {seed}: {found:?}"));
            }
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

const ZEROS: fn(&mut TruePose) = |row| (row.position, row.heading_rad) = ([0.0; 2], Some(0.0));

/// Positions every second.
fn placed(seed: u64) -> Log {
    with_fixes(seed, true, None)
}

/// Changes the rows of the odometry from a share of the log on, without truth.
fn standing(log: &mut Log, share: f64, lasts_s: f64, change: impl Fn(&mut Odometry)) {
    let from_s = share * end_s(log);
    log.odometry.iter_mut().filter(|row| (from_s..from_s + lasts_s).contains(&row.t_s)).for_each(change);
    log.truth.clear();
}

/// Adds detections at these shares of the greatest range to every scan.
fn no_return(log: &mut Log, seed: u64, count: usize, share: impl Fn(usize) -> f64) {
    let mut noise = Noise::new(seed);
    let [least, most] = [log.sensor.bearing_min_rad, log.sensor.bearing_max_rad];
    for (place, scan) in log.scans.iter_mut().enumerate() {
        for _ in 0..count {
            scan.detections.push([share(place) * log.sensor.range_max_m, noise.between(least, most)]);
            scan.labels.push(-1);
        }
    }
}

/// Positions with an offset for 12 s.
fn elsewhere(log: &mut Log, from_s: f64, off: f64) {
    let off_m = off * log.sensor.range_max_m;
    for fix in log.fixes.iter_mut().filter(|fix| (from_s..=from_s + 12.0).contains(&fix.t_s)) {
        if let PoseFix::Position(position) = &mut fix.measured {
            position[1] += off_m;
        }
    }
}

fn headed(log: &mut Log, heading: fn(f64) -> f64) {
    log.truth.iter_mut().for_each(|row| row.heading_rad = row.heading_rad.map(|right| wrap(heading(right))));
}

fn turned(log: &mut Log, by_rad: f64) {
    log.initial_pose[2] = wrap(log.initial_pose[2] + by_rad);
    log.truth.clear();
}

/// A world whose vehicle moves to the right of its heading by this angle.
fn drifting(seed: u64, by_rad: f64) -> Log {
    let mut log = world(seed);
    log.initial_pose[2] = wrap(log.initial_pose[2] + by_rad);
    log.truth.iter_mut().for_each(|row| row.heading_rad = row.heading_rad.map(|heading| wrap(heading + by_rad)));
    log.scans
        .iter_mut()
        .flat_map(|scan| &mut scan.detections)
        .for_each(|[_, bearing]| *bearing = wrap(*bearing - by_rad));
    log.sensor.bearing_min_rad = (log.sensor.bearing_min_rad - by_rad).max(-PI);
    log
}

#[test]
fn a_unicycle_that_moves_sideways_is_reported() {
    let is_unicycle = |seed: &u64| !matches!(world(*seed).vehicle, Vehicle::Ackermann { .. });
    let seeds: Vec<u64> = (SEEDS.start..SEEDS.start + 20).filter(is_unicycle).collect();
    assert!(seeds.len() > 4, "{seeds:?}");
    for seed in seeds {
        assert_eq!(found(&drifting(seed, 0.09)), ["sideways"], "{seed}");
        assert_eq!(found(&drifting(seed, 0.01)), [""; 0], "{seed}");
        // The odometry has the motion to the side.
        let mut log = drifting(seed, 0.09);
        log.vehicle = Vehicle::Holonomic;
        log.odometry.iter_mut().for_each(|row| row.control[2] = -0.09 * row.control[0]);
        assert_eq!(found(&log), [""; 0], "holonomic, {seed}");
    }
}

/// Findings about a vehicle ahead and about a carried vehicle depend on the number of landmarks: they are required in most
/// worlds.
#[test]
fn vehicles_ahead_and_carried_vehicles_are_found_in_most_worlds() {
    let (mut ahead, mut carried) = (0, 0);
    for seed in SEEDS {
        let (mut log, mut noise) = (world(seed), Noise::new(seed));
        let range_m = 0.4 * log.sensor.range_max_m;
        let [range_sigma, bearing_sigma] = [log.nominal.range_sigma_m.unwrap(), log.nominal.bearing_sigma_rad.unwrap()];
        for scan in &mut log.scans {
            let (range, bearing) = (range_m * (1.0 + 0.15 * sin(0.2 * scan.t_s)), 0.2 * sin(0.15 * scan.t_s));
            scan.detections.push([range + range_sigma * noise.normal(), bearing + bearing_sigma * noise.normal()]);
            scan.labels.push(-1);
        }
        ahead += usize::from(found(&log) == ["moves-along"]);
        // As if the logger had been off while the vehicle was carried.
        let mut log = world(seed);
        let (from_s, lasts_s) = (0.4 * end_s(&log), 15.0);
        let at = |t_s: f64| match t_s {
            _ if t_s < from_s => Some(t_s),
            _ if t_s > from_s + lasts_s => Some(t_s - lasts_s),
            _ => None,
        };
        log.odometry = log.odometry.iter().filter_map(|row| Some(Odometry { t_s: at(row.t_s)?, ..*row })).collect();
        log.scans = log.scans.iter().filter_map(|scan| Some(Scan { t_s: at(scan.t_s)?, ..scan.clone() })).collect();
        log.truth.clear();
        carried += usize::from(found(&log) == ["carried-away"]);
    }
    assert!(ahead >= 6 && carried >= 6, "{ahead} {carried}");
}

fn run(dir: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_scphd-sim")).args(args).current_dir(dir).output().unwrap()
}

/// Position RMSE, m, of a replay, and its output on stderr.
fn replayed(dir: &Path, filter: &str) -> (f64, String) {
    let output = run(dir, &["replay", "log", "--filter", filter, "--json", "-"]);
    assert!(output.status.success(), "{output:?}");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    (json["position_rmse_m"].as_f64().unwrap(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn the_proposed_exclusions_leave_out_the_vehicle_and_missing_returns() {
    let place = TempDir::new().unwrap();
    let dir = place.path().join("log");
    let mut log = world(900_102);
    let clean = log.scans.clone();
    let [one, other] = in_own_body(&mut log, 1);
    let none_m = 0.998 * log.sensor.range_max_m;
    log.scans[3].detections.push([none_m, 0.1]);
    log.scans[3].labels.push(-1);
    log_folder::write(&log, &dir).unwrap();
    let head = fs::read_to_string(dir.join("log.toml")).unwrap();
    let zone = |[range, bearing]: [f64; 2]| {
        format!(
            "[[sensor.exclude]]\nrange_min_m = {:?}\nrange_max_m = {:?}\nbearing_min_rad = {:?}\nbearing_max_rad = {:?}\n",
            range - 0.03 * log.sensor.range_max_m,
            range + 0.03 * log.sensor.range_max_m,
            bearing - 0.08,
            bearing + 0.08
        )
    };
    let (section, key) = ("[sensor]\n", format!("[sensor]\nno_return_m = {none_m:?}\n"));
    assert!(head.contains(section), "{head}");
    let head = format!("{}\n{}{}", head.replace(section, &key), zone(one), zone(other));
    fs::write(dir.join("log.toml"), &head).unwrap();
    let read = log_folder::read(&dir).unwrap();
    assert_eq!(read.sensor, log.sensor);
    let count = |scans: &[Scan]| scans.iter().map(|scan| scan.detections.len()).sum::<usize>();
    let (all, left) = (count(&clean), count(&read.scans));
    // Nearly all other detections remain, with their labels.
    assert!(left <= all + 10 && left as f64 > 0.95 * all as f64, "{left} {all}");
    assert!(read.scans.iter().all(|scan| scan.labels.len() == scan.detections.len()));
    assert_eq!(found(&read), [""; 0]);
    // A head without a folder has no detections that could be left out.
    let refused = log_folder::of_head(&head).unwrap_err().to_string();
    assert_eq!(
        refused,
        "log.toml, key sensor.exclude: detections are left out when a folder is read: write the key into its log.toml"
    );
    // A zone of all ranges at an edge of the view is removed from the view.
    let edge = format!("{head}[[sensor.exclude]]\nbearing_max_rad = {:?}\n", read.sensor.bearing_min_rad + 0.3);
    fs::write(dir.join("log.toml"), edge).unwrap();
    let narrow = log_folder::read(&dir).unwrap();
    assert!((narrow.sensor.bearing_min_rad - read.sensor.bearing_min_rad - 0.3).abs() < 1e-12);
}

#[test]
fn a_replay_leaves_out_vehicle_parts_and_false_truth_and_corrects_the_start() {
    // Parts of the vehicle are not mapped.
    for seed in [900_102, 900_106] {
        let place = TempDir::new().unwrap();
        let dir = place.path().join("log");
        let mut log = world(seed);
        log_folder::write(&log, &dir).unwrap();
        let (clean_m, _) = replayed(place.path(), "joint");
        fs::remove_dir_all(&dir).unwrap();
        in_own_body(&mut log, seed);
        log_folder::write(&log, &dir).unwrap();
        let (rmse_m, said) = replayed(place.path(), "joint");
        assert!(rmse_m < 1.3 * clean_m, "{seed}: {rmse_m} {clean_m}");
        assert!(said.contains("of what stands still in the view are left out"), "{said}");
    }

    let place = TempDir::new().unwrap();
    let mut log = world(900_103);
    set_truth(&mut log, 60.0, 15.0, ZEROS);
    log_folder::write(&log, &place.path().join("log")).unwrap();
    let (rmse_m, said) = replayed(place.path(), "ekf");
    assert!(rmse_m < 0.05 * log.sensor.range_max_m, "{rmse_m}");
    assert!(said.contains("rows are not scored [truth-jumps]"), "{said}");

    let place = TempDir::new().unwrap();
    let mut log = with_fixes(900_104, true, None);
    log.initial_pose[2] = wrap(log.initial_pose[2] + PI);
    log_folder::write(&log, &place.path().join("log")).unwrap();
    let (rmse_m, said) = replayed(place.path(), "ekf");
    assert!(rmse_m < 0.05 * log.sensor.range_max_m, "{rmse_m}");
    assert!(said.contains("by the first positions of fixes.csv") && said.contains("[start-heading]"), "{said}");
}

#[test]
fn all_errors_are_reported_at_once() {
    let place = TempDir::new().unwrap();
    let dir = place.path().join("log");
    log_folder::write(&world(900_105), &dir).unwrap();
    let change = |file: &str, change: &dyn Fn(&str) -> String| {
        let text = fs::read_to_string(dir.join(file)).unwrap();
        fs::write(dir.join(file), change(&text)).unwrap();
    };
    change("log.toml", &|text| {
        let at = text.find("initial_pose = ").unwrap();
        let end = at + text[at..].find('\n').unwrap();
        format!("kind = \"real: of a yard\"\n{}initial_pose = [0.0, 0.0, 6.29]{}", &text[..at], &text[end..])
            .replace("simulated = false\n", "")
            .replace("[vehicle]\n", "[vehicle]\nsensor_forwards_m = 1.0\n")
            .replace("[sensor]\n", "[sensor]\nrange_sigma = 1.0\n")
    });
    // Decimal commas, and Windows line ends.
    change("truth.csv", &|text| {
        let row = |(line, text): (usize, &str)| if line == 7 { text.replace('.', ",") } else { text.to_owned() };
        text.lines().enumerate().map(|line| row(line) + "\r\n").collect()
    });
    let report = check::folder(&dir);
    let told: Vec<String> = report.findings.iter().map(|one| format!("{}: {}", one.place, one.what)).collect();
    for part in [
        "log.toml, key vehicle.sensor_forwards_m: unknown",
        "log.toml, key sensor.range_sigma: unknown",
        "log.toml, key initial_pose: 6.29, expected -6.2842 to 6.2842: angles are in radians, take whole turns off",
        "truth.csv, row 8: wrong number of fields: 8, the header has 4: commas in numbers?",
    ] {
        assert!(told.iter().any(|one| one.starts_with(part)), "{part}: {told:#?}");
    }
    assert!(told.iter().all(|one| !one.contains("kind")), "{told:#?}");
    let checked = String::from_utf8(run(place.path(), &["check", "log"]).stdout).unwrap();
    assert!(checked.starts_with("log\n"), "{checked}");
    let replay = String::from_utf8(run(place.path(), &["replay", "log"]).stderr).unwrap();
    assert!(replay.contains("; and 3 more, which scphd-sim check log names"), "{replay}");
}
