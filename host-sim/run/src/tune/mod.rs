//! Settings learnt from one part of a log and judged by the rest.
//!
//! The innovations of the part that is learnt from say what noise, detection and clutter look like (`innovations`). Each group of
//! these settings, and several groups together, are then candidates, as the innovations have it and half way there (`candidates`).
//! A candidate is proposed only if a run with it foresees better where the vehicle sees things again in the part of the log that it
//! was not learnt from (`foresight`, `search`). Nothing here knows the truth; where the log does, errors are told beside the
//! outcome, and no decision asks for them.

mod candidates;
mod change;
mod detection;
mod foresight;
mod innovations;
mod learn;
mod measurement_noise;
mod odometry_noise;
mod over;
mod pairs;
mod plan;
mod planar;
mod search;
#[cfg(test)]
mod tests;
mod trial;
mod underwater;

pub use change::{Candidate, Change, Group, Said};
pub use learn::{Added, Expected, Eye, Learn, NoiseOf};
pub use plan::Plan;
pub use search::{Best, Effort, Foreseen, Gain, Outcome, Tried, position_rmse_m, score};

use crate::session::SessionError;
use scphd_filters::kind::Kind;
use std::ops::Range;

/// The outcome.
#[derive(Debug, Clone, PartialEq)]
pub struct Tuned<S> {
    /// What the innovations say, in the order of the settings file.
    pub said: Vec<Said>,
    /// What became of it.
    pub outcome: Outcome<S>,
}

/// Why nothing came out.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TuneError {
    /// One of the two parts of the log is empty.
    #[error("there must be scans to learn from and others to judge by")]
    EmptyPart,
    /// The measurements are not what a filter takes them for.
    #[error("{0}")]
    Unfit(String),
    /// The filter cannot run with the settings as they are.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// The system has no threads for it.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// The scans from `from_s` until before `until_s`, s since the first.
#[must_use]
pub fn scans_between<K: Kind>(log: &K::Log, from_s: f64, until_s: f64) -> Range<usize> {
    let scans = K::scans(log);
    let start_s = scans.first().map_or(0.0, |scan| scan.t_s);
    let place = |s: f64| scans.partition_point(|scan| scan.t_s - start_s < s);
    let from = place(from_s);
    from..place(until_s).max(from)
}

/// Learns, tries and judges. `progress` is told each run that is done; there are [`most_runs`] at most.
///
/// # Errors
/// See [`TuneError`].
pub fn tune<K: Learn>(
    log: &K::Log,
    settings: &K::Settings,
    plan: &Plan,
    progress: &(dyn Fn() + Sync),
) -> Result<Tuned<K::Settings>, TuneError> {
    if plan.learn.is_empty() || plan.learn.len() >= K::scans(log).len() {
        return Err(TuneError::EmptyPart);
    }
    if let Some(why) = K::unfit(log) {
        return Err(TuneError::Unfit(why));
    }
    let said = innovations::innovations::<K>(log, settings, plan, progress)?;
    let candidates = candidates::candidates::<K>(log, settings, &said);
    let trial = |settings: &K::Settings, seed| {
        let foreseen = trial::trial::<K>(log, settings, (plan.filter, seed), &plan.learn);
        progress();
        Ok::<_, TuneError>(foreseen?)
    };
    let is_valid = |settings: &K::Settings| K::check(log, settings).is_ok();
    let outcome = search::search(settings, candidates, plan.effort, is_valid, trial)?;
    Ok(Tuned { said, outcome })
}

/// Runs over the log that [`tune`] needs at most.
#[must_use]
pub fn most_runs(plan: &Plan) -> usize {
    plan.rounds + search::most_runs(candidates::MOST, plan.effort.runs as usize)
}
