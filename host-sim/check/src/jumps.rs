//! Positions that jump away from the trajectory and back: a reference that lost its lock, or a receiver with a gross error.

use super::finding::{Findings, percent, quantile, short};
use scphd_log::log::{Log, PoseFix, TruePose};
use scphd_log::truth::MAX_GAP_S;
use scphd_log::vehicle::Way;

/// A position jumps if it moves by more than this multiple of the distance of the odometry, plus the greatest of: a multiple of
/// the 95 % quantile of the deviations (truth), this share of the sensor's range, stated standard deviations.
const WAY_TIMES: f64 = 1.3;
const NOISE_TIMES: f64 = 10.0;
const REACH: f64 = 0.15;
const SIGMAS: f64 = 6.0;
/// The same multiple for fixes, which scatter more than the truth.
const FIX_NOISE_TIMES: f64 = 2.0;
/// A step over a longer time, s, or over this number of usual intervals, is a gap; it is not judged.
const GAP_INTERVALS: f64 = 5.0;
/// With more than this share of jumps, all are noise.
const JUMPS: f64 = 0.05;
/// Least number of positions away that is reported; a gate rejects fewer.
const AWAY: usize = 3;

/// Positions in the order of time, each with the distance of the odometry until then, m.
struct Track {
    rows: Vec<(f64, [f64; 2], f64)>,
}

impl Track {
    fn of(log: &Log, rows: impl Iterator<Item = (f64, [f64; 2])>) -> Self {
        let way = Way::of(log);
        let (mut driven_m, mut last) = (0.0, None);
        let row = |(t_s, position)| {
            let [x, y, _] = way.at(t_s);
            let step_m = last.replace([x, y]).map_or(0.0, |last: [f64; 2]| libm::hypot(x - last[0], y - last[1]));
            driven_m += step_m;
            (t_s, position, driven_m)
        };
        Self { rows: rows.map(row).collect() }
    }

    fn step_m(&self, from: usize, to: usize) -> f64 {
        let (a, b) = (self.rows[from].1, self.rows[to].1);
        libm::hypot(b[0] - a[0], b[1] - a[1])
    }

    fn driven_m(&self, from: usize, to: usize) -> f64 {
        self.rows[to].2 - self.rows[from].2
    }

    /// The 95 % quantile of the differences between steps of the positions and of the odometry, m.
    fn noise_m(&self) -> f64 {
        let off = (1..self.rows.len()).map(|to| (self.step_m(to - 1, to) - self.driven_m(to - 1, to)).abs());
        quantile(off.collect(), 0.95).unwrap_or(0.0)
    }

    /// Which rows are away, where a jump is a step of more than `least_m` plus the distance of the odometry. Rows before the
    /// first jump and behind the last one are away only with `at_rims`, or if they repeat one position.
    fn away(&self, least_m: f64, at_rims: bool) -> Vec<bool> {
        let mut away = vec![false; self.rows.len()];
        let jumps = |from: usize, to: usize| self.step_m(from, to) > least_m + WAY_TIMES * self.driven_m(from, to);
        let interval_s = |to: usize| self.rows[to].0 - self.rows[to - 1].0;
        let usual_s = quantile((1..self.rows.len()).map(interval_s).collect(), 0.5).unwrap_or(0.0);
        let is_gap = |to: usize| interval_s(to) > MAX_GAP_S.max(GAP_INTERVALS * usual_s);
        let starts: Vec<usize> = (1..self.rows.len()).filter(|to| !is_gap(*to) && jumps(to - 1, *to)).collect();
        if starts.is_empty() || starts.len() as f64 > JUMPS * self.rows.len() as f64 + 2.0 {
            return away;
        }
        // Parts between the jumps.
        let edges: Vec<usize> = [0].into_iter().chain(starts).chain([self.rows.len()]).collect();
        let parts: Vec<[usize; 2]> = edges.windows(2).map(|edge| [edge[0], edge[1]]).collect();
        let stands = |[from, until]: [usize; 2]| (from..until).all(|row| self.rows[row].1 == self.rows[from].1);
        let mut good: Option<usize> = None;
        for (place, &[from, until]) in parts.iter().enumerate() {
            let is_short = 2 * (until - from) < self.rows.len();
            let returns = good.is_some_and(|good| {
                let later = parts[place + 1..].iter().map(|part| part[0]);
                is_short && jumps(good, from) && later.take(4).any(|back| !jumps(good, back))
            });
            // The first and the last part have no position to return to. They are away if they repeat one position.
            let is_rim =
                (place == 0 || place + 1 == parts.len()) && (at_rims || stands([from, until])) && until - from > 1;
            if returns || (is_rim && is_short) {
                away[from..until].fill(true);
            } else {
                good = Some(until - 1);
            }
        }
        // Positions that repeated while the odometry drove were not measured: all but the first.
        for &[from, until] in &parts[..parts.len() - 1] {
            let last = until - 1;
            let first = (from..until).rev().take_while(|row| self.rows[*row].1 == self.rows[last].1).last();
            if let Some(first) = first.filter(|first| !away[last] && self.driven_m(*first, last) > least_m) {
                away[first + 1..until].fill(true);
            }
        }
        away
    }
}

/// Indices of the false rows of the truth.
pub(super) fn false_truth(log: &Log) -> Vec<usize> {
    let reach_m = log.sensors().map(|(_, sensor, _)| sensor.range_max_m).fold(0.0, f64::max);
    let track = Track::of(log, log.truth.iter().map(|row| (row.t_s, row.position)));
    let least_m = (NOISE_TIMES * track.noise_m()).max(SIGMAS * log.truth_sigma_m).max(REACH * reach_m);
    // A reference without a lock writes zeros, at any number of times.
    let is_zero = |row: &TruePose| row.position == [0.0; 2] && row.heading_rad.is_none_or(|heading| heading == 0.0);
    let jumps = |from: usize, to: usize| track.step_m(from, to) > least_m + WAY_TIMES * track.driven_m(from, to);
    let mut zeros = vec![false; log.truth.len()];
    let mut from = 0;
    while from < zeros.len() {
        let until = (from..zeros.len()).find(|row| !is_zero(&log.truth[*row])).unwrap_or(zeros.len());
        let is_away = || (from > 0 && jumps(from - 1, from)) || (until < zeros.len() && jumps(until - 1, until));
        if until > from && is_away() {
            zeros[from..until].fill(true);
        }
        from = until + 1;
    }
    let kept: Vec<usize> = (0..log.truth.len()).filter(|row| !zeros[*row]).collect();
    let rest = Track::of(log, kept.iter().map(|row| (log.truth[*row].t_s, log.truth[*row].position)));
    let least_m = (NOISE_TIMES * rest.noise_m()).max(SIGMAS * log.truth_sigma_m).max(REACH * reach_m);
    let away = rest.away(least_m, false);
    let is_away = |row: &usize| zeros[*row] || kept.binary_search(row).is_ok_and(|place| away[place]);
    (0..log.truth.len()).filter(is_away).collect()
}

/// The log without these rows of the truth, by index.
pub(super) fn without(log: &Log, found: &[usize]) -> Log {
    let mut log = log.clone();
    let mut row = 0..;
    log.truth.retain(|_| row.next().is_some_and(|row| found.binary_search(&row).is_err()));
    log
}

/// Reports the false rows of the truth.
pub(super) fn truth(log: &Log, found: &[usize], findings: &mut Findings) {
    let Some(&first) = found.first() else { return };
    let TruePose { t_s, position, .. } = log.truth[first];
    findings.warn(
        "truth-jumps",
        "truth.csv",
        format!(
            "{} of {} rows are no way that the vehicle drives, {}: they jump away and back, or stand still and then jump; the first is at {} s, at x = {} m, y = {} m",
            found.len(),
            log.truth.len(),
            percent(found.len() as f64 / log.truth.len() as f64),
            short(t_s),
            short(position[0]),
            short(position[1])
        ),
        "leave out rows that the reference wrote without a lock; a replay does not score them",
    );
}

/// Reports positions of a receiver that are away for a while.
pub(super) fn fixes(log: &Log, findings: &mut Findings) {
    let Some(sigma_m) = log.fix_noise.position_sigma_m else { return };
    let positions = log.fixes.iter().filter_map(|fix| match fix.measured {
        PoseFix::Position(position) => Some((fix.t_s, position)),
        PoseFix::Heading(_) => None,
    });
    let track = Track::of(log, positions);
    let away = track.away((SIGMAS * sigma_m).max(FIX_NOISE_TIMES * track.noise_m()), true);
    let mut spells: Vec<[usize; 2]> = Vec::new();
    for row in (0..away.len()).filter(|row| away[*row]) {
        match spells.last_mut() {
            Some([_, last]) if *last + 1 == row => *last = row,
            _ => spells.push([row, row]),
        }
    }
    spells.retain(|[from, to]| to - from + 1 >= AWAY);
    let Some(&[from, to]) = spells.iter().max_by_key(|[from, to]| to - from) else { return };
    findings.warn(
        "fix-jump",
        "fixes.csv, columns x_m and y_m",
        format!(
            "{} positions from {} s to {} s lie away from the way of the others, by {} m where they part{}",
            to - from + 1,
            short(track.rows[from].0),
            short(track.rows[to].0),
            short(if from > 0 { track.step_m(from - 1, from) } else { track.step_m(to, to + 1) }),
            if spells.len() > 1 { format!("; {} such times in all", spells.len()) } else { String::new() }
        ),
        "leave them out: after patience_s (7 s) a filter takes positions that agree with each other for right",
    );
}
