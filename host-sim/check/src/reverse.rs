//! Speeds without a sign: the scans tell that the vehicle reverses, the odometry never does.

use super::finding::{Findings, percent, short};
use super::reading::AS_WRITTEN;
use super::sight::{Met, Sight};
use scphd_log::log::{Log, Vehicle};

/// Pairs of scans are judged together with so many before and after them.
const BESIDE: usize = 2;
/// Backwards, so many more detections have to meet a later one than forwards,
const MORE: usize = 5;
/// so many times as many,
const TIMES: usize = 2;
/// and that share of those that are carried has to.
const SHARE: f64 = 0.5;
/// In so many pairs of scans, and in that share of all that tell one from the other.
const PAIRS: usize = 20;
const OF_ALL: f64 = 0.02;

pub(super) fn look_over(
    log: &Log,
    poses: &[[f64; 3]],
    backwards: &[[f64; 3]],
    pairs: &[[usize; 2]],
    findings: &mut Findings,
) {
    // What moves aside is written with a sign.
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
