//! Convention of the headings of truth and fixes, compared with the direction of motion.

use super::finding::{Findings, quantile, short};
use scphd_log::angle::wrap;
use scphd_log::log::{Log, Mounting, PoseFix};
use scphd_log::vehicle::Way;
use std::f64::consts::{FRAC_PI_2, PI};

/// A direction is taken over a distance of at least this share of the sensor's range and this number of standard deviations of
/// the positions, driven within this time, s.
const PIECE_REACH: f64 = 0.05;
const PIECE_SIGMAS: f64 = 15.0;
const PIECE_S: f64 = 20.0;
/// Least number of directions.
const PIECES: usize = 10;
/// Angles agree if the length of their mean vector is above this; a sign convention is right if its length exceeds the other's by
/// this.
const AGREE: f64 = 0.8;
const LONGER: f64 = 0.2;
/// Least deviation of headings that is reported, rad, and in standard errors.
const OFF_RAD: f64 = 0.12;
const ERRORS: f64 = 6.0;
/// Without positions, fixes are compared with the initial heading over this time, s. Least deviation, rad, and in standard errors
/// of the fitted line, whose slope is the bias of the odometry's turn rate.
const START_S: f64 = 20.0;
const START_OFF_RAD: f64 = 0.12;
const START_ERRORS: f64 = 8.0;
/// Turns are compared over segments of at least this angle, rad; a correlation below this means the opposite sign.
const TURN_RAD: f64 = 0.3;
const TURNED_AROUND: f64 = -0.5;
/// Greatest distance of an offset from that of a named convention, rad.
const NEAR_RAD: f64 = 0.25;
/// Least deviation of the initial heading, rad, increased by this bias of the odometry's turn rate, rad/s, times the time until
/// the first position; number of first segments that are used.
const START_RAD: f64 = 0.5;
const TURN_RADPS: f64 = 0.03;
const START_PIECES: usize = 6;

/// Headings from positions: the direction of motion in the map minus that in the vehicle's axes by the odometry. `turns` is −1
/// for odometry with the opposite sign of turns.
fn told(log: &Log, positions: &[(f64, [f64; 2])], sigma_m: f64, turns: f64) -> Vec<(f64, f64)> {
    let reach_m = log.sensors().map(|(_, sensor, _)| sensor.range_max_m).fold(0.0, f64::max);
    let (way, least_m) = (Way::of(log), (PIECE_REACH * reach_m).max(PIECE_SIGMAS * sigma_m));
    let mut told = Vec::new();
    let Some(mut from) = positions.first() else { return told };
    for to in positions {
        let (x, y) = (to.1[0] - from.1[0], to.1[1] - from.1[1]);
        let [a, b] = [from, to].map(|one| way.at(one.0));
        let driven_m = libm::hypot(b[0] - a[0], b[1] - a[1]);
        if to.0 - from.0 > PIECE_S {
            from = to;
        } else if libm::hypot(x, y) >= least_m {
            if (0.5..=2.0).contains(&(driven_m / libm::hypot(x, y))) {
                let own = wrap(libm::atan2(b[1] - a[1], b[0] - a[0]) - a[2]);
                told.push((from.0, wrap(libm::atan2(y, x) - turns * own)));
            }
            from = to;
        }
    }
    told
}

/// Length and direction of the mean of the unit vectors at these angles.
fn mean(angles: impl Iterator<Item = f64>) -> [f64; 2] {
    let (mut x, mut y, mut n) = (0.0, 0.0, 0.0_f64);
    for angle in angles {
        (x, y, n) = (x + libm::cos(angle), y + libm::sin(angle), n + 1.0);
    }
    [libm::hypot(x, y) / n.max(1.0), libm::atan2(y, x)]
}

/// Another convention of headings.
struct Convention {
    clockwise: bool,
    off_rad: f64,
}

impl Convention {
    /// Estimates the convention from pairs (written heading, right heading). `None` if the written ones are right.
    fn of(pairs: &[(f64, f64)]) -> Option<Self> {
        if pairs.len() < PIECES {
            return None;
        }
        let [left, right] = [1.0, -1.0].map(|sign| mean(pairs.iter().map(|(written, right)| written - sign * right)));
        if right[0] > AGREE && right[0] > left[0] + LONGER {
            return Some(Self { clockwise: true, off_rad: right[1] });
        }
        let error_rad = (2.0 * (1.0 - left[0]).max(0.0) / pairs.len() as f64).sqrt();
        let is_off = left[0] > AGREE && left[1].abs() > OFF_RAD.max(ERRORS * error_rad);
        is_off.then_some(Self { clockwise: false, off_rad: left[1] })
    }

    fn tell(&self, place: &str, code: &'static str, findings: &mut Findings) {
        let near = |angle: f64| wrap(self.off_rad - angle).abs() < NEAR_RAD;
        let (what, advice) = match (self.clockwise, near(FRAC_PI_2), near(0.0)) {
            (true, true, _) => (
                "headings are those of a compass, from north (the y axis) clockwise".to_owned(),
                "write 1.5708 minus the heading".to_owned(),
            ),
            (true, _, true) => ("headings grow clockwise".to_owned(), "change the sign of the headings".to_owned()),
            (true, ..) => (
                format!(
                    "headings grow clockwise, from a direction {} rad to the left of the x axis",
                    short(self.off_rad)
                ),
                format!("write {} minus the heading", short(self.off_rad)),
            ),
            (false, ..) => {
                let like = if near(PI) {
                    ": they point backwards"
                } else if near(FRAC_PI_2) || near(-FRAC_PI_2) {
                    ": they count from another axis"
                } else {
                    ": a declination, or a sensor that is turned"
                };
                (
                    format!(
                        "headings are {} rad to the left of where the vehicle looks by its way{like}",
                        short(self.off_rad)
                    ),
                    format!("take {} off the headings", short(self.off_rad)),
                )
            }
        };
        findings.warn(code, place, what, format!("headings are in radians, from the x axis to the y axis: {advice}"));
    }
}

/// Compares the headings of the truth with its positions.
pub(super) fn truth(log: &Log, findings: &mut Findings) {
    let positions: Vec<(f64, [f64; 2])> = log.truth.iter().map(|row| (row.t_s, row.position)).collect();
    let written = |t_s: f64| scphd_log::truth::at(&log.truth, t_s)?.heading_rad;
    let convention = |turns: f64| {
        let told = told(log, &positions, log.truth_sigma_m, turns);
        let pairs: Vec<(f64, f64)> = told.iter().filter_map(|(t_s, right)| Some((written(*t_s)?, *right))).collect();
        Convention::of(&pairs)
    };
    // If odometry with the opposite sign of turns would explain it, the odometry is wrong, not the truth.
    if let (Some(convention), Some(_)) = (convention(1.0), convention(-1.0)) {
        convention.tell("truth.csv, column heading_rad", "truth-heading", findings);
    }
}

/// Compares the headings of fixes with their positions, or with the odometry.
pub(super) fn fixes(log: &Log, findings: &mut Findings) {
    let headings: Vec<(f64, f64)> = log
        .fixes
        .iter()
        .filter_map(|fix| match fix.measured {
            PoseFix::Heading(heading) => Some((fix.t_s, heading)),
            PoseFix::Position(_) => None,
        })
        .collect();
    if headings.len() < PIECES {
        return;
    }
    let way = Way::of(log);
    let place = "fixes.csv, column heading_rad";
    let told = told(log, &positions(log), log.fix_noise.position_sigma_m.unwrap_or(0.0), 1.0);
    // The heading at the time of a segment: the last one, and the turn since by the odometry.
    let at = |t_s: f64| {
        let (then_s, heading) = *headings.get(headings.partition_point(|one| one.0 <= t_s).checked_sub(1)?)?;
        (t_s - then_s < PIECE_S).then(|| (heading, wrap(way.at(t_s)[2] - way.at(then_s)[2])))
    };
    let beside: Vec<(f64, f64)> = told
        .iter()
        .filter_map(|(t_s, right)| at(*t_s).map(|(heading, turned)| (heading, wrap(right - turned))))
        .collect();
    if beside.len() >= PIECES {
        if let Some(convention) = Convention::of(&beside) {
            convention.tell(place, "fix-heading", findings);
        }
        return;
    }
    let clockwise = turn_apart(&headings, &way);
    let sign = if clockwise { -1.0 } else { 1.0 };
    let early = headings.iter().take_while(|one| one.0 - headings[0].0 <= START_S);
    let off: Vec<(f64, f64)> = early.map(|(t_s, heading)| (*t_s, heading - sign * way.at(*t_s)[2])).collect();
    let [length, middle_rad] = mean(off.iter().map(|one| one.1));
    let around: Vec<(f64, f64)> = off.iter().map(|(t_s, off)| (*t_s, wrap(off - middle_rad))).collect();
    let Some([more_rad, error_rad]) = at_start(&around, log.odometry.first().map_or(0.0, |row| row.t_s)) else {
        return;
    };
    let off_rad = wrap(middle_rad + more_rad);
    let least_rad = START_OFF_RAD.max(START_ERRORS * error_rad);
    if clockwise || (length > AGREE && off_rad.abs() > least_rad) {
        Convention { clockwise, off_rad }.tell(place, "fix-heading", findings);
    }
}

/// Value of the line through (time, angle) at the start, and its standard error there, rad.
fn at_start(angles: &[(f64, f64)], start_s: f64) -> Option<[f64; 2]> {
    let n = angles.len() as f64;
    let over = |of: &dyn Fn(&(f64, f64)) -> f64| angles.iter().map(of).sum::<f64>();
    let (t_s, mean_rad) = (over(&|one| one.0) / n, over(&|one| one.1) / n);
    let squares = over(&|one| (one.0 - t_s).powi(2));
    let slope = over(&|one| (one.0 - t_s) * one.1) / squares;
    let rest = over(&|one| (one.1 - mean_rad - slope * (one.0 - t_s)).powi(2)) / (n - 2.0);
    let error_rad = (rest * (1.0 / n + (start_s - t_s).powi(2) / squares)).sqrt();
    (angles.len() > 2 && squares > 0.0).then_some([mean_rad + slope * (start_s - t_s), error_rad])
}

/// Whether headings and odometry turn in opposite directions.
fn turn_apart(headings: &[(f64, f64)], way: &Way<'_>) -> bool {
    let mut turns: Vec<[f64; 2]> = Vec::new();
    let mut turn = [0.0; 2];
    for pair in headings.windows(2) {
        turn[0] += wrap(pair[1].1 - pair[0].1);
        turn[1] += wrap(way.at(pair[1].0)[2] - way.at(pair[0].0)[2]);
        if turn[1].abs() > TURN_RAD {
            turns.push(turn);
            turn = [0.0; 2];
        }
    }
    let product = |a: usize, b: usize| turns.iter().map(|turn| turn[a] * turn[b]).sum::<f64>();
    turns.len() >= PIECES && product(0, 1) < TURNED_AROUND * (product(0, 0) * product(1, 1)).sqrt()
}

/// Positions of fixes, without the offset of the antenna.
fn positions(log: &Log) -> Vec<(f64, [f64; 2])> {
    let position = |fix: &scphd_log::log::Fix| match fix.measured {
        PoseFix::Position(position) => Some((fix.t_s, position)),
        PoseFix::Heading(_) => None,
    };
    log.fixes.iter().filter_map(position).collect()
}

/// Error of the initial heading, rad: the direction of the first positions of fixes minus it. `None` unless far above noise.
pub(super) fn start_off(log: &Log) -> Option<f64> {
    let sigma_m = log.fix_noise.position_sigma_m?;
    let way = Way::of(log);
    let noise = &log.fix_noise;
    let antenna = Mounting { forward_m: noise.forward_m, left_m: noise.left_m, yaw_rad: 0.0 };
    let positions = positions(log);
    let least_m = PIECE_SIGMAS * sigma_m;
    let mut off = Vec::new();
    let mut from = positions.first()?;
    for to in &positions {
        let [a, b] = [from, to].map(|one| antenna.seat(way.at(one.0)));
        let (own, measured) = ([b[0] - a[0], b[1] - a[1]], [to.1[0] - from.1[0], to.1[1] - from.1[1]]);
        let [own_m, measured_m] = [own, measured].map(|chord| libm::hypot(chord[0], chord[1]));
        if own_m < least_m {
            continue;
        }
        if (0.5..=2.0).contains(&(measured_m / own_m)) {
            off.push(wrap(libm::atan2(measured[1], measured[0]) - libm::atan2(own[1], own[0])));
        }
        from = to;
        if off.len() == START_PIECES {
            break;
        }
    }
    let [length, off_rad] = mean(off.iter().copied());
    // Until the first position the odometry itself drifts.
    let least_rad = START_RAD + TURN_RADPS * (positions.first()?.0 - log.odometry.first()?.t_s).max(0.0);
    let last = quantile(off.iter().map(|one| wrap(one - off_rad).abs()).collect(), 1.0)?;
    (off.len() == START_PIECES && length > AGREE && last < START_RAD && off_rad.abs() > least_rad).then_some(off_rad)
}

/// Reports an initial heading that disagrees with the positions.
pub(super) fn start(log: &Log, findings: &mut Findings) {
    let Some(off_rad) = start_off(log) else { return };
    let heading = log.initial_pose[2];
    findings.warn(
        "start-heading",
        "log.toml, key initial_pose",
        format!("by the first positions of fixes.csv the vehicle looks {} rad to the left of the heading {}", short(off_rad), short(heading)),
        format!(
            "write {:.3} for the third number of initial_pose, the heading in radians, from the x axis to the y axis; a replay does",
            wrap(heading + off_rad)
        ),
    );
}
