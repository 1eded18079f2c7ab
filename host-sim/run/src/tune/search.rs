//! Choice among candidate settings, by their prediction of a part of the log that they were not learnt from.
//!
//! All candidates run with one seed, the best few with more seeds. The best of those that are clearly better than the present
//! settings must be confirmed with seeds, and in blocks of time, that had no part in the choice: every second block of the
//! held-out part chooses, the others confirm. Everything else is refused.
//!
//! The scores of [`super::foresight`] are compared. The filter's likelihood of each scan (its evidence) is not suitable: it
//! predicts one scan ahead, where small noise is always better, and would choose settings with which maps become inconsistent.

use super::Trials;
use super::change::{Candidate, changed};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::ops::Range;

/// Least gain, nats a measurement. Smaller gains show how sharp a map is, not whether the trajectory is right.
const LEAST_GAIN: f64 = 0.04;
/// Least gain in standard errors, for the choice and for the confirmation.
const LEAST_CERTAINTY: f64 = 2.5;
/// Number of candidates that run with more than the first seed.
const SHORTLIST: usize = 3;
/// Number of blocks of the held-out time, which are assumed to be independent.
const BLOCKS: usize = 16;

/// Prediction of the held-out part by a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Foreseen {
    /// Score of each block of time, nats.
    blocks: [f64; BLOCKS],
    measurements: [usize; BLOCKS],
    /// Root mean square distance to the true position, m, if there is a truth. It is only reported.
    pub position_rmse_m: Option<f64>,
}

impl Foreseen {
    /// Sums over the held-out scans in order, each with its score and its number of measurements, and the position error.
    pub fn of(held_out: &[(f64, usize)], position_rmse_m: Option<f64>) -> Self {
        let (mut blocks, mut measurements) = ([0.0; BLOCKS], [0; BLOCKS]);
        for (place, (score, of_scan)) in held_out.iter().enumerate() {
            let block = place * BLOCKS / held_out.len();
            blocks[block] += score;
            measurements[block] += of_scan;
        }
        Self { blocks, measurements, position_rmse_m }
    }
}

/// Mean score of a measurement over some runs, nats.
pub fn score(runs: &[Foreseen]) -> f64 {
    let sum: f64 = runs.iter().flat_map(|run| run.blocks).sum();
    sum / runs.iter().flat_map(|run| run.measurements).sum::<usize>().max(1) as f64
}

/// Root mean square error over some runs, m.
pub fn position_rmse_m(runs: &[Foreseen]) -> Option<f64> {
    let squares: Option<f64> = runs.iter().map(|run| run.position_rmse_m.map(|error| error * error)).sum();
    squares.filter(|_| !runs.is_empty()).map(|sum| (sum / runs.len() as f64).sqrt())
}

/// Blocks of the held-out time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Every second one, from the first: candidates are chosen by them.
    Choosing,
    /// The others: they confirm the choice.
    Confirming,
}

/// A difference of two scores, nats a measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Mean difference.
    pub mean: f64,
    /// Standard error, from the differences between blocks of time.
    pub error: f64,
}

impl Gain {
    /// Gain of runs with other settings (`then`) over those with the present ones (`now`), seed by seed, in the blocks of this
    /// part.
    pub fn of(now: &[Foreseen], then: &[Foreseen], part: Part) -> Self {
        let runs = now.len().min(then.len()).max(1) as f64;
        let mut gains = [0.0; BLOCKS / 2];
        for (now, then) in now.iter().zip(then) {
            let blocks = now.blocks.iter().zip(then.blocks).skip(part as usize).step_by(2);
            for (gain, (now, then)) in gains.iter_mut().zip(blocks) {
                *gain += (then - now) / runs;
            }
        }
        let (count, sum): (f64, f64) = (gains.len() as f64, gains.iter().sum());
        let mean = sum / count;
        let variance = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let in_part = |run: &Foreseen| run.measurements.iter().skip(part as usize).step_by(2).sum::<usize>();
        let measurements = now.first().map_or(1, |run| in_part(run).max(1)) as f64;
        Self { mean: sum / measurements, error: (variance * count).sqrt() / measurements }
    }

    fn is_clear(&self) -> bool {
        self.mean > LEAST_GAIN && self.mean > LEAST_CERTAINTY * self.error
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct Tried {
    pub candidate: Candidate,
    /// Its gain over the present settings; `None` if the filter fails with it, or the settings are out of range.
    pub gain: Option<Gain>,
    pub runs: Vec<Foreseen>,
    /// Whether the gain is clear with all seeds.
    pub wins: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Outcome<S> {
    /// The proposed settings, or the present ones.
    pub settings: S,
    /// Runs with the present settings and the first seeds.
    pub now: Vec<Foreseen>,
    /// Every candidate.
    pub tried: Vec<Tried>,
    /// The best of the clearly better candidates, if there is one, and its confirmation.
    pub best: Option<Best>,
}

/// The best of the clearly better candidates.
#[derive(Debug, Clone, PartialEq)]
pub struct Best {
    /// Its index in [`Outcome::tried`].
    pub tried: usize,
    /// Runs with the present settings and other seeds.
    pub now: Vec<Foreseen>,
    /// Its runs with those seeds.
    pub then: Vec<Foreseen>,
    /// Its gain in these runs.
    pub gain: Gain,
    /// Whether the gain is clear, so that it is proposed.
    pub confirmed: bool,
}

impl<S> Outcome<S> {
    /// The proposed candidate, if any.
    pub fn proposed(&self) -> Option<&Candidate> {
        self.best.as_ref().filter(|best| best.confirmed).map(|best| &self.tried[best.tried].candidate)
    }
}

/// Number of runs, and their seeds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    pub seed: u64,
    /// Number of runs of each candidate, and of the best one to confirm it.
    pub runs: u64,
    pub jobs: usize,
}

/// Compares all candidates with `now`. `trials` runs valid settings with seeds; `is_valid` tells whether settings are within their
/// limits.
pub fn search<S, E>(
    now: &S,
    candidates: Vec<Candidate>,
    effort: Effort,
    is_valid: impl Fn(&S) -> bool,
    trials: Trials<'_, S, E>,
) -> Result<Outcome<S>, E>
where
    S: Clone + Serialize + DeserializeOwned,
{
    let Effort { seed, runs, .. } = effort;
    let fresh = seed.saturating_add(runs);
    let execute = |all: &[&S], seeds: Range<u64>| -> Result<Vec<Result<Vec<Foreseen>, E>>, E> {
        let tasks: Vec<(&S, u64)> = all.iter().flat_map(|&s| seeds.clone().map(move |seed| (s, seed))).collect();
        let mut results = trials(&tasks)?.into_iter();
        let each = (seeds.end - seeds.start) as usize;
        let mut of_one = || results.by_ref().take(each).collect::<Vec<_>>();
        // All results of a candidate are taken before looking for failures, because the next results are those of another one.
        Ok(all.iter().map(|_| of_one().into_iter().collect()).collect())
    };

    let with = |candidate: &Candidate| changed(now, &candidate.changes).ok().filter(&is_valid);
    let settings: Vec<Option<S>> = candidates.iter().map(with).collect();
    let all: Vec<&S> = std::iter::once(now).chain(settings.iter().flatten()).collect();
    let mut results = execute(&all, seed..seed.saturating_add(1))?.into_iter();
    let mut base = results.next().transpose()?.unwrap_or_default();
    let tried = candidates.into_iter().zip(&settings).map(|(candidate, settings)| {
        let runs = settings.as_ref().and_then(|_| results.next()).and_then(Result::ok).unwrap_or_default();
        let gain = (!runs.is_empty()).then(|| Gain::of(&base, &runs, Part::Choosing));
        Tried { candidate, gain, runs, wins: false }
    });
    let mut tried: Vec<Tried> = tried.collect();

    let mut order: Vec<usize> = (0..tried.len()).filter(|&k| tried[k].mean() > 0.0).collect();
    order.sort_by(|&a, &b| tried[b].mean().total_cmp(&tried[a].mean()));
    order.truncate(SHORTLIST);
    let short: Vec<&S> = std::iter::once(now).chain(order.iter().filter_map(|&k| settings[k].as_ref())).collect();
    if !order.is_empty() {
        let mut results = execute(&short, seed.saturating_add(1)..fresh)?.into_iter();
        base.extend(results.next().transpose()?.unwrap_or_default());
        for (&k, more) in order.iter().zip(results) {
            let tried = &mut tried[k];
            let Ok(more) = more else {
                tried.gain = None;
                continue;
            };
            tried.runs.extend(more);
            let gain = Gain::of(&base, &tried.runs, Part::Choosing);
            (tried.gain, tried.wins) = (Some(gain), gain.is_clear());
        }
    }
    let mut outcome = Outcome { settings: now.clone(), now: base, tried, best: None };
    let winners = order.into_iter().filter(|&k| outcome.tried[k].wins);
    let winner = winners.max_by(|&a, &b| outcome.tried[a].mean().total_cmp(&outcome.tried[b].mean()));
    if let Some((winner, settings)) = winner.and_then(|winner| Some((winner, settings[winner].as_ref()?))) {
        let mut both = execute(&[now, settings], fresh..fresh.saturating_add(runs))?.into_iter();
        let now = both.next().transpose()?.unwrap_or_default();
        let Some(then) = both.next().and_then(Result::ok) else {
            outcome.tried[winner].gain = None;
            outcome.tried[winner].wins = false;
            return Ok(outcome);
        };
        let gain = Gain::of(&now, &then, Part::Confirming);
        let confirmed = gain.is_clear();
        if confirmed {
            outcome.settings = settings.clone();
        }
        outcome.best = Some(Best { tried: winner, now, then, gain, confirmed });
    }
    Ok(outcome)
}

pub(super) fn most_runs(candidates: usize, runs: usize) -> usize {
    1 + candidates + (1 + SHORTLIST) * (runs - 1) + 2 * runs
}

impl Tried {
    fn mean(&self) -> f64 {
        self.gain.map_or(f64::NEG_INFINITY, |gain| gain.mean)
    }
}

#[cfg(test)]
mod tests {
    use super::super::change::{Change, Group};
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    struct Knob {
        x: f64,
    }

    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    struct Made {
        up: Knob,
    }

    #[derive(Debug)]
    struct Failed;

    const NOW: Made = Made { up: Knob { x: 1.0 } };

    /// A candidate for each of these values.
    fn candidates(values: &[f64]) -> Vec<Candidate> {
        let candidate =
            |&x| Candidate { group: Group::Noise, how: "made up".into(), changes: vec![Change::new("up.x", x)] };
        values.iter().map(candidate).collect()
    }

    /// 32 scans of ten measurements, each with this score.
    fn foreseen(score: f64) -> Foreseen {
        let scans: Vec<_> = (0..32).map(|scan| (10.0 * score + 0.01 * f64::from(scan % 3), 10)).collect();
        Foreseen::of(&scans, None)
    }

    fn outcome(values: &[f64], trial: impl Fn(&Made, u64) -> Result<Foreseen, Failed>) -> Outcome<Made> {
        let effort = Effort { seed: 10, runs: 3, jobs: 2 };
        let trials = |all: &[(&Made, u64)]| Ok(all.iter().map(|&(made, seed)| trial(made, seed)).collect());
        search(&NOW, candidates(values), effort, |made| made.up.x < 100.0, &trials).unwrap()
    }

    #[test]
    fn the_best_of_the_clearly_better_candidates_is_proposed() {
        let found = outcome(&[2.0, 5.0, 0.5, 4.0, 3.0, 200.0], |made, _| Ok(foreseen(made.up.x)));
        assert_eq!((found.settings.up.x, found.best.as_ref().map(|best| best.tried)), (5.0, Some(1)));
        let gain = found.best.unwrap().gain;
        assert!((gain.mean - 4.0).abs() < 1e-12 && gain.error < 1e-12);
        // Three of them had all runs; the last is out of its limits.
        assert_eq!(found.tried.iter().map(|tried| tried.runs.len()).collect::<Vec<_>>(), [1, 3, 1, 3, 3, 0]);
        assert_eq!(found.tried[5].gain, None);
    }

    #[test]
    fn losses_small_gains_and_unclear_gains_are_refused() {
        let refused = |found: Outcome<Made>| {
            assert_eq!((found.proposed(), &found.settings), (None, &NOW));
            assert!(!found.tried.iter().any(|tried| tried.wins));
        };
        refused(outcome(&[0.5], |made, _| Ok(foreseen(made.up.x))));
        refused(outcome(&[1.0 + 0.9 * LEAST_GAIN], |made, _| Ok(foreseen(made.up.x))));
        // A large gain in one block of time only.
        refused(outcome(&[2.0], |made, _| {
            let lucky = |scan| if scan < 2 { 100.0 * made.up.x } else { 0.0 };
            Ok(Foreseen::of(&(0..32).map(|scan| (lucky(scan), 10)).collect::<Vec<_>>(), None))
        }));
    }

    #[test]
    fn a_gain_must_be_confirmed_with_other_seeds() {
        let lucky = |made: &Made, seed: u64| Ok(foreseen(if seed < 13 { made.up.x } else { 1.0 }));
        let found = outcome(&[2.0], lucky);
        let best = found.best.as_ref().unwrap();
        assert!(found.tried[0].wins && !best.confirmed);
        assert_eq!((found.proposed(), &found.settings), (None, &NOW));
    }

    /// A gain only in the blocks of the choice is due to chance.
    #[test]
    fn a_gain_must_be_confirmed_in_other_blocks() {
        let lucky = |made: &Made, _| {
            let scan = |scan: u32| if (scan / 2).is_multiple_of(2) { 10.0 * made.up.x } else { 10.0 };
            Ok(Foreseen::of(&(0..32).map(|k| (scan(k) + 0.01 * f64::from(k % 3), 10)).collect::<Vec<_>>(), None))
        };
        let found = outcome(&[2.0], lucky);
        let best = found.best.as_ref().unwrap();
        assert!(found.tried[0].wins && !best.confirmed, "{best:?}");
        assert_eq!((found.proposed(), &found.settings), (None, &NOW));
    }

    #[test]
    fn a_failing_candidate_does_not_affect_the_others() {
        let fails = |made: &Made, seed: u64| {
            if made.up.x == 5.0 && seed > 10 { Err(Failed) } else { Ok(foreseen(made.up.x)) }
        };
        let found = outcome(&[5.0, 3.0, 2.0], fails);
        assert_eq!((found.tried[0].gain, found.tried[0].wins), (None, false));
        assert_eq!(found.settings.up.x, 3.0);
        assert!((found.tried[2].gain.unwrap().mean - 1.0).abs() < 1e-12);
        // It fails only with the last seeds, after it has been chosen.
        let late = |made: &Made, seed: u64| {
            if made.up.x == 5.0 && seed > 14 { Err(Failed) } else { Ok(foreseen(made.up.x)) }
        };
        assert_eq!(outcome(&[5.0, 3.0], late).proposed(), None);
        // The present settings must run.
        let effort = Effort { seed: 1, runs: 1, jobs: 1 };
        let fails = |all: &[(&Made, u64)]| Ok(all.iter().map(|_| Err(Failed)).collect());
        assert!(search(&NOW, candidates(&[2.0]), effort, |_| true, &fails).is_err());
    }
}
