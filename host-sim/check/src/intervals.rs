//! Intervals in which scans and odometry disagree: scans of two vehicles mixed, a vehicle that was carried, odometry that stands,
//! empty scans.
//!
//! All are found from detections transformed by the odometry to the next scans, a second or so later: its drift is small over
//! this time.

use super::finding::{Findings, percent, short};
use super::reading::AS_WRITTEN;
use super::sight::{Met, Sight};
use scphd_log::log::Log;

/// Number of next scans with which a scan is compared.
const NEXT: usize = 6;
/// Greatest time between compared scans, s: the odometry drifts.
const PATIENCE_S: f64 = 5.0;
/// Least usual share of matches in the next scan at which scans are judged.
const USUAL: f64 = 0.5;
/// A share of matches is good above this share of the usual one, and bad below that.
const GOOD: f64 = 0.6;
const BAD: f64 = 0.15;
/// Least number of detections for a moment.
const DETECTIONS: usize = 16;
/// The finding that the vehicle was carried needs at least this number of transformed detections across a moment, at most this
/// share of matches among them, and at least this share usually.
const ACROSS: usize = 40;
const NONE: f64 = 0.06;
const CERTAIN: f64 = 0.75;
/// Radius around a transformed detection in which nothing may match, in gates.
const FAR: f64 = 5.0;
/// Turns that are tried, rad.
const TURNS: [f64; 15] = [0.0, -0.7, -0.6, -0.5, -0.4, -0.3, -0.2, -0.1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7];
/// Scans of two sources: least share of scans that match not the next scan but a later one, within this number of scans.
const MIXED: f64 = 0.3;
const IN_TURN: usize = 4;
/// Least time for which odometry stands, s, and least time between the scans that are compared then, s.
const STANDS_S: f64 = 3.0;
const APART_S: f64 = 1.5;
/// Least number of detections in each of them: a single one may be of a moving object.
const TOGETHER: usize = 2;
/// Odometry stands if it moves by less than this share of the range. It may turn, for example with a gyroscope and unread wheels.
const STILL_REACH: f64 = 0.003;
/// Least number of consecutive empty scans, and their least duration, s,
const EMPTY: usize = 5;
const EMPTY_S: f64 = 3.0;
/// and the least number of detections expected in them.
const EXPECTED: f64 = 12.0;

pub(super) fn look_over(log: &Log, poses: &[[f64; 3]], findings: &mut Findings) {
    for sensor in 0..log.sensors().count() {
        let scans: Vec<usize> = (0..log.scans.len()).filter(|scan| log.scans[*scan].sensor == sensor).collect();
        let sight = Sight::of(log, &AS_WRITTEN);
        let one = OfSensor { log, poses, sight, scans };
        one.look_over(findings);
    }
}

struct OfSensor<'a> {
    log: &'a Log,
    poses: &'a [[f64; 3]],
    sight: Sight<'a>,
    /// Indices of the sensor's scans.
    scans: Vec<usize>,
}

impl OfSensor<'_> {
    fn t_s(&self, scan: usize) -> f64 {
        self.log.scans[self.scans[scan]].t_s
    }

    fn count(&self, scan: usize) -> usize {
        self.log.scans[self.scans[scan]].detections.len()
    }

    fn met(&self, from: usize, to: usize) -> Met {
        Met::of(self.log, &self.sight, self.poses, [self.scans[from], self.scans[to]])
    }

    /// Matches with the additional turn that gives the most: a vehicle that turns on the spot does so a little later than its
    /// odometry says, or by more.
    fn met_with_any_turn(&self, from: usize, to: usize) -> Met {
        let pair = [self.scans[from], self.scans[to]];
        let met = |turn_rad| Met::turned(self.log, &self.sight, self.poses, pair, 1.0, turn_rad);
        TURNS.into_iter().map(met).max_by_key(|met| met.met).unwrap_or_default()
    }

    fn look_over(&self, findings: &mut Findings) {
        let count = self.scans.len();
        let in_time = |from: usize, to: usize| to < count && self.t_s(to) - self.t_s(from) <= PATIENCE_S;
        // Empty scans do not count here.
        let is_seen = |from: usize, to: usize| in_time(from, to) && self.count(to) > 0;
        let table: Vec<[Met; NEXT]> = (0..count)
            .map(|from| {
                std::array::from_fn(|next| {
                    let to = from + next + 1;
                    if is_seen(from, to) { self.met(from, to) } else { Met::default() }
                })
            })
            .collect();
        let usual = table.iter().map(|row| row[0]).fold(Met::default(), Met::and).share();
        let with_any = table.iter().flatten().fold(Met::default(), |sum, one| sum.and(*one)).share();
        if self.never_drives() {
            // The usual share is not known then; with odometry that stands all detections should match.
            self.standing(USUAL, findings);
            return;
        }
        if self.are_mixed(&table, findings) || usual.max(with_any) < USUAL {
            return;
        }
        self.carried(&table, usual, findings);
        self.standing(usual, findings);
        self.empty(usual, findings);
    }

    /// Whether the odometry stands all the time.
    fn never_drives(&self) -> bool {
        self.log.odometry.iter().all(|row| row.speed_mps() == 0.0)
    }

    /// Whether the scans are of two mixed sources.
    fn are_mixed(&self, table: &[[Met; NEXT]], findings: &mut Findings) -> bool {
        let next = |row: &&[Met; NEXT]| row.iter().take(IN_TURN).copied().collect::<Vec<Met>>();
        let tells = |row: &&[Met; NEXT]| next(row).iter().filter(|met| met.carried >= 3).count() >= 2;
        let comes_back = |row: &&[Met; NEXT]| {
            let row = next(row);
            let part = row.iter().position(|met| met.carried >= 3 && met.share() <= BAD);
            part.is_some_and(|part| row[part..].iter().any(|met| met.carried >= 3 && met.share() >= GOOD))
        };
        let (all, back) = (table.iter().filter(tells).count(), table.iter().filter(tells).filter(comes_back).count());
        let share = back as f64 / all.max(1) as f64;
        if back < DETECTIONS || share < MIXED {
            return false;
        }
        findings.warn(
            "scans-mixed",
            "scans.csv",
            format!("{} of the scans do not fit the next one, but one after it: they are of two vehicles or sensors in turn", percent(share)),
            "write a folder for each vehicle; of several sensors of one vehicle a section [[sensors]] each, and the column sensor in scans.csv",
        );
        true
    }

    /// Reports a moment across which scans do not match, although they match before and after it.
    fn carried(&self, table: &[[Met; NEXT]], usual: f64, findings: &mut Findings) {
        let sum = |of: &dyn Fn(usize, usize) -> bool, around: usize| {
            let first = around.saturating_sub(2 * NEXT);
            let last = (around + 2 * NEXT + 1).min(table.len());
            let mut met = Met::default();
            for (from, row) in table.iter().enumerate().take(last).skip(first) {
                for (next, pair) in row.iter().enumerate() {
                    if of(from, from + next + 1) {
                        met = met.and(*pair);
                    }
                }
            }
            met
        };
        // Pairs across the step from a scan to the next one.
        let across = |scan: usize| sum(&|from, to| from <= scan && to > scan, scan);
        let before = |scan: usize| sum(&|_, to| to <= scan, scan);
        let after = |scan: usize| sum(&|from, _| from > scan, scan);
        let mut found: Vec<(usize, Met)> = Vec::new();
        for scan in 0..table.len().saturating_sub(1) {
            let met = across(scan);
            let fits = |met: Met| met.carried >= DETECTIONS && met.share() > GOOD * usual;
            let parts = met.carried >= ACROSS && met.share() < NONE * usual && usual > CERTAIN;
            if parts && fits(before(scan)) && fits(after(scan)) && self.are_far(scan, usual) {
                found.push((scan, met));
            }
        }
        let Some(&(scan, met)) = found.iter().min_by(|a, b| a.1.share().total_cmp(&b.1.share())) else { return };
        findings.warn(
            "carried-away",
            "scans.csv",
            format!(
                "between the scans at {} s and {} s the vehicle was carried, or odometry is missing: of {} detections that it carries across, {} fall on \
                 later ones, usual are {}{}",
                short(self.t_s(scan)),
                short(self.t_s(scan + 1)),
                met.carried,
                met.met,
                percent(usual),
                if found.len() > 1 { format!("; {} such places in all", found.len()) } else { String::new() }
            ),
            "cut the log there, and run the parts with an initial_pose each; or the second in the map of the first (--save-map, then --map and --locate)",
        );
    }

    /// Whether transformed detections have no match around them across the step from this scan to the next one, nor with a
    /// smaller or larger turn, because wheels slip, or do not follow a command.
    fn are_far(&self, scan: usize, usual: f64) -> bool {
        let first = (scan + 1).saturating_sub(NEXT);
        let pairs: Vec<[usize; 2]> = (first..=scan)
            .flat_map(|from| (scan + 1..=from + NEXT).map(move |to| [from, to]))
            .filter(|pair| pair[1] < self.scans.len())
            .map(|pair| pair.map(|scan| self.scans[scan]))
            .collect();
        TURNS.into_iter().all(|turn_rad| {
            let share = |gates: f64| {
                let met = |pair: &[usize; 2]| Met::turned(self.log, &self.sight, self.poses, *pair, gates, turn_rad);
                pairs.iter().map(met).fold(Met::default(), Met::and).share()
            };
            share(if turn_rad == 0.0 { FAR } else { 1.5 }) < 0.5 * usual
        })
    }

    /// Reports intervals in which the odometry stands, but the scans show motion.
    fn standing(&self, usual: f64, findings: &mut Findings) {
        let reach_m = self.log.sensors().nth(self.log.scans[self.scans[0]].sensor).map_or(1.0, |one| one.1.range_max_m);
        let stands = |from: usize, to: usize| {
            let [a, b] = [from, to].map(|scan| self.poses[self.scans[scan]]);
            libm::hypot(b[0] - a[0], b[1] - a[1]) < STILL_REACH * reach_m
        };
        let mut from = 0;
        let mut found: Vec<([usize; 2], Met)> = Vec::new();
        while from < self.scans.len() {
            let to = (from + 1..self.scans.len()).take_while(|to| stands(from, *to)).last().unwrap_or(from);
            if self.t_s(to) - self.t_s(from) >= STANDS_S {
                let mut met = Met::default();
                for one in from..to {
                    let other = (one + 1..=to).find(|other| self.t_s(*other) - self.t_s(one) >= APART_S);
                    if let Some(other) = other.filter(|other| self.count(one).min(self.count(*other)) >= TOGETHER) {
                        met = met.and(self.met_with_any_turn(one, other));
                    }
                }
                if met.carried >= 2 * DETECTIONS && met.share() < 0.5 * usual {
                    found.push(([from, to], met));
                }
            }
            from = to + 1;
        }
        let Some(&([from, to], met)) = found.iter().max_by_key(|one| one.1.carried) else { return };
        findings.warn(
            "odometry-stands",
            "odometry.csv",
            format!(
                "from {} s to {} s it says that the vehicle does not drive, but of {} detections only {} fall on later ones, usual are {}{}",
                short(self.t_s(from)),
                short(self.t_s(to)),
                met.carried,
                percent(met.share()),
                percent(usual),
                if found.len() > 1 { format!("; {} such times in all", found.len()) } else { String::new() }
            ),
            "write what the wheels did; where nothing is known, cut the log there",
        );
    }

    /// Reports consecutive empty scans although landmarks are in view.
    fn empty(&self, usual: f64, findings: &mut Findings) {
        let mut found: Vec<([usize; 2], f64)> = Vec::new();
        let mut from = 0;
        while from < self.scans.len() {
            let until = (from..self.scans.len()).find(|scan| self.count(*scan) > 0).unwrap_or(self.scans.len());
            if until - from >= EMPTY && self.t_s(until - 1) - self.t_s(from) >= EMPTY_S {
                let interval = || from..until;
                // From the landmarks in view before or after the interval, whichever give more.
                let before = from.checked_sub(2).map_or(0.0, |scan| self.expected([scan, scan + 1], interval()));
                let after = if until + 1 < self.scans.len() {
                    self.expected([until + 1, until], interval().rev())
                } else {
                    0.0
                };
                let expected = usual * before.max(after);
                if expected >= EXPECTED {
                    found.push(([from, until - 1], expected));
                }
            }
            from = until + 1;
        }
        let Some(&([from, to], expected)) = found.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
        findings.warn(
            "scans-empty",
            "detections.csv",
            format!(
                "{} scans in a row, from {} s to {} s, are empty, though about {} detections of landmarks in view were to be expected of them{}",
                to - from + 1,
                short(self.t_s(from)),
                short(self.t_s(to)),
                short(expected),
                if found.len() > 1 { format!("; {} such times in all", found.len()) } else { String::new() }
            ),
            "take scans that were not measured out of scans.csv: an empty one says that nothing is there",
        );
    }

    /// Number of expected detections: those of the second scan that match the first, transformed into the scans of the interval
    /// within the time in which odometry is good, and in view there.
    fn expected(&self, [first, second]: [usize; 2], interval: impl Iterator<Item = usize>) -> f64 {
        let of = |scan: usize| &self.log.scans[self.scans[scan]];
        let carried = |detection: [f64; 2], from: usize, to: usize| {
            self.sight.carried(of(from).sensor, [self.poses[self.scans[from]], self.poses[self.scans[to]]], detection)
        };
        let seen_twice: Vec<[f64; 2]> = of(second)
            .detections
            .iter()
            .filter(|one| carried(**one, second, first).is_some_and(|one| self.sight.meets(of(first), one)))
            .copied()
            .collect();
        let near = interval.take_while(|scan| (self.t_s(*scan) - self.t_s(second)).abs() <= PATIENCE_S);
        near.map(|scan| seen_twice.iter().filter(|one| carried(**one, second, scan).is_some()).count() as f64).sum()
    }
}
