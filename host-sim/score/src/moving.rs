//! Scores of moving landmarks: detection, position error and false tracks.

use crate::cutoff::Cutoff;
use scphd_log::dimensions::Coordinates;
use std::collections::BTreeMap;

/// Greatest distance of an estimate from its moving landmark, m.
///
/// It is larger than four standard deviations of a range in the simulations plus some decimetres of pose error, and small enough
/// not to confuse two objects a car's width apart. Order 1: the assignment with the least total distance, in which an unmatched
/// pair counts as the gate.
pub const GATE: Cutoff = Cutoff::new(1.0, 1.0);

/// Number of scans of an interval in view within which a moving landmark must be found; shorter intervals do not count.
pub const SPELL_SCANS: usize = 10;

/// Match of the estimates and moving landmarks of one scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ScanMatch {
    /// Moving landmarks in view.
    pub in_view: usize,
    /// Moving landmarks in view with an estimate within the gate, each estimate used once.
    pub matched: usize,
    /// Estimates without a moving landmark.
    pub spurious: usize,
}

/// Figures over the scans whose moving landmarks are known; those of several runs can be added.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MovingScore {
    pub scans: usize,
    /// Intervals of at least [`SPELL_SCANS`] scans in which a moving landmark is in view without a gap.
    pub spells: usize,
    /// Intervals in which it was matched at least once within the first [`SPELL_SCANS`] scans.
    pub spells_hit: usize,
    /// Pairs of a moving landmark and a scan, from the [`SPELL_SCANS`]th scan of an interval on.
    pub settled: usize,
    /// Matched pairs of these.
    pub settled_matched: usize,
    /// Estimates without a moving landmark.
    pub spurious: usize,
    /// Distance of estimate and moving landmark of every match, m.
    pub errors_m: Vec<f64>,
}

impl MovingScore {
    /// Share of the intervals in which the landmark was found in time; `None` without an interval.
    pub fn hit_rate(&self) -> Option<f64> {
        share(self.spells_hit, self.spells)
    }

    /// Share of the scans, after the first ones of each interval, in which a moving landmark was matched; `None` without any.
    pub fn settled_rate(&self) -> Option<f64> {
        share(self.settled_matched, self.settled)
    }

    /// Median distance of matched estimates, m; `None` without a match.
    pub fn position_error_median_m(&self) -> Option<f64> {
        median(&self.errors_m)
    }

    /// Number of estimates a scan without a moving landmark in view; `None` without a scan.
    pub fn false_per_scan(&self) -> Option<f64> {
        share(self.spurious, self.scans)
    }

    pub fn add(&mut self, other: &Self) {
        self.scans += other.scans;
        self.spells += other.spells;
        self.spells_hit += other.spells_hit;
        self.settled += other.settled;
        self.settled_matched += other.settled_matched;
        self.spurious += other.spurious;
        self.errors_m.extend(&other.errors_m);
    }
}

fn share(part: usize, whole: usize) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

/// The median: the middle value, or the mean of the two middle ones.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let upper = *sorted.get(sorted.len() / 2)?;
    Some(if sorted.len() % 2 == 1 { upper } else { 0.5 * (sorted[sorted.len() / 2 - 1] + upper) })
}

/// The score while scans are added.
#[derive(Debug, Clone, Default)]
pub struct MovingTally {
    score: MovingScore,
    spells: BTreeMap<i64, Spell>,
}

/// An interval in which a moving landmark is in view without a gap.
#[derive(Debug, Clone, Copy, Default)]
struct Spell {
    scans: usize,
    hit: bool,
}

impl MovingTally {
    /// Adds a scan: the moving landmarks in view (subject and position, m) and the estimated positions, m.
    pub fn scan<P: Coordinates>(&mut self, in_view: &[(i64, P)], estimates: &[P]) -> ScanMatch {
        let positions: Vec<P> = in_view.iter().map(|&(_, position)| position).collect();
        let pairs = GATE.pairs(&positions, estimates);
        self.spells.retain(|subject, _| in_view.iter().any(|(there, _)| there == subject));
        for (place, (subject, _)) in in_view.iter().enumerate() {
            let error = pairs.iter().find(|&&(mover, _, _)| mover == place).map(|&(_, _, error)| error);
            self.score.errors_m.extend(error);
            let spell = self.spells.entry(*subject).or_default();
            spell.scans += 1;
            spell.hit |= error.is_some() && spell.scans <= SPELL_SCANS;
            if spell.scans == SPELL_SCANS {
                self.score.spells += 1;
                self.score.spells_hit += usize::from(spell.hit);
            }
            if spell.scans > SPELL_SCANS {
                self.score.settled += 1;
                self.score.settled_matched += usize::from(error.is_some());
            }
        }
        let spurious = estimates.len() - pairs.len();
        self.score.scans += 1;
        self.score.spurious += spurious;
        ScanMatch { in_view: in_view.len(), matched: pairs.len(), spurious }
    }

    /// Adds a scan whose moving landmarks are not known: it does not count, and it ends all intervals.
    pub fn unknown(&mut self) {
        self.spells.clear();
    }

    pub fn score(self) -> MovingScore {
        self.score
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: [f64; 2] = [5.0, 5.0];
    const NEAR: [f64; 2] = [5.0, 5.3];
    const FAR: [f64; 2] = [5.0, 9.0];

    #[test]
    fn intervals_count_from_ten_scans_on() {
        let mut tally = MovingTally::default();
        // Nine scans in view with a match, then out of view: not an interval.
        for _ in 0..9 {
            tally.scan(&[(1, HERE)], &[NEAR]);
        }
        tally.scan::<[f64; 2]>(&[], &[]);
        // Twelve scans, matched only in the tenth and the twelfth.
        for scan in 1..=12 {
            let estimates = if scan == 10 || scan == 12 { vec![NEAR] } else { vec![] };
            tally.scan(&[(1, HERE)], &estimates);
        }
        tally.unknown();
        // Eleven scans, matched only in the eleventh: too late.
        for scan in 1..=11 {
            tally.scan(&[(1, HERE)], if scan == 11 { &[NEAR] } else { &[] });
        }
        let score = tally.score();
        assert_eq!((score.spells, score.spells_hit), (2, 1));
        assert_eq!(score.hit_rate(), Some(0.5));
        assert_eq!((score.settled, score.settled_matched), (3, 2));
        assert_eq!((score.scans, score.spurious, score.errors_m.len()), (33, 0, 12));
        assert!((score.position_error_median_m().unwrap() - 0.3).abs() < 1e-12);
    }

    #[test]
    fn estimates_without_a_moving_landmark_in_view_are_false() {
        let mut tally = MovingTally::default();
        let all = tally.scan(&[(1, HERE), (2, [5.0, 6.0])], &[NEAR, [5.0, 6.2], [5.1, 5.0], FAR]);
        assert_eq!(all, ScanMatch { in_view: 2, matched: 2, spurious: 2 });
        // No landmark is in view: every estimate is false.
        assert_eq!(tally.scan(&[], &[HERE]), ScanMatch { in_view: 0, matched: 0, spurious: 1 });
        let score = tally.score();
        assert_eq!(score.false_per_scan(), Some(1.5));
        assert_eq!((score.hit_rate(), score.settled_rate()), (None, None));
        // Two moving landmarks and one estimate between them: it is matched with the nearer.
        let mut tally = MovingTally::default();
        assert_eq!(tally.scan(&[(1, [0.0, 0.0]), (2, [0.8, 0.0])], &[[0.6, 0.0]]).matched, 1);
        assert!((tally.score().errors_m[0] - 0.2).abs() < 1e-12);
    }

    #[test]
    fn figures_of_runs_are_added_and_medians_computed() {
        let one =
            MovingScore { scans: 2, spells: 1, spells_hit: 1, errors_m: vec![3.0, 1.0], ..MovingScore::default() };
        let mut sum = MovingScore { scans: 2, spells: 3, spurious: 1, errors_m: vec![2.0], ..MovingScore::default() };
        sum.add(&one);
        assert_eq!((sum.hit_rate(), sum.false_per_scan()), (Some(0.25), Some(0.25)));
        assert_eq!(sum.position_error_median_m(), Some(2.0));
        assert_eq!(one.position_error_median_m(), Some(2.0));
        assert_eq!(MovingScore::default().position_error_median_m(), None);
    }
}
