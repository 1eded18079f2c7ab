//! Whether odometry and scans agree on the motion. Needs no truth.
//!
//! Detections of one scan, transformed by the odometry, should match detections of a later one. If far more of them match when
//! one quantity is read differently (mirrored bearings, turn rates in degrees, speeds in km/h, ranges in mm), that reading is
//! probably what the log means.

use super::finding::{Findings, percent, quantile, short};
use super::reading::{AS_WRITTEN, BACKWARDS, OTHERS, Reading, STANDS, ToldBy};
use super::sight::{Met, Sight};
use super::still::Zones;
use super::{intervals, reverse, shift, still};
use scphd_log::angle::wrap;
use scphd_log::log::{Log, Odometry, Scan, Vehicle};
use scphd_log::vehicle::{self, FASTEST_MPS};
use std::borrow::Cow;

/// Least motion between the two scans of a pair, far above noise: this share of the sensor's range, or this angle, rad.
const WAY_REACH: f64 = 0.1;
const TURN_RAD: f64 = 0.3;
/// Least turn between two scans, rad, at which bearings can distinguish a mirrored reading.
const MIRROR_RAD: f64 = 0.1;
/// Greatest time between the two scans of a pair, s: the odometry drifts.
const PATIENCE_S: f64 = 10.0;
/// Greatest number of pairs of scans, spread over the log.
const PAIRS: usize = 2000;
/// Another reading is accepted with at least this ratio of the shares of matches, this number of matches, and this number of
/// standard deviations.
const TIMES: f64 = 1.5;
const DETECTIONS: usize = 100;
const SIGNIFICANT: f64 = 6.0;
/// Offsets of the turn rate that are tried, to both sides, rad/s, and the least ratio of the shares of matches for an offset.
const OFFSETS_RADPS: [f64; 6] = [0.01, 0.02, 0.03, 0.04, 0.06, 0.08];
const OFFSET_TIMES: f64 = 1.15;
/// The detections outside zones that stand still in the view are judged only if they are more than one in this number of all.
const LITTLE: usize = 4;
/// Shares of matches that differ by no more than this are taken as equal.
const NEARLY: f64 = 0.1;
/// Least share of matches for the finding that everything stands still in the view: other detections leave the view, or are
/// missed.
const MOST: f64 = 0.3;

/// Zones in which sensors see parts of their own vehicle. Most logs have none. Found before the other checks.
pub(super) fn zones(log: &Log) -> Zones {
    let poses = vehicle::dead_reckoning(log);
    let moved = pairs(log, &poses, moves(log, 1.0));
    let (zones, _) = still::look_over(&mut without_truth(log), &poses, &moved, &mut Findings::default());
    if zones.iter().all(Vec::is_empty) { zones } else { planar(log, &mut Findings::default()) }
}

/// Compares the scans with the odometry. Returns the zones in which sensors see parts of their own vehicle.
pub(super) fn planar(log: &Log, findings: &mut Findings) -> Zones {
    let written = without_truth(log);
    let poses = vehicle::dead_reckoning(log);
    let moved = pairs(log, &poses, moves(log, 1.0));
    let mut rest = without_truth(log);
    let mut fixed = Findings::default();
    let (zones, along) = still::look_over(&mut rest, &poses, &moved, &mut fixed);
    let offset = offset(&rest, &moved);
    let least = offset.as_ref().map_or(0.0, |offset| offset.read.share() - NEARLY);
    let best = best(&rest, &poses, &moved).filter(|(_, _, read)| read.share() > least);
    let shift = shift::best(&rest, &poses, &moved).filter(|shift| shift.share() > least);
    let shift = shift.filter(|shift| best.as_ref().is_none_or(|(_, _, read)| shift.share() > read.share()));
    let (all, stands) = (agreement(&written, &poses, &moved, &AS_WRITTEN), standing(&written, &moved));
    // Parts of the vehicle stand still in the view, and other detections move with the odometry. In a log in map coordinates all
    // stand still.
    let of_rest = agreement(&rest, &poses, &moved, &AS_WRITTEN);
    let of_rest = if of_rest.carried * LITTLE > all.carried { of_rest.share() } else { 0.0 };
    let others = shift.as_ref().map(|shift| shift.share()).or(best.as_ref().map(|best| best.2.share()));
    let all_stand = stands.met >= DETECTIONS
        && stands.share() > MOST.max(TIMES * of_rest).max(TIMES * all.share())
        && others.is_none_or(|share| stands.share() > share + NEARLY);
    if all_stand {
        tell(&STANDS, all, stands, findings);
        return Zones::new();
    }
    findings.0.extend(fixed.0);
    if let Some(shift) = shift {
        shift.tell(findings);
        return zones;
    }
    if let Some((other, written, read)) = best {
        tell(other, written, read, findings);
        return zones;
    }
    findings.0.extend(along.0);
    if let Some(offset) = offset {
        offset.note(findings);
        rest.odometry = offset.odometry;
    }
    let (poses, backwards) = (vehicle::dead_reckoning(&rest), vehicle::dead_reckoning(&changed(&rest, &BACKWARDS)));
    let moved = pairs(&rest, &poses, moves(&rest, 1.0));
    reverse::look_over(&rest, &poses, &backwards, &moved, findings);
    intervals::look_over(&rest, &poses, findings);
    zones
}

/// Detections that match one of a later scan at the same range and bearing, in view or not.
fn standing(log: &Log, pairs: &[[usize; 2]]) -> Met {
    let sight = Sight::of(log, &AS_WRITTEN);
    let of = |&[from, to]: &[usize; 2]| {
        let seen = &log.scans[from].detections;
        Met { carried: seen.len(), met: seen.iter().filter(|one| sight.meets(&log.scans[to], **one)).count() }
    };
    pairs.iter().map(of).fold(Met::default(), Met::and)
}

/// An offset of the turn rate that the scans show: wheels of different size, or the bias of a gyroscope.
struct Offset {
    radps: f64,
    odometry: Vec<Odometry>,
    written: Met,
    read: Met,
}

impl Offset {
    fn note(&self, findings: &mut Findings) {
        findings.note(
            "turn-offset",
            "odometry.csv",
            format!(
                "carried along by the odometry, {} of the detections fall on later ones, but {} if it turns to the {} by {} rad/s more",
                percent(self.written.share()),
                percent(self.read.share()),
                if self.radps > 0.0 { "left" } else { "right" },
                short(self.radps.abs())
            ),
            "nothing, if wheels are not of one size or a gyroscope is not at zero: filters follow; better is to take it off",
        );
    }
}

/// The offset with most matches; `None` if none is better than no offset.
fn offset(log: &Log, moved: &[[usize; 2]]) -> Option<Offset> {
    let usual_mps = quantile(log.odometry.iter().map(|row| row.speed_mps().abs()).collect(), 0.5).unwrap_or(0.0);
    // For a car, the offset is one of the steering angle.
    let of_control = |radps: f64| match log.vehicle {
        Vehicle::Ackermann { wheelbase_m, .. } => radps * wheelbase_m / usual_mps.max(FASTEST_MPS * 1e-3),
        Vehicle::Unicycle | Vehicle::UnicycleArc | Vehicle::Holonomic => radps,
    };
    let with = |radps: f64| {
        let offset = of_control(radps);
        let row = |row: &Odometry| {
            let [ahead, turn, left] = row.control;
            Odometry { control: [ahead, turn + offset, left], ..*row }
        };
        log.odometry.iter().map(row).collect::<Vec<Odometry>>()
    };
    let of = |radps: f64| {
        let turned = Log { odometry: with(radps), ..changed(log, &AS_WRITTEN) };
        agreement(log, &vehicle::dead_reckoning(&turned), moved, &AS_WRITTEN)
    };
    let written = of(0.0);
    let trials = OFFSETS_RADPS.into_iter().flat_map(|offset| [offset, -offset]).map(|offset| (offset, of(offset)));
    let better = |(_, met): &(f64, Met)| met.met >= DETECTIONS && met.share() > OFFSET_TIMES * written.share();
    let (radps, read) = trials.filter(better).max_by(|a, b| a.1.share().total_cmp(&b.1.share()))?;
    Some(Offset { radps, odometry: with(radps), written, read })
}

/// The best other reading, with the matches as written and as read; `None` unless it is far better than the log as written.
fn best(log: &Log, poses: &[[f64; 3]], moved: &[[usize; 2]]) -> Option<(&'static Reading, Met, Met)> {
    let is_turned = |[from, to]: &&[usize; 2]| wrap(poses[*to][2] - poses[*from][2]).abs() > MIRROR_RAD;
    let turned: Vec<[usize; 2]> = moved.iter().filter(is_turned).copied().collect();
    let written = [moved, &turned].map(|pairs| agreement(log, poses, pairs, &AS_WRITTEN));
    let read = OTHERS.iter().map(|other| {
        let poses_as_read = if (other.speed, other.turn) == (1.0, 1.0) {
            Cow::Borrowed(poses)
        } else {
            Cow::Owned(vehicle::dead_reckoning(&changed(log, other)))
        };
        let on = |pairs: Vec<[usize; 2]>| {
            (other, agreement(log, poses, &pairs, &AS_WRITTEN), agreement(log, &poses_as_read, &pairs, other))
        };
        match other.told_by {
            ToldBy::Motion => (other, written[0], agreement(log, &poses_as_read, moved, other)),
            ToldBy::Turns => (other, written[1], agreement(log, &poses_as_read, &turned, other)),
            ToldBy::MotionBesideRange => on(pairs(log, poses, moves(log, other.range))),
            ToldBy::WayAsRead => on(pairs(log, &poses_as_read, |sensor, way_m, _| way_m > way_of(log, sensor, 1.0))),
            ToldBy::TurnsAsRead => on(pairs(log, &poses_as_read, |_, _, turn_rad| turn_rad.abs() > TURN_RAD)),
        }
    });
    let better = |(_, written, read): &(&Reading, Met, Met)| {
        let of_written = written.share().max(0.01) / written.carried.max(1) as f64;
        let chance = (of_written + read.share() / read.carried.max(1) as f64).sqrt();
        read.met >= DETECTIONS
            && read.share() > TIMES * written.share()
            && read.share() - written.share() > SIGNIFICANT * chance
    };
    read.filter(better).max_by(|a, b| a.2.share().total_cmp(&b.2.share()))
}

fn tell(other: &Reading, written: Met, read: Met, findings: &mut Findings) {
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

/// The log with only the data needed to compare scans with odometry.
fn without_truth(log: &Log) -> Log {
    Log { odometry: log.odometry.clone(), scans: log.scans.clone(), ..changed(log, &AS_WRITTEN) }
}

/// The log with its odometry read differently, and only the times of its scans.
fn changed(log: &Log, reading: &Reading) -> Log {
    let as_read = |row: &Odometry| {
        let [ahead, turn, left] = row.control;
        Odometry { control: [ahead * reading.speed, turn * reading.turn, left * reading.speed], ..*row }
    };
    Log {
        initial_pose: log.initial_pose,
        vehicle: log.vehicle,
        sensor: log.sensor,
        sensor_name: log.sensor_name.clone(),
        nominal: log.nominal,
        others: log.others.clone(),
        simulated: log.simulated,
        odometry: log.odometry.iter().map(as_read).collect(),
        scans: log.scans.iter().map(|scan| Scan { t_s: scan.t_s, ..Scan::default() }).collect(),
        fix_noise: log.fix_noise,
        ..Log::default()
    }
}

/// Least distance between the two scans of a pair for this sensor, m. `range` is the unit of ranges, m.
fn way_of(log: &Log, sensor: usize, range: f64) -> f64 {
    WAY_REACH * range * log.sensors().nth(sensor).map_or(f64::INFINITY, |(_, sensor, _)| sensor.range_max_m)
}

/// Whether a distance, m, or a turn, rad, suffices for a pair of scans of a sensor.
fn moves(log: &Log, range: f64) -> impl Fn(usize, f64, f64) -> bool + '_ {
    move |sensor, way_m, turn_rad| way_m > way_of(log, sensor, range) || turn_rad.abs() > TURN_RAD
}

/// Indices of scans and of the first later scan of the same sensor after enough motion.
fn pairs(log: &Log, poses: &[[f64; 3]], moves: impl Fn(usize, f64, f64) -> bool) -> Vec<[usize; 2]> {
    let step = (log.scans.len() / PAIRS).max(1);
    let later = |from: usize| {
        let (scan, pose) = (&log.scans[from], poses[from]);
        let moved = |to: &usize| {
            let (x, y, turn) = (poses[*to][0] - pose[0], poses[*to][1] - pose[1], wrap(poses[*to][2] - pose[2]));
            log.scans[*to].sensor == scan.sensor && moves(scan.sensor, libm::hypot(x, y), turn)
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
    pairs.iter().fold(Met::default(), |met, pair| met.and(Met::of(log, &sight, poses, *pair)))
}
