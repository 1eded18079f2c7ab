//! Whether odometry and scans tell the same motion, without any truth.
//!
//! Detections of one scan, carried along by the odometry, should fall on detections of a later one. If they do so far more often when
//! one thing is read in another way (mirrored bearings, turn rates as degrees, speeds as km/h, ranges as mm), that is probably what the log
//! means.

use super::finding::{Findings, percent};
use super::reading::{AS_WRITTEN, OTHERS, Reading, ToldBy};
use super::shift;
use super::sight::Sight;
use crate::angle::wrap;
use crate::log::{Log, Odometry, Scan};
use crate::vehicle;
use std::borrow::Cow;

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
    let as_read = |row: &Odometry| {
        let [ahead, turn, left] = row.control;
        Odometry { control: [ahead * reading.speed, turn * reading.turn, left * reading.speed], ..*row }
    };
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
