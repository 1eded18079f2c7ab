//! Monte Carlo studies: many runs of one or several filters over the same inputs.
//!
//! Run k of a study depends on k only, not on the number of threads or the order. Its filter seed is the study's seed plus k. Its
//! input set has the number k / (runs an input set), and is made with the study's seed plus this number or, for logs, is the log
//! with this number. A study can therefore be divided over machines ([`Shard`]) and merged again ([`Study::merge`]), with the
//! same result.

pub mod compare;
pub mod made_up;
pub mod overview;
mod plan;
mod run;
mod statistics;
mod study;
pub mod variants;
pub mod worlds;

pub use plan::{Job, Plan, Shard};
pub use run::{Curve, RunResult, Series};
pub use statistics::{Band, band, mean};
pub use study::{MergeError, Study};

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

    fn study(plan: &Plan, shard: Option<Shard>, threads: usize) -> Study {
        let jobs = plan.jobs(shard);
        let run = |job: &Job, filter: usize| -> Result<RunResult, rayon::ThreadPoolBuildError> {
            Ok(result(job, &plan.filters[filter], filter as f64))
        };
        Study { plan: plan.clone(), results: execute(&jobs, plan.filters.len(), threads, run).unwrap() }
    }

    #[test]
    fn shards_merge_to_the_whole_study_through_their_files() {
        let plan = plan(8, 4);
        let whole = study(&plan, None, 1);
        assert_eq!(study(&plan, None, 3), whole);
        let parts: Vec<Study> = (1..=3)
            .map(|place| {
                let part = study(&plan, Some(Shard { place, of: 3 }), 2);
                serde_json::from_str(&serde_json::to_string(&part).unwrap()).unwrap()
            })
            .collect();
        assert_eq!(parts.iter().map(|part| part.results.len()).collect::<Vec<_>>(), [6, 6, 4]);
        let mut turned = parts.clone();
        turned.reverse();
        assert_eq!(Study::merge(parts).unwrap(), whole);
        assert_eq!(Study::merge(turned).unwrap(), whole);
    }

    #[test]
    fn parts_of_different_studies_are_refused() {
        let plan = plan(8, 4);
        let part = |place| study(&plan, Some(Shard { place, of: 2 }), 1);
        let refused = |parts| Study::merge(parts).unwrap_err().to_string();
        assert_eq!(refused(vec![]), "no study");
        assert_eq!(refused(vec![part(1)]), "run 1 by scphd is missing");
        assert_eq!(refused(vec![part(1), part(1)]), "run 0 by scphd is there twice");
        let mut other = part(2);
        other.plan.settings.clear();
        assert_eq!(refused(vec![part(1), other]), "part 2 is of another study");
    }
}
