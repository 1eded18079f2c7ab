//! Settings that are learnt from one part of a log and judged by the rest.
//!
//! The innovations of the part to learn from give estimates of noise, detection and clutter (`innovations`). Each group of these
//! settings, and several groups together, are candidates, with the whole change and with half of it (`candidates`). A candidate
//! is proposed only if a run with it predicts measurements better in the rest of the log (`foresight`, `search`). The truth is
//! not used for any decision; if the log has it, errors are reported too.

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
pub use trial::trial_of;

use crate::session::SessionError;
use rayon::prelude::*;
use scphd_filters::kind::Kind;
use std::ops::Range;

/// Runs with settings and seeds, each with its result.
pub type Trials<'t, S, E = TuneError> = &'t dyn Fn(&[(&S, u64)]) -> Result<Vec<Result<Foreseen, E>>, E>;

#[derive(Debug, Clone, PartialEq)]
pub struct Tuned<S> {
    /// The estimates from the innovations, in the order of the settings file.
    pub said: Vec<Said>,
    pub outcome: Outcome<S>,
}

/// Why learning failed.
#[derive(Debug, thiserror::Error)]
pub enum TuneError {
    #[error("there must be scans to learn from and others to judge by")]
    EmptyPart,
    #[error("{0}")]
    Unfit(String),
    #[error(transparent)]
    Session(#[from] SessionError),
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// The scans from `from_s` until before `until_s`, s since the first.
pub fn scans_between<K: Kind>(log: &K::Log, from_s: f64, until_s: f64) -> Range<usize> {
    let scans = K::scans(log);
    let start_s = scans.first().map_or(0.0, |scan| scan.t_s);
    let place = |s: f64| scans.partition_point(|scan| scan.t_s - start_s < s);
    let from = place(from_s);
    from..place(until_s).max(from)
}

/// Learns, tries and judges settings. `progress` is called after each run; there are at most [`most_runs`]. `trials` does the runs that
/// judge, with these settings and seeds, by [`trial_of`]; if absent, threads do them.
pub fn tune<K: Learn>(
    log: &K::Log,
    settings: &K::Settings,
    plan: &Plan,
    progress: &(dyn Fn() + Sync),
    trials: Option<Trials<'_, K::Settings>>,
) -> Result<Tuned<K::Settings>, TuneError> {
    if plan.learn.is_empty() || plan.learn.len() >= K::scans(log).len() {
        return Err(TuneError::EmptyPart);
    }
    if let Some(why) = K::unfit(log) {
        return Err(TuneError::Unfit(why));
    }
    let said = innovations::innovations::<K>(log, settings, plan, progress)?;
    let candidates = candidates::candidates::<K>(log, settings, &said);
    let trial = |&(settings, seed): &(&K::Settings, u64)| {
        let foreseen = trial::trial::<K>(log, settings, (plan.filter, seed), &plan.learn);
        progress();
        Ok::<_, TuneError>(foreseen?)
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(plan.effort.jobs).build()?;
    let by_threads =
        |tasks: &[(&K::Settings, u64)]| Ok(pool.install(|| tasks.par_iter().map(trial).collect::<Vec<_>>()));
    let is_valid = |settings: &K::Settings| K::check(log, settings).is_ok();
    let outcome = search::search(settings, candidates, plan.effort, is_valid, trials.unwrap_or(&by_threads))?;
    Ok(Tuned { said, outcome })
}

pub fn most_runs(plan: &Plan) -> usize {
    plan.rounds + search::most_runs(candidates::MOST, plan.effort.runs as usize)
}
