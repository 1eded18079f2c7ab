//! Speeds and turns, and dead reckoning compared with the truth.

use super::finding::{Findings, Motion, percent, quantile, short};
use scphd_filters::kind::Kind;
use scphd_log::angle::wrap;
use scphd_log::dimensions::{Coordinates, distance};
use scphd_log::truth;
use scphd_log::vehicle::FASTEST_MPS;
use std::f64::consts::PI;

/// Limits: no vehicle that maps landmarks is faster,
pub(super) const SPEED_MPS: f64 = FASTEST_MPS;
/// nor turns faster for long than once a second, rad/s,
const TURN_RADPS: f64 = 2.0 * PI;
/// nor has a lateral acceleration above gravity, except a simulated one.
const ACROSS_MPS2: f64 = 9.81;
/// All three apply to the 95 % quantile of the rows, so that noise and outliers do not count.
const MOST_ROWS: f64 = 0.95;
/// Distances are compared over segments of this share of the sensor's range: longer than the noise of the truth, shorter than
/// most turns.
const PIECE_REACH: f64 = 0.25;
/// Least number of segments.
const PIECES: usize = 8;
/// Greatest ratio of distances: worn tyres and slip change a distance by tenths, a wrong unit by more than this.
const WAY_RATIO: f64 = 2.0;
/// Dead reckoning is lost if its error exceeds this share of the distance, and the sensor's range.
const LOST_SHARE: f64 = 0.3;
/// A correlation of turns with the true ones below this means the opposite sign.
const TURNED_AROUND: f64 = -0.5;
/// Greatest error of the initial heading, rad.
const START_RAD: f64 = 0.5;

/// A unit of headings is right if its mean cosine to the direction of motion is greater by this.
const CLEARLY: f64 = 0.2;

/// Units, each with the factor by which distances are too long.
const UNITS: [(f64, &str); 8] = [
    (1000.0, "speeds in mm/s, or times in milliseconds"),
    (100.0, "speeds in cm/s"),
    (3.6, "speeds in km/h"),
    (3.28, "speeds in feet a second"),
    (1.0 / 60.0, "times in minutes"),
    (1.0 / 3600.0, "times in hours"),
    (0.01, "the truth in cm"),
    (0.001, "the truth in mm"),
];

/// The distance that the odometry drives until a time, m; `None` without speeds.
pub(super) fn driven(motion: &[Motion], until_s: f64) -> Option<f64> {
    let until = |place: usize| motion.get(place + 1).map_or(until_s, |next| next.t_s.min(until_s));
    let ways =
        motion.iter().enumerate().map(|(place, row)| row.speed_mps.unwrap_or(0.0) * (until(place) - row.t_s).max(0.0));
    motion.iter().any(|row| row.speed_mps.is_some()).then(|| ways.sum())
}

/// The 95 % quantile of the rows above 0.
pub(super) fn most(motion: &[Motion], of: impl Fn(&Motion) -> f64) -> f64 {
    quantile(motion.iter().map(of).filter(|number| *number > 0.0).collect(), MOST_ROWS).unwrap_or(0.0)
}

/// Reports speeds and turn rates that no vehicle can have.
pub(super) fn speeds(motion: &[Motion], simulated: bool, findings: &mut Findings) {
    let speed = most(motion, |row| row.speed_mps.unwrap_or(0.0));
    let turn = most(motion, |row| row.turn_radps.abs());
    let across = most(motion, |row| row.speed_mps.unwrap_or(0.0) * row.turn_radps.abs());
    if speed > SPEED_MPS {
        findings.warn(
            "speed-unit",
            "odometry.csv",
            format!("speeds reach {} m/s, no such vehicle is faster than {SPEED_MPS} m/s", short(speed)),
            "speeds are in metres a second: divide mm/s by 1000, cm/s by 100, km/h by 3.6",
        );
    }
    if turn > TURN_RADPS {
        findings.warn(
            "turn-unit",
            "odometry.csv",
            format!("the vehicle turns with {} rad/s, more than once in a second", short(turn)),
            "turn rates are in radians a second, steering angles in radians: multiply degrees by 0.0174533",
        );
    } else if !simulated && speed <= SPEED_MPS && across > ACROSS_MPS2 {
        findings.warn(
            "turn-unit",
            "odometry.csv",
            format!("speed times turn rate reaches {} m/s², more than gravity holds on the ground", short(across)),
            "turn rates are in radians a second, steering angles in radians (multiply degrees by 0.0174533), speeds in metres a \
             second; check the wheelbase too",
        );
    }
}

/// Position by dead reckoning and truth at a scan.
struct Both<K: Kind> {
    reckoned: K::Position,
    truth: K::Position,
}

/// RMSE of dead reckoning, m; `None` without truth.
pub(super) fn beside_truth<K: Kind>(
    log: &K::Log,
    reckoned: &[K::Reckoned],
    reach_m: f64,
    way_m: Option<f64>,
    findings: &mut Findings,
) -> Option<f64> {
    let both: Vec<Both<K>> = K::scans(log)
        .iter()
        .zip(reckoned)
        .filter_map(|(scan, reckoned)| {
            let truth = truth::at(K::truth(log), scan.t_s)?;
            let place = Coordinates::with(|k| reckoned.as_ref()[k]);
            Some(Both { reckoned: place, truth: truth.position })
        })
        .collect();
    let first = both.first()?;
    let squares: f64 = both.iter().map(|one| distance(&one.reckoned, &one.truth).powi(2)).sum();
    let rmse_m = (squares / both.len() as f64).sqrt();
    let start_m = distance(&first.reckoned, &first.truth);
    if start_m > PIECE_REACH * reach_m {
        findings.warn(
            "start-place",
            "log.toml, key initial_pose",
            format!("at the first scan with truth dead reckoning is {} m from it", short(start_m)),
            "initial_pose is the pose at the first row of odometry, or scan, in the frame of truth.csv",
        );
    }
    let pieces = pieces(&both, PIECE_REACH * reach_m);
    if pieces.len() < PIECES {
        return Some(rmse_m);
    }
    let sums = pieces.iter().fold([0.0, 0.0], |[a, b], piece| [a + length(&piece[0]), b + length(&piece[1])]);
    let ratio = sums[0] / sums[1];
    if !(1.0 / WAY_RATIO..=WAY_RATIO).contains(&ratio) {
        let near = |(unit, _): &&(f64, &str)| (ratio / unit).ln().abs() < 0.25;
        let names: Vec<&str> = UNITS.iter().filter(near).map(|(_, name)| *name).collect();
        let like = if names.is_empty() { String::new() } else { format!("; this looks like {}", names.join(" or ")) };
        findings.warn(
            "way-unit",
            "odometry.csv",
            format!("the way by odometry is {} times the true one{like}", short(ratio)),
            "check the units of speeds, times and truth: metres, seconds, metres a second",
        );
        return Some(rmse_m);
    }
    directions(&pieces, findings);
    let way_m = way_m.unwrap_or(0.0);
    if rmse_m > LOST_SHARE * way_m && rmse_m > reach_m {
        findings.warn(
            "dead-reckoning",
            "odometry.csv",
            format!(
                "dead reckoning is {} m off (RMSE), {} of a way of {} m",
                short(rmse_m),
                percent(rmse_m / way_m),
                short(way_m)
            ),
            "check sign and unit of the turn, the wheelbase, the initial heading, and that x and y of the truth are not exchanged",
        );
    }
    Some(rmse_m)
}

/// Chords of dead reckoning and truth between the same scans, m.
fn pieces<K: Kind>(both: &[Both<K>], least_m: f64) -> Vec<[[f64; 2]; 2]> {
    let mut pieces = Vec::new();
    let Some(mut from) = both.first() else { return pieces };
    for to in both {
        let chord = |a: &K::Position, b: &K::Position| [0, 1].map(|k| b.as_ref()[k] - a.as_ref()[k]);
        let piece = [chord(&from.reckoned, &to.reckoned), chord(&from.truth, &to.truth)];
        if piece.iter().any(|one| length(one) >= least_m) {
            pieces.push(piece);
            from = to;
        }
    }
    pieces
}

fn length(chord: &[f64; 2]) -> f64 {
    libm::hypot(chord[0], chord[1])
}

fn directions(pieces: &[[[f64; 2]; 2]], findings: &mut Findings) {
    let turns = |of: usize| -> Vec<f64> {
        let direction = |piece: &[[f64; 2]; 2]| libm::atan2(piece[of][1], piece[of][0]);
        pieces.windows(2).map(|pair| wrap(direction(&pair[1]) - direction(&pair[0]))).collect()
    };
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (own, true_ones) = (turns(0), turns(1));
    let correlation = product(&own, &true_ones) / (product(&own, &own) * product(&true_ones, &true_ones)).sqrt();
    if correlation < TURNED_AROUND {
        findings.warn(
            "turn-sign",
            "odometry.csv",
            format!("it turns left where the truth turns right: correlation of the turns {}", short(correlation)),
            "steering and turn rates are positive to the left, headings grow from the x axis to the y axis: change the sign",
        );
        return;
    }
    // Direction of the first segment, before dead reckoning has drifted.
    let off = pieces[0];
    let off_rad = wrap(libm::atan2(off[0][1], off[0][0]) - libm::atan2(off[1][1], off[1][0]));
    if off_rad.abs() > START_RAD {
        findings.warn(
            "start-heading",
            "log.toml, key initial_pose",
            format!("dead reckoning leaves the start {} rad to the left of the truth", short(off_rad)),
            "the third number of initial_pose is the heading in radians, from the x axis to the y axis; check the truth's axes too",
        );
    }
}

/// Reports headings of the truth beyond a whole turn: in degrees, or unwrapped.
pub(super) fn whole_turns<K: Kind>(log: &K::Log, findings: &mut Findings) {
    let truth = K::truth(log);
    let most = truth.iter().filter_map(|row| row.heading_rad).fold(0.0_f64, |most, heading| most.max(heading.abs()));
    if most <= 2.0 * PI + 1e-3 {
        return;
    }
    // Where the truth moves, its heading is the direction of motion, or the opposite one.
    let along = |unit: f64| {
        let cosines = truth.windows(2).filter_map(|pair| {
            let step = [0, 1].map(|k| pair[1].position.as_ref()[k] - pair[0].position.as_ref()[k]);
            let direction = (length(&step) > 0.0).then(|| libm::atan2(step[1], step[0]))?;
            Some(libm::cos(pair[0].heading_rad? * unit - direction))
        });
        let (sum, count) = cosines.fold((0.0, 0), |(sum, count), cosine| (sum + cosine, count + 1));
        (sum / f64::from(count.max(1))).abs()
    };
    // Unwrapped headings agree as they are; on a nearly straight path small headings agree in either unit.
    if along(PI / 180.0) > along(1.0) + CLEARLY {
        findings.warn(
            "heading-unit",
            "truth.csv, column heading_rad",
            format!("headings reach {}, and agree with the way when they are taken as degrees", short(most)),
            "headings are in radians: multiply by 0.0174533; errors of the heading mean nothing before",
        );
    }
}
