//! Whether odometry and scans tell the same motion, without any truth.
//!
//! Detections of one scan, carried along by the odometry, should fall on detections of a later one. If they do so far more often when
//! one thing is read in another way (mirrored bearings, turn rates as degrees, speeds as km/h, ranges as mm), that is probably what the log
//! means.

use super::finding::{Findings, percent};
use crate::angle::wrap;
use crate::log::{Log, Mounting, Nominal, Sensor};
use crate::vehicle;
use std::f64::consts::{FRAC_PI_2, PI};

/// A later scan is the first at which the vehicle has driven this share of the reach or turned by this angle: far beyond noise.
const WAY_REACH: f64 = 0.1;
const TURN_RAD: f64 = 0.3;
/// Motion that turns by less is the same in a mirror, as far as bearings tell.
const MIRROR_RAD: f64 = 0.1;
/// Later than this odometry itself has gone astray.
const PATIENCE_S: f64 = 10.0;
/// Pairs of scans that are looked at, spread over the log.
const PAIRS: usize = 2000;
/// Gate in standard deviations.
const GATE: f64 = 3.0;
/// Another reading has to bring this many times the agreement, over so many detections, and beyond chance by so many standard deviations.
const TIMES: f64 = 1.5;
const DETECTIONS: usize = 100;
const SIGNIFICANT: f64 = 6.0;

/// Another way to read a log.
struct Reading {
    code: &'static str,
    place: &'static str,
    what: &'static str,
    advice: &'static str,
    speed: f64,
    turn: f64,
    /// Metres in a unit of range.
    range: f64,
    mirrored: bool,
    yaw_rad: f64,
    told_by: ToldBy,
}

/// Pairs of scans that tell a reading from what is written.
#[derive(Clone, Copy, PartialEq)]
enum ToldBy {
    Motion,
    Turns,
    /// Motion as it is beside ranges of that unit: beside those that are written the vehicle hardly moves.
    MotionAsRead,
}

const AS_WRITTEN: Reading = Reading {
    code: "",
    place: "",
    what: "",
    advice: "",
    speed: 1.0,
    turn: 1.0,
    range: 1.0,
    mirrored: false,
    yaw_rad: 0.0,
    told_by: ToldBy::Motion,
};

/// Ranges, and what the head says of them, in another unit.
const fn ranges(range: f64, what: &'static str, advice: &'static str) -> Reading {
    let place = "detections.csv, column range_m, and log.toml, section sensor";
    Reading { code: "range-unit", place, what, advice, range, told_by: ToldBy::MotionAsRead, ..AS_WRITTEN }
}

const OTHERS: [Reading; 10] = [
    // Bearings and turns of the other sign are the same world in a mirror: scans cannot tell which of both it is.
    Reading {
        code: "mirrored",
        place: "detections.csv, column bearing_rad",
        what: "their bearings are taken to grow to the right, or the odometry's turns",
        advice: "bearings grow to the left, and steering angles and turn rates are positive to the left: change the sign of the one \
                 that is not",
        mirrored: true,
        told_by: ToldBy::Turns,
        ..AS_WRITTEN
    },
    ranges(0.001, "ranges, range_max_m and range_sigma_m are taken as mm", "all three are in metres: divide by 1000"),
    ranges(0.01, "ranges, range_max_m and range_sigma_m are taken as cm", "all three are in metres: divide by 100"),
    ranges(
        0.3048,
        "ranges, range_max_m and range_sigma_m are taken as feet",
        "all three are in metres: multiply by 0.3048",
    ),
    Reading {
        code: "turn-unit",
        place: "odometry.csv",
        what: "the odometry's turns are taken as degrees",
        advice: "turn rates are in radians a second, steering angles in radians: multiply by 0.0174533",
        turn: PI / 180.0,
        ..AS_WRITTEN
    },
    Reading {
        code: "speed-unit",
        place: "odometry.csv",
        what: "speeds are taken as km/h",
        advice: "speeds are in metres a second: divide by 3.6",
        speed: 1.0 / 3.6,
        ..AS_WRITTEN
    },
    Reading {
        code: "speed-unit",
        place: "odometry.csv",
        what: "speeds are taken as cm/s",
        advice: "speeds are in metres a second: divide by 100",
        speed: 0.01,
        ..AS_WRITTEN
    },
    Reading {
        code: "sensor-yaw",
        place: "log.toml, section sensor",
        what: "the sensor is taken to look to the left",
        advice: "bearing 0 is straight ahead of the sensor: say sensor_yaw_rad = 1.5708, or change the bearings",
        yaw_rad: FRAC_PI_2,
        ..AS_WRITTEN
    },
    Reading {
        code: "sensor-yaw",
        place: "log.toml, section sensor",
        what: "the sensor is taken to look to the right",
        advice: "bearing 0 is straight ahead of the sensor: say sensor_yaw_rad = -1.5708, or change the bearings",
        yaw_rad: -FRAC_PI_2,
        ..AS_WRITTEN
    },
    Reading {
        code: "sensor-yaw",
        place: "log.toml, section sensor",
        what: "the sensor is taken to look back",
        advice: "bearing 0 is straight ahead of the sensor: say sensor_yaw_rad = 3.1416, or change the bearings; or change the sign of \
                 the speeds",
        yaw_rad: PI,
        ..AS_WRITTEN
    },
];

/// Detections that were carried into the view of a later scan, and those of them that met one.
#[derive(Debug, Clone, Copy, Default)]
struct Met {
    carried: usize,
    met: usize,
}

impl Met {
    fn share(self) -> f64 {
        self.met as f64 / self.carried.max(1) as f64
    }
}

/// The best other reading, where it is far better than what is written.
pub(super) fn planar(log: &Log, findings: &mut Findings) {
    let poses = vehicle::dead_reckoning(log);
    let moved = pairs(log, &poses, 1.0);
    let turned: Vec<[usize; 2]> =
        moved.iter().filter(|[from, to]| wrap(poses[*to][2] - poses[*from][2]).abs() > MIRROR_RAD).copied().collect();
    let written = [&moved, &turned].map(|pairs| agreement(log, &poses, pairs, &AS_WRITTEN));
    let read = OTHERS.iter().map(|other| {
        let poses_as_read = if (other.speed, other.turn) == (1.0, 1.0) {
            poses.clone()
        } else {
            vehicle::dead_reckoning(&changed(log, other))
        };
        match other.told_by {
            ToldBy::Motion => (other, written[0], agreement(log, &poses_as_read, &moved, other)),
            ToldBy::Turns => (other, written[1], agreement(log, &poses_as_read, &turned, other)),
            ToldBy::MotionAsRead => {
                let moved = pairs(log, &poses, other.range);
                (other, agreement(log, &poses, &moved, &AS_WRITTEN), agreement(log, &poses, &moved, other))
            }
        }
    });
    let better = |(_, written, read): &(&Reading, Met, Met)| {
        let of_written = written.share().max(0.01) / written.carried.max(1) as f64;
        let chance = (of_written + read.share() / read.carried.max(1) as f64).sqrt();
        read.met >= DETECTIONS
            && read.share() > TIMES * written.share()
            && read.share() - written.share() > SIGNIFICANT * chance
    };
    let best = read.filter(better).max_by(|a, b| a.2.share().total_cmp(&b.2.share()));
    if let Some((other, written, read)) = best {
        findings.warn(
            other.code,
            other.place,
            format!(
                "carried along by the odometry, {} of the detections fall on later ones, but {} if {}",
                percent(written.share()),
                percent(read.share()),
                other.what
            ),
            other.advice,
        );
    }
}

/// The log with its odometry read in another way.
fn changed(log: &Log, reading: &Reading) -> Log {
    let mut log = Log { scans: log.scans.clone(), odometry: log.odometry.clone(), ..without_tables(log) };
    for row in &mut log.odometry {
        row.control = [row.control[0] * reading.speed, row.control[1] * reading.turn];
    }
    log
}

fn without_tables(log: &Log) -> Log {
    Log {
        name: String::new(),
        initial_pose: log.initial_pose,
        vehicle: log.vehicle,
        sensor: log.sensor,
        sensor_name: String::new(),
        nominal: log.nominal,
        others: Vec::new(),
        simulated: log.simulated,
        odometry: Vec::new(),
        scans: Vec::new(),
        fixes: Vec::new(),
        fix_noise: log.fix_noise,
        truth: Vec::new(),
        truth_sigma_m: 0.0,
        landmarks: Vec::new(),
        moving: Vec::new(),
    }
}

/// Places of scans and of later ones of the same sensor, after motion; where ranges are in units of so many metres.
fn pairs(log: &Log, poses: &[[f64; 3]], range: f64) -> Vec<[usize; 2]> {
    let reach: Vec<f64> = log.sensors().map(|(_, sensor, _)| range * sensor.range_max_m).collect();
    let step = (log.scans.len() / PAIRS).max(1);
    let later = |from: usize| {
        let (scan, pose) = (&log.scans[from], poses[from]);
        let moved = |to: &usize| {
            let (x, y, turn) = (poses[*to][0] - pose[0], poses[*to][1] - pose[1], wrap(poses[*to][2] - pose[2]));
            log.scans[*to].sensor == scan.sensor
                && (libm::hypot(x, y) > WAY_REACH * reach[scan.sensor] || turn.abs() > TURN_RAD)
        };
        let in_time = |to: &usize| log.scans[*to].t_s <= scan.t_s + PATIENCE_S;
        (from + 1..log.scans.len()).take_while(in_time).find(moved).map(|to| [from, to])
    };
    (0..log.scans.len())
        .step_by(step)
        .filter(|from| !log.scans[*from].detections.is_empty())
        .filter_map(later)
        .collect()
}

fn agreement(log: &Log, poses: &[[f64; 3]], pairs: &[[usize; 2]], reading: &Reading) -> Met {
    let sensors: Vec<(&Sensor, &Nominal)> = log.sensors().map(|(_, sensor, nominal)| (sensor, nominal)).collect();
    let mut met = Met::default();
    for [from, to] in pairs {
        let (sensor, nominal) = sensors[log.scans[*from].sensor];
        let mounting = Mounting { yaw_rad: sensor.mounting.yaw_rad + reading.yaw_rad, ..sensor.mounting };
        let seats = [from, to].map(|place| mounting.seat(poses[*place]));
        // Without noise no two detections would agree.
        let stated = |sigma: Option<f64>| sigma.filter(|sigma| *sigma > 0.0);
        let (range_sigma_m, bearing_sigma_rad) = (stated(nominal.range_sigma_m), stated(nominal.bearing_sigma_rad));
        let [sigma_m, sigma_rad] = Nominal { range_sigma_m, bearing_sigma_rad, ..*nominal }.sigmas(sensor);
        let (unit_m, sigma_m) = (reading.range, reading.range * sigma_m);
        let sign = if reading.mirrored { -1.0 } else { 1.0 };
        for [range_m, bearing_rad] in &log.scans[*from].detections {
            let angle = seats[0][2] + sign * bearing_rad;
            let range_m = unit_m * range_m;
            let (x, y) = (seats[0][0] + range_m * libm::cos(angle), seats[0][1] + range_m * libm::sin(angle));
            let (x, y) = (x - seats[1][0], y - seats[1][1]);
            let (range_m, bearing_rad) = (libm::hypot(x, y), sign * wrap(libm::atan2(y, x) - seats[1][2]));
            if !in_view(sensor, range_m / unit_m, bearing_rad) {
                continue;
            }
            met.carried += 1;
            // The difference of two measurements has twice their variance.
            let near = |other: &&[f64; 2]| {
                let off = [(unit_m * other[0] - range_m) / sigma_m, wrap(other[1] - bearing_rad) / sigma_rad];
                off[0] * off[0] + off[1] * off[1] < 2.0 * GATE * GATE
            };
            met.met += usize::from(log.scans[*to].detections.iter().find(near).is_some());
        }
    }
    met
}

fn in_view(sensor: &Sensor, range_m: f64, bearing_rad: f64) -> bool {
    let half_rad = 0.5 * (sensor.bearing_max_rad - sensor.bearing_min_rad);
    let middle_rad = 0.5 * (sensor.bearing_max_rad + sensor.bearing_min_rad);
    (sensor.range_min_m..=sensor.range_max_m).contains(&range_m)
        && (half_rad >= PI || wrap(bearing_rad - middle_rad).abs() <= half_rad)
}
