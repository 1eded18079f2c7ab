//! Settings learnt from one part of a log and judged by the rest.
//!
//! The innovations of the part that is learnt from say what noise, detection and clutter look like (`innovations`). Each group of
//! these settings, and several groups together, are then candidates, as the innovations have it and half way there (`planar`).
//! A candidate is proposed only if a run with it foresees better where the vehicle sees things again in the part of the log that it
//! was not learnt from (`foresight`, `search`). Nothing here knows the truth; where the log does, errors are told beside the
//! outcome, and no decision asks for them.

mod change;
mod detection;
mod foresight;
mod innovations;
mod measurement_noise;
mod odometry_noise;
mod pairs;
mod planar;
mod search;
#[cfg(test)]
mod tests;

pub use change::{Candidate, Change, Group, Said};
pub use search::{Best, Effort, Foreseen, Gain, Outcome, Tried, position_rmse_m, score};

use crate::log::Log;
use crate::session::{Filter, SessionError};
use crate::settings::Settings;
use std::ops::Range;

/// What is learnt from, and how hard it is tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The filter that is to run with the settings.
    pub filter: Filter,
    /// The scans that are learnt from; the others judge.
    pub learn: Range<usize>,
    /// Runs over them, each with what the one before said.
    pub rounds: usize,
    /// Trials.
    pub effort: Effort,
}

/// The outcome.
#[derive(Debug, Clone, PartialEq)]
pub struct Tuned {
    /// What the innovations say, in the order of the settings file.
    pub said: Vec<Said>,
    /// What became of it.
    pub outcome: Outcome<Settings>,
}

/// Why nothing came out.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TuneError {
    /// One of the two parts of the log is empty.
    #[error("there must be scans to learn from and others to judge by")]
    EmptyPart,
    /// The filter cannot run with the settings as they are.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// The system has no threads for it.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// The scans from `from_s` until before `until_s`, s since the first.
#[must_use]
pub fn scans_between(log: &Log, from_s: f64, until_s: f64) -> Range<usize> {
    let start_s = log.scans.first().map_or(0.0, |scan| scan.t_s);
    let place = |s: f64| log.scans.partition_point(|scan| scan.t_s - start_s < s);
    let from = place(from_s);
    from..place(until_s).max(from)
}

/// Learns, tries and judges. `progress` is told each run that is done; there are [`most_runs`] at most.
///
/// # Errors
/// See [`TuneError`].
pub fn tune(log: &Log, settings: &Settings, plan: &Plan, progress: &(dyn Fn() + Sync)) -> Result<Tuned, TuneError> {
    let Plan { filter, learn, rounds, effort } = plan;
    if learn.is_empty() || learn.len() >= log.scans.len() {
        return Err(TuneError::EmptyPart);
    }
    let said = innovations::innovations(log, settings, *filter, effort.seed, *rounds, learn, progress)?;
    let candidates = planar::candidates(log, settings, &said);
    let trial = |settings: &Settings, seed| {
        let foreseen = planar::trial(log, settings, *filter, seed, learn);
        progress();
        Ok::<_, TuneError>(foreseen?)
    };
    let is_valid = |settings: &Settings| settings.check().is_ok();
    let outcome = search::search(settings, candidates, *effort, is_valid, trial)?;
    Ok(Tuned { said, outcome })
}

/// Runs over the log that [`tune`] needs at most.
#[must_use]
pub fn most_runs(plan: &Plan) -> usize {
    plan.rounds + search::most_runs(planar::MOST_CANDIDATES, plan.effort.runs as usize)
}
