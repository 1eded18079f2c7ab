//! Whether scans and odometry have the same clock. Needs no truth.
//!
//! Detections of one scan are transformed to a later one as in [`agreement`](super::agreement), once with the odometry at the
//! times of both scans, and once at times with a trial shift. A detection counts if the two results are farther apart than two
//! gates: then a later detection can match only one of them.

use super::finding::{Findings, percent, short};
use super::reading::AS_WRITTEN;
use super::sight::Sight;
use scphd_log::log::Log;
use scphd_log::vehicle::Way;

/// Shifts that are tried, to both sides, s.
const TRIALS_S: [f64; 11] = [0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0, 4.0, BEYOND_S];
/// The longest shift, s. If it is the best one there is no peak: the odometry is wrong, not its clock.
const BEYOND_S: f64 = 5.0;
/// Greatest number of pairs of scans.
const PAIRS: usize = 1000;
/// A shift is accepted with at least this ratio of matches, this number of them, and this number of standard deviations.
const TIMES: f64 = 1.5;
const DETECTIONS: usize = 50;
const SIGNIFICANT: f64 = 6.0;
/// Least share of matches divided by that of the detections that the shift does not move: with the right times both are equal.
const LEAST_OF_USUAL: f64 = 0.5;

/// Detections that distinguish a shift from none: their number, and the numbers that match as written and with the shift.
#[derive(Debug, Clone, Copy, Default)]
struct Told {
    all: usize,
    as_written: usize,
    shifted: usize,
    /// Number of the detections that the shift does not move, and of those among them that match.
    alike: usize,
    alike_met: usize,
}

impl Told {
    fn share(self, met: usize) -> f64 {
        met as f64 / self.all.max(1) as f64
    }

    /// Whether the shift is far better than none, and about as good as for the detections that it does not move.
    fn is_for_shift(self) -> bool {
        let (written, shifted) = (self.share(self.as_written), self.share(self.shifted));
        // For exclusive events, the variance of the difference is that of the sum.
        let chance = ((written + shifted) / self.all.max(1) as f64).sqrt();
        let usual = self.alike_met as f64 / self.alike.max(1) as f64;
        self.shifted >= DETECTIONS
            && shifted > TIMES * written
            && shifted - written > SIGNIFICANT * chance
            && shifted > LEAST_OF_USUAL * usual
    }
}

/// A shift that is far better than none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shift {
    /// Time to add to those of the scans, s.
    seconds: f64,
    told: Told,
}

impl Shift {
    /// Share of the counted detections that match with the shift.
    pub(super) fn share(&self) -> f64 {
        self.told.share(self.told.shifted)
    }

    pub(super) fn tell(&self, findings: &mut Findings) {
        let (direction, scans, odometry) =
            if self.seconds > 0.0 { ("later", "early", "late") } else { ("earlier", "late", "early") };
        findings.warn(
            "clock-shift",
            "scans.csv, column t_s",
            format!(
                "of {} detections that tell, carried along by the odometry {} fall on later ones, but {} if the scans are taken \
                 about {} s {direction}",
                self.told.all,
                percent(self.told.share(self.told.as_written)),
                percent(self.share()),
                short(self.seconds.abs())
            ),
            format!(
                "scans are stamped too {scans}, or odometry too {odometry}: give both the time at which it was measured, of one clock"
            ),
        );
    }
}

/// The best shift; `None` unless it is far better than none.
pub(super) fn best(log: &Log, poses: &[[f64; 3]], pairs: &[[usize; 2]]) -> Option<Shift> {
    let way = Way::of(log);
    let sight = Sight::of(log, &AS_WRITTEN);
    let step = pairs.len().div_ceil(PAIRS).max(1);
    let pairs: Vec<[usize; 2]> = pairs.iter().step_by(step).copied().collect();
    let pairs: Vec<Pair> = pairs.iter().map(|&pair| Pair::of(log, &sight, poses, pair)).collect();
    let trials = TRIALS_S.into_iter().flat_map(|trial_s| [trial_s, -trial_s]);
    let shifts = trials.map(|seconds| Shift { seconds, told: told(log, &way, &sight, &pairs, seconds) });
    let gain = |shift: &Shift| shift.told.shifted - shift.told.as_written;
    let best = shifts.filter(|shift| shift.told.is_for_shift()).max_by_key(gain)?;
    (best.seconds.abs() < BEYOND_S).then_some(best)
}

/// Two scans, with the detections of the first transformed by the odometry at the times as written.
struct Pair {
    places: [usize; 2],
    /// Those in the view of the second scan: as detected, as transformed, and whether they match.
    carried: Vec<([f64; 2], [f64; 2], bool)>,
}

impl Pair {
    fn of(log: &Log, sight: &Sight<'_>, poses: &[[f64; 3]], [from, to]: [usize; 2]) -> Self {
        let (first, second) = (&log.scans[from], &log.scans[to]);
        let carried = first.detections.iter().filter_map(|&detection| {
            let written = sight.carried(first.sensor, [poses[from], poses[to]], detection)?;
            Some((detection, written, sight.meets(second, written)))
        });
        Self { places: [from, to], carried: carried.collect() }
    }
}

fn told(log: &Log, way: &Way<'_>, sight: &Sight<'_>, pairs: &[Pair], shift_s: f64) -> Told {
    let mut told = Told::default();
    for Pair { places, carried } in pairs {
        let [from, to] = *places;
        let poses = places.map(|place| way.at(log.scans[place].t_s + shift_s));
        for &(detection, written, is_met) in carried {
            let Some(shifted) = sight.carried(log.scans[from].sensor, poses, detection) else { continue };
            if !sight.are_apart(log.scans[from].sensor, written, shifted) {
                (told.alike, told.alike_met) = (told.alike + 1, told.alike_met + usize::from(is_met));
                continue;
            }
            told.all += 1;
            told.as_written += usize::from(is_met);
            told.shifted += usize::from(sight.meets(&log.scans[to], shifted));
        }
    }
    told
}
