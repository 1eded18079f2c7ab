//! Time base, rates, gaps, and repeated scans.

use super::finding::{Findings, Motion, percent, quantile, short};
use scphd_filters::kind::Kind;
use scphd_log::dimensions::Coordinates;
use scphd_log::log::Scan;
use std::collections::HashMap;

/// Least interval of odometry or of a landmark detector, s: a smaller one means that times are in minutes, hours or days.
const LEAST_INTERVAL_S: f64 = 1e-4;
/// Greatest turn in a row of odometry, rad: the motion models integrate to first order.
const STEP_RAD: f64 = 1.0;
/// Greatest turn between scans, rad: beyond it a view of half a turn shows less than half of the same landmarks.
const SCAN_TURN_RAD: f64 = std::f64::consts::FRAC_PI_2;
/// Least length of a gap: this multiple of the usual interval, and this time, s.
const GAP_TIMES: f64 = 10.0;
const GAP_S: f64 = 1.0;
/// Odometry has a fixed rate if this share of the intervals is at most this multiple of the usual one; only then gaps are
/// reported. Otherwise rows are written on change, and a long interval means that nothing changed.
const STEADY_TIMES: f64 = 3.0;
const STEADY_SHARE: f64 = 0.95;
/// Least motion in a gap that is reported: this share of the range of the view, and this angle, rad.
const BLIND_REACH: f64 = 0.25;
const BLIND_RAD: f64 = 0.5;
/// Least number of values in a scan that counts as repeated: noise does not repeat exactly, but a coarse sensor of a vehicle at
/// rest may repeat a scan of one or two detections.
const REPEATED_NUMBERS: usize = 6;
/// Least share of repeated scans, among those with enough values, that is reported.
const REPEATED_SHARE: f64 = 0.01;

pub(super) fn look_over<K: Kind>(log: &K::Log, motion: &[Motion], reach_m: f64, findings: &mut Findings) {
    rates::<K>(log, motion, reach_m, findings);
    gaps(motion, reach_m, findings);
    coverage::<K>(log, motion, findings);
    doubled::<K>(log, findings);
}

/// Every row with the time until the next one, s.
fn steps(motion: &[Motion]) -> impl Iterator<Item = (&Motion, f64)> {
    motion.windows(2).map(|pair| (&pair[0], pair[1].t_s - pair[0].t_s))
}

/// Times from each scan to the next one of the same sensor, s: scans of different sensors may be simultaneous.
fn between_scans<K: Kind>(log: &K::Log) -> Vec<f64> {
    let mut last: HashMap<usize, f64> = HashMap::new();
    let interval = |scan: &Scan<K>| last.insert(scan.sensor, scan.t_s).map(|before_s| scan.t_s - before_s);
    K::scans(log).iter().filter_map(interval).collect()
}

/// Reports intervals that are too short for any clock.
fn time_unit(place: &str, median_s: f64, findings: &mut Findings) {
    let (what, advice) = if median_s == 0.0 {
        (
            "half of the rows or more have the time of the row before".to_owned(),
            "write each row once and with its own time, in seconds with decimals: nothing moves between equal times",
        )
    } else {
        (
            format!("rows are {} s apart in the median, faster than 10 kHz", short(median_s)),
            "times are in seconds: these may be minutes, hours or days; multiply by 60, 3600 or 86400",
        )
    };
    findings.warn("time-unit", place, what, advice);
}

fn rates<K: Kind>(log: &K::Log, motion: &[Motion], reach_m: f64, findings: &mut Findings) {
    let scans = K::scans(log);
    for (place, intervals_s) in [
        ("odometry.csv, column t_s", steps(motion).map(|(_, dt_s)| dt_s).collect()),
        ("scans.csv, column t_s", between_scans::<K>(log)),
    ] {
        if let Some(median_s) = quantile(intervals_s, 0.5).filter(|median_s| *median_s < LEAST_INTERVAL_S) {
            time_unit(place, median_s, findings);
        }
    }
    if let Some(turn) = quantile(steps(motion).map(|(row, dt_s)| (row.turn_radps * dt_s).abs()).collect(), 0.95)
        && turn > STEP_RAD
    {
        findings.warn(
            "odometry-coarse",
            "odometry.csv",
            format!("a row holds for a turn of {} rad or more in one of twenty", short(turn)),
            "write odometry more often, or check the units of time and of turn: a step of the motion model is good for a \
             small part of a turn",
        );
    }
    let mut driven = Vec::with_capacity(scans.len());
    let (mut row, mut now_s, mut way_m, mut turn_rad) = (0, f64::NEG_INFINITY, 0.0, 0.0_f64);
    for scan in scans {
        let (before_m, before_rad) = (way_m, turn_rad);
        while row < motion.len() && now_s < scan.t_s {
            let until_s = motion.get(row + 1).map_or(scan.t_s, |next| next.t_s.min(scan.t_s));
            let dt_s = (until_s - motion[row].t_s.max(now_s)).max(0.0);
            way_m += motion[row].speed_mps.unwrap_or(0.0) * dt_s;
            turn_rad += motion[row].turn_radps * dt_s;
            now_s = until_s;
            if motion.get(row + 1).is_some_and(|next| next.t_s <= now_s) {
                row += 1;
            } else {
                break;
            }
        }
        driven.push([way_m - before_m, (turn_rad - before_rad).abs()]);
    }
    let middle = |k: usize| quantile(driven.iter().map(|one| one[k]).collect(), 0.5).unwrap_or(0.0);
    let (way_m, turn_rad) = (middle(0), middle(1));
    if scans.len() > 2 && (way_m > 0.5 * reach_m || turn_rad > SCAN_TURN_RAD) {
        findings.warn(
            "scans-far-apart",
            "scans.csv",
            format!(
                "from scan to scan the vehicle drives {} m and turns {} rad in the median; the sensor reaches {} m",
                short(way_m),
                short(turn_rad),
                short(reach_m)
            ),
            "check the units of times, speeds and turn rates; if they are right, write scans more often: little of one is seen \
             in the next",
        );
    }
}

fn gaps(motion: &[Motion], reach_m: f64, findings: &mut Findings) {
    let Some(usual_s) = quantile(steps(motion).map(|(_, dt_s)| dt_s).collect(), 0.5) else { return };
    let blind = |(row, dt_s): &(&Motion, f64)| {
        *dt_s > (GAP_TIMES * usual_s).max(GAP_S)
            && (row.speed_mps.unwrap_or(0.0) * dt_s > BLIND_REACH * reach_m
                || (row.turn_radps * dt_s).abs() > BLIND_RAD)
    };
    let found: Vec<(&Motion, f64)> = steps(motion).filter(blind).collect();
    let Some((row, dt_s)) = found.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
    let what = format!(
        "{} times a row holds while the vehicle goes on for a quarter of the sensor's reach or half a radian; the longest from {} s on, \
         {} s at {} m/s and {} rad/s, usual are {} s",
        found.len(),
        short(row.t_s),
        short(*dt_s),
        short(row.speed_mps.unwrap_or(0.0)),
        short(row.turn_radps),
        short(usual_s),
    );
    let most_s = quantile(steps(motion).map(|(_, dt_s)| dt_s).collect(), STEADY_SHARE).unwrap_or(0.0);
    if most_s <= STEADY_TIMES * usual_s {
        findings.warn(
            "odometry-gap",
            "odometry.csv",
            what,
            "write the rows that are missing, or one that says that the vehicle stands: a row holds until the next one",
        );
    } else {
        findings.note(
            "odometry-held",
            "odometry.csv",
            what,
            "nothing, if rows are written when something changes: a row holds until the next one",
        );
    }
}

fn coverage<K: Kind>(log: &K::Log, motion: &[Motion], findings: &mut Findings) {
    let scans = K::scans(log);
    let all = scans.len().max(1) as f64;
    if let ([first, .., last], Some(usual_s)) = (motion, quantile(steps(motion).map(|(_, dt_s)| dt_s).collect(), 0.5)) {
        // The last row is valid for a usual interval.
        let slack_s = (GAP_TIMES * usual_s).max(GAP_S);
        let early = scans.iter().filter(|scan| scan.t_s < first.t_s - slack_s).count();
        let late = scans.iter().filter(|scan| scan.t_s > last.t_s + slack_s).count();
        if early + late > 0 {
            findings.warn(
                "scans-without-odometry",
                "odometry.csv",
                format!(
                    "{early} scans are before its first row at {} s and {late} after its last at {} s, {} of all",
                    short(first.t_s),
                    short(last.t_s),
                    percent((early + late) as f64 / all)
                ),
                "before the first row the vehicle stands, after the last it goes on as that row says: give both files the same clock, or \
                 cut off the scans",
            );
        }
    }
    let (truth, known) =
        (K::truth(log), scans.iter().filter(|scan| scphd_log::truth::at(K::truth(log), scan.t_s).is_some()).count());
    match truth {
        [] => findings.note(
            "no-truth",
            "truth.csv",
            "no true place is known: nothing tells how good the estimate or the odometry is".to_owned(),
            "nothing, if there is none; with t_s,x_m,y_m of a few places errors and dead reckoning are told",
        ),
        [first, ..] if known == 0 => findings.warn(
            "truth-other-clock",
            "truth.csv, column t_s",
            format!(
                "no scan is between two rows at most {} s apart: truth is from {} s to {} s, scans from {} s to {} s",
                scphd_log::truth::MAX_GAP_S,
                short(first.t_s),
                short(truth[truth.len() - 1].t_s),
                short(scans.first().map_or(0.0, |scan| scan.t_s)),
                short(scans.last().map_or(0.0, |scan| scan.t_s))
            ),
            "give truth.csv the clock of scans.csv, in seconds",
        ),
        _ if 2 * known < scans.len() => findings.note(
            "truth-partial",
            "truth.csv",
            format!("covers {known} of {} scans", scans.len()),
            "nothing: errors are over these scans alone",
        ),
        _ => {}
    }
}

fn doubled<K: Kind>(log: &K::Log, findings: &mut Findings) {
    let scans = K::scans(log);
    let rich = |detections: &[K::Measurement]| detections.len() * K::Measurement::COUNT >= REPEATED_NUMBERS;
    let (mut seen, mut repeated, mut at_once, mut first) = (0_usize, 0_usize, 0_usize, None);
    let mut last: Vec<Option<usize>> = Vec::new();
    for (index, scan) in scans.iter().enumerate() {
        if last.len() <= scan.sensor {
            last.resize(scan.sensor + 1, None);
        }
        let before = last[scan.sensor].replace(index).map(|before| &scans[before]);
        if !rich(&scan.detections) {
            continue;
        }
        seen += 1;
        let Some(before) = before else { continue };
        if before.detections == scan.detections {
            repeated += 1;
            at_once += usize::from(before.t_s == scan.t_s);
            first = first.or(Some((index, scan.t_s)));
        }
    }
    if let Some((index, t_s)) = first.filter(|_| repeated as f64 > REPEATED_SHARE * seen as f64) {
        let when = if at_once == repeated { ", at the same time" } else { "" };
        findings.warn(
            "scans-doubled",
            "scans.csv",
            format!(
                "{repeated} of {seen} scans repeat the one before to the last digit{when}; the first is scan {index}, counted \
                 from 0, at {} s",
                short(t_s)
            ),
            "write each scan once: a repeated scan is taken for new evidence, and the filter becomes too sure",
        );
    }
    let (mut all, mut twice) = (0_usize, 0_usize);
    for scan in scans {
        let mut sorted: Vec<&[f64]> = scan.detections.iter().map(AsRef::as_ref).collect();
        sorted.sort_by(|a, b| {
            a.iter()
                .zip(*b)
                .map(|(a, b)| a.total_cmp(b))
                .find(|order| order.is_ne())
                .unwrap_or(std::cmp::Ordering::Equal)
        });
        all += sorted.len();
        twice += sorted.windows(2).filter(|pair| pair[0] == pair[1]).count();
    }
    if twice as f64 > REPEATED_SHARE * all as f64 {
        findings.warn(
            "detections-doubled",
            "detections.csv",
            format!("{twice} of {all} detections are in their scan a second time, to the last digit"),
            "write each detection once: a feature gives one measurement a scan at most",
        );
    }
}
