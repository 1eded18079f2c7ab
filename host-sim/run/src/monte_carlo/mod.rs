//! Monte Carlo studies: many runs of one or several filters over the same inputs.
//!
//! Run k of a study depends on k only, not on the number of threads or the order. Its filter seed is the study's seed plus k. Its
//! input set has the number k / (runs an input set), and is made with the study's seed plus this number or, for logs, is the log
//! with this number.

pub mod compare;
pub mod made_up;
pub mod overview;
mod plan;
mod run;
mod statistics;
mod study;
pub mod variants;
pub mod worlds;

pub use plan::{Job, Plan};
pub use run::{Curve, RunResult, Series};
pub use statistics::{Band, band, mean, standard_deviation};
pub use study::Study;

use rayon::prelude::*;

/// Executes every job with every filter on `threads` threads. Returns results by filter, then by run; of several failures that of
/// the first job.
pub fn execute<E: Send + From<rayon::ThreadPoolBuildError>>(
    jobs: &[Job],
    filters: usize,
    threads: usize,
    run: impl Fn(&Job, usize) -> Result<RunResult, E> + Sync,
) -> Result<Vec<RunResult>, E> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let tasks: Vec<(usize, &Job)> = (0..filters).flat_map(|filter| jobs.iter().map(move |job| (filter, job))).collect();
    let results: Vec<Result<RunResult, E>> =
        pool.install(|| tasks.par_iter().map(|&(filter, job)| run(job, filter)).collect());
    results.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::made_up::{plan, result};
    use super::*;

    #[test]
    fn a_study_does_not_depend_on_the_threads() {
        let plan = plan(8, 4);
        let run = |job: &Job, filter: usize| -> Result<RunResult, rayon::ThreadPoolBuildError> {
            Ok(result(job, &plan.filters[filter], filter as f64))
        };
        let study = |threads| execute(&plan.jobs(), plan.filters.len(), threads, run).unwrap();
        assert_eq!(study(3), study(1));
    }
}
