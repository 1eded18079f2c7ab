//! Whether the scans have the odometry's clock, without any truth.
//!
//! Detections of one scan are carried to a later one as [`agreement`](super::agreement) does, once by the odometry at the times of both scans, once by
//! that at times which are earlier or later by a trial shift. A detection counts where the two put it to places farther apart than
//! gates reach: then a later detection is near one of them at most.

use super::finding::{Findings, percent, short};
use super::reading::AS_WRITTEN;
use super::sight::Sight;
use scphd_log::log::Log;
use scphd_log::vehicle::Way;

/// Shifts that are tried to either side, s.
const TRIALS_S: [f64; 11] = [0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0, 4.0, BEYOND_S];
/// At the end of the trials a best one is no peak: odometry is in doubt, not its clock.
const BEYOND_S: f64 = 5.0;
/// Pairs of scans that are looked at.
const PAIRS: usize = 1000;
/// A shift has to bring this many times the detections that meet one, so many of them, and beyond chance by so many standard deviations.
const TIMES: f64 = 1.5;
const DETECTIONS: usize = 50;
const SIGNIFICANT: f64 = 6.0;
/// At least this share of what meets one where the shift makes no difference: the right times make all alike.
const LEAST_OF_USUAL: f64 = 0.5;

/// Detections that tell a shift from none: how many, how many met one as the times are written, and how many with the shift.
#[derive(Debug, Clone, Copy, Default)]
struct Told {
    all: usize,
    as_written: usize,
    shifted: usize,
    /// Of detections that both put to the same place: how many, and how many met one.
    alike: usize,
    alike_met: usize,
}

impl Told {
    fn share(self, met: usize) -> f64 {
        met as f64 / self.all.max(1) as f64
    }

    /// Whether the shift is far better, and about as good as where there is nothing to tell.
    fn is_for_shift(self) -> bool {
        let (written, shifted) = (self.share(self.as_written), self.share(self.shifted));
        // Of exclusive events the difference has the variance of their sum.
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
    /// What is to be added to the times of the scans, s.
    seconds: f64,
    told: Told,
}

impl Shift {
    /// Share of the detections that tell which meet one.
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

/// The best shift, if any is far better than none.
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

/// Two scans, and what the times as they are written make of the detections of the first.
struct Pair {
    places: [usize; 2],
    /// Those that are in view of the second then: as detected, as carried there, and whether that meets one.
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
