//! Motion to the side that the odometry of a unicycle cannot express: by the truth, the vehicle moves across its heading.
//!
//! A filter explains such a motion by turns, in the same direction all the time, because it has no other explanation for
//! landmarks that move sideways in the view.

use super::finding::{Findings, percent, short};
use scphd_log::angle::wrap;
use scphd_log::log::{Log, Vehicle};
use scphd_log::vehicle::Way;

/// A piece of the drive ends after this share of the sensor's range and this number of standard deviations of the truth, or after
/// this turn, rad. Left out are pieces that last longer, s, turn by more, rad, or are more than this many times as long by the
/// odometry: the linear fit does not hold for them.
const PIECE_REACH: f64 = 0.05;
const PIECE_SIGMAS: f64 = 15.0;
const PIECE_RAD: f64 = 0.3;
const PIECE_S: f64 = 20.0;
const TURN_RAD: f64 = 1.0;
const TIMES: f64 = 2.0;
/// Least number of pieces.
const PIECES: usize = 40;
/// Least sideways motion as a share of the distance: a mounting is usually right within a degree. It must be this number of
/// standard errors, and at least half of the least share in each of this number of parts of the log.
const SHARE: f64 = 0.02;
const ERRORS: f64 = 6.0;
const PARTS: usize = 4;
/// From this share on, the finding is `truth-heading`.
const MOST_SHARE: f64 = 0.12;

/// A piece of the drive, in the vehicle's axes at its start.
struct Piece {
    /// Distance ahead and sine of the turn by the odometry: the derivatives of the distance to the left with respect to a speed
    /// to the left, as a share of the speed and in metres times the turn rate.
    ahead_m: f64,
    turn: f64,
    /// Distance to the left by the truth minus that by the odometry, m.
    left_m: f64,
}

/// The pose `to`, relative to `from`.
fn relative(from: [f64; 3], to: [f64; 3]) -> [f64; 3] {
    let (x, y) = (to[0] - from[0], to[1] - from[1]);
    let (sine, cosine) = (libm::sin(from[2]), libm::cos(from[2]));
    [cosine * x + sine * y, cosine * y - sine * x, wrap(to[2] - from[2])]
}

/// The pieces within the odometry.
fn pieces(log: &Log, reach_m: f64) -> Vec<Piece> {
    let (way, least_m) = (Way::of(log), (PIECE_REACH * reach_m).max(PIECE_SIGMAS * log.truth_sigma_m));
    let (Some(first), Some(last)) = (log.odometry.first(), log.odometry.last()) else { return Vec::new() };
    let mut poses = log.truth.iter().filter(|row| (first.t_s..=last.t_s).contains(&row.t_s)).filter_map(|row| {
        let [x, y] = row.position;
        Some((row.t_s, [x, y, row.heading_rad?]))
    });
    let mut pieces = Vec::new();
    let Some(mut from) = poses.next() else { return pieces };
    for to in poses {
        let truth = relative(from.1, to.1);
        let chord_m = libm::hypot(truth[0], truth[1]);
        if chord_m < least_m && truth[2].abs() < PIECE_RAD {
            continue;
        }
        let [ahead_m, left_m, turn_rad] = relative(way.at(from.0), way.at(to.0));
        let is_like = libm::hypot(ahead_m, left_m) < TIMES * chord_m.max(least_m);
        if is_like && to.0 - from.0 < PIECE_S && truth[2].abs() < TURN_RAD {
            pieces.push(Piece { ahead_m, turn: libm::sin(turn_rad), left_m: truth[1] - left_m });
        }
        from = to;
    }
    pieces
}

/// Motion to the left: as a share of the speed, and in metres times the turn rate.
struct Sideways {
    share: f64,
    share_error: f64,
    arm_m: f64,
}

impl Sideways {
    /// The least-squares fit; `None` if the pieces do not determine it.
    fn of(pieces: &[Piece]) -> Option<Self> {
        let sum = |of: fn(&Piece) -> f64| pieces.iter().map(of).sum::<f64>();
        let (aa, at, tt) = (sum(|p| p.ahead_m * p.ahead_m), sum(|p| p.ahead_m * p.turn), sum(|p| p.turn * p.turn));
        let (al, tl) = (sum(|p| p.ahead_m * p.left_m), sum(|p| p.turn * p.left_m));
        // A vehicle that does not turn has no arm.
        let (at, tt) = if tt > 0.0 { (at, tt) } else { (0.0, 1.0) };
        let determinant = aa * tt - at * at;
        let (share, arm_m) = ((tt * al - at * tl) / determinant, (aa * tl - at * al) / determinant);
        let rest = |p: &Piece| (p.left_m - share * p.ahead_m - arm_m * p.turn).powi(2);
        let variance = pieces.iter().map(rest).sum::<f64>() / pieces.len().checked_sub(2)? as f64;
        let share_error = (variance * tt / determinant).sqrt();
        share_error.is_finite().then_some(Self { share, share_error, arm_m })
    }
}

/// Reports a unicycle that, by the truth, moves sideways by more than the reach in all.
pub(super) fn look_over(log: &Log, reach_m: f64, findings: &mut Findings) {
    if !matches!(log.vehicle, Vehicle::Unicycle | Vehicle::UnicycleArc) {
        return;
    }
    let pieces = pieces(log, reach_m);
    if pieces.len() < PIECES {
        return;
    }
    let Some(Sideways { share, share_error, arm_m }) = Sideways::of(&pieces) else { return };
    let aside_m = share.abs() * pieces.iter().map(|piece| piece.ahead_m.abs()).sum::<f64>();
    let is_clear = (SHARE.max(ERRORS * share_error)..MOST_SHARE).contains(&share.abs()) && aside_m > reach_m;
    let mut parts = pieces.chunks(pieces.len().div_ceil(PARTS));
    if !is_clear || !parts.all(|part| Sideways::of(part).is_some_and(|one| one.share * share.signum() > 0.5 * SHARE)) {
        return;
    }
    findings.warn(
        "sideways",
        "odometry.csv",
        format!(
            "by the truth the vehicle moves to the {} by {} of its way, {} m in all, and {} m to the {} for each rad of a left turn: \
             a filter takes this for turns",
            if share > 0.0 { "left" } else { "right" },
            percent(share.abs()),
            short(aside_m),
            short(arm_m.abs()),
            if arm_m > 0.0 { "left" } else { "right" },
        ),
        format!(
            "write model = \"holonomic\" and a column vy_mps, the speed to the left: measured, or {} vx_mps + {} omega_radps; \
             if only the headings of the truth are turned, take {} rad off them",
            short(share),
            short(arm_m),
            short(-share),
        ),
    );
}
