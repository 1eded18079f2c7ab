//! Whether odometry and scans tell the same motion, without any truth.
//!
//! Detections of one scan, carried along by the odometry, should fall on detections of a later one. If they do so far more often when
//! one thing is read in another way (mirrored bearings, turn rates as degrees, speeds as km/h, ranges as mm), that is probably what the log
//! means.

use super::finding::{Findings, percent};
use super::shift;
use super::sight::Sight;
use crate::angle::wrap;
use crate::log::{Log, Odometry, Scan};
use crate::vehicle;
use std::borrow::Cow;
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
/// Another reading has to bring this many times the agreement, over so many detections, and beyond chance by so many standard deviations.
const TIMES: f64 = 1.5;
const DETECTIONS: usize = 100;
const SIGNIFICANT: f64 = 6.0;

/// Another way to read a log.
pub(super) struct Reading {
    code: &'static str,
    place: &'static str,
    what: &'static str,
    advice: &'static str,
    speed: f64,
    turn: f64,
    /// Metres in a unit of range.
    pub(super) range: f64,
    pub(super) mirrored: bool,
    pub(super) yaw_rad: f64,
    /// Bearings count from an axis of the map.
    pub(super) absolute: bool,
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

pub(super) const AS_WRITTEN: Reading = Reading {
    code: "",
    place: "",
    what: "",
    advice: "",
    speed: 1.0,
    turn: 1.0,
    range: 1.0,
    mirrored: false,
    yaw_rad: 0.0,
    absolute: false,
    told_by: ToldBy::Motion,
};

/// Ranges, and what the head says of them, in another unit.
const fn ranges(range: f64, what: &'static str, advice: &'static str) -> Reading {
    let place = "detections.csv, column range_m, and log.toml, section sensor";
    Reading { code: "range-unit", place, what, advice, range, told_by: ToldBy::MotionAsRead, ..AS_WRITTEN }
}

const OTHERS: [Reading; 12] = [
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
    Reading {
        code: "bearing-frame",
        place: "detections.csv, column bearing_rad",
        what: "bearings are taken to count from an axis of the map",
        advice: "a bearing counts from straight ahead of the sensor, to the left: take the vehicle's heading off",
        absolute: true,
        told_by: ToldBy::Turns,
        ..AS_WRITTEN
    },
    Reading {
        code: "bearing-frame",
        place: "detections.csv, column bearing_rad",
        what: "bearings are taken to be a compass's, from an axis of the map to the right",
        advice: "a bearing counts from straight ahead of the sensor, to the left: take it from the vehicle's heading as a compass has it",
        absolute: true,
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
            Cow::Borrowed(&poses)
        } else {
            Cow::Owned(vehicle::dead_reckoning(&changed(log, other)))
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
    let shift = shift::best(log, &poses, &moved);
    if let Some(shift) = shift.filter(|shift| best.as_ref().is_none_or(|(_, _, read)| shift.share() > read.share())) {
        shift.tell(findings);
        return;
    }
    let Some((other, written, read)) = best else { return };
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

/// The log with its odometry read in another way, and of its scans the times alone.
fn changed(log: &Log, reading: &Reading) -> Log {
    let as_read =
        |row: &Odometry| Odometry { control: [row.control[0] * reading.speed, row.control[1] * reading.turn], ..*row };
    Log {
        name: String::new(),
        initial_pose: log.initial_pose,
        vehicle: log.vehicle,
        sensor: log.sensor,
        sensor_name: String::new(),
        nominal: log.nominal,
        others: Vec::new(),
        simulated: log.simulated,
        odometry: log.odometry.iter().map(as_read).collect(),
        scans: log.scans.iter().map(|scan| Scan { t_s: scan.t_s, ..Scan::default() }).collect(),
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
    let sight = Sight::of(log, reading);
    let mut met = Met::default();
    for [from, to] in pairs {
        let scan = &log.scans[*from];
        for &detection in &scan.detections {
            let Some(carried) = sight.carried(scan.sensor, [poses[*from], poses[*to]], detection) else { continue };
            met.carried += 1;
            met.met += usize::from(sight.meets(&log.scans[*to], carried));
        }
    }
    met
}
