//! Speeds without a sign: by the scans the vehicle reverses, by the odometry never.

use super::finding::{Findings, percent, short};
use super::reading::AS_WRITTEN;
use super::sight::{Met, Sight};
use scphd_log::log::{Log, Vehicle};

/// Number of pairs of scans before and after a pair that are judged together with it.
const BESIDE: usize = 2;
/// The vehicle reverses in a pair if, driving backwards, at least this many more detections match than forwards,
const MORE: usize = 5;
/// at least this many times as many,
const TIMES: usize = 2;
/// and more than this share of the detections.
const SHARE: f64 = 0.5;
/// Least number of such pairs, and least share among the pairs that distinguish the directions.
const PAIRS: usize = 20;
const OF_ALL: f64 = 0.02;

pub(super) fn look_over(
    log: &Log,
    poses: &[[f64; 3]],
    backwards: &[[f64; 3]],
    pairs: &[[usize; 2]],
    findings: &mut Findings,
) {
    // A holonomic vehicle has signed speeds.
    if log.vehicle == Vehicle::Holonomic || log.odometry.iter().any(|row| row.control[0] < 0.0) {
        return;
    }
    let sight = Sight::of(log, &AS_WRITTEN);
    let met =
        |poses: &[[f64; 3]]| -> Vec<Met> { pairs.iter().map(|pair| Met::of(log, &sight, poses, *pair)).collect() };
    let (ahead, back) = (met(poses), met(backwards));
    let around = |met: &[Met], place: usize| {
        let until = (place + BESIDE + 1).min(met.len());
        met[place.saturating_sub(BESIDE)..until].iter().fold(Met::default(), |sum, one| sum.and(*one))
    };
    let is_better =
        |one: Met, other: Met| one.met >= other.met + MORE && one.met >= TIMES * other.met && one.share() > SHARE;
    let places = 0..pairs.len();
    let reversing: Vec<usize> =
        places.clone().filter(|place| is_better(around(&back, *place), around(&ahead, *place))).collect();
    let driving = places.filter(|place| is_better(around(&ahead, *place), around(&back, *place))).count();
    let share = reversing.len() as f64 / (driving + reversing.len()).max(1) as f64;
    let Some(&first) = reversing.first().filter(|_| reversing.len() >= PAIRS && share > OF_ALL) else { return };
    findings.warn(
        "speed-unsigned",
        "odometry.csv",
        format!(
            "no speed is negative, but by the scans the vehicle reverses, {} of the time that it moves, first at {} s",
            percent(share),
            short(log.scans[pairs[first][0]].t_s)
        ),
        "write the speed with its sign: negative where the vehicle reverses",
    );
}
