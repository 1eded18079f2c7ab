//! Monte Carlo studies: many runs of one filter or several over the same inputs.
//!
//! Run k of a study is decided by k alone, whatever the number of threads and the order: its filter seed is the study's
//! seed plus k, its inputs are set number k / (runs an input set), made with the study's seed plus that number or, for
//! logs, the log of that number. So a study can be spread over machines ([`Shard`]) and put together again
//! ([`Study::merge`]), with the same result as in one piece.

pub mod compare;
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

/// Does every job by every filter with `threads` threads: results by filter, then by run. Of several failures that of
/// the first job is told.
///
/// # Errors
/// A job failed, or the system has no threads.
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
pub(crate) mod tests {
    use super::*;
    use crate::output::json::Format;
    use crate::score::moving::MovingScore;

    /// A made-up result that depends on the run and the filter alone.
    pub(crate) fn result(job: &Job, filter: &str, offset: f64) -> RunResult {
        let k = job.run as f64;
        let values = Curve::ALL.map(|curve| {
            (0..6)
                .map(|scan| (scan > 0).then(|| offset + k * 0.1 + f64::from(scan) / 3.0 + curve as u8 as f64))
                .collect()
        });
        RunResult {
            run: job.run,
            log: "made up".into(),
            filter: filter.into(),
            scenario_seed: job.scenario_seed,
            filter_seed: job.filter_seed,
            particles: 4,
            samples: 2,
            series: Series { t_s: (0..6).map(|scan| 0.1 * f64::from(scan)).collect(), values },
            nees: (0..6).map(|scan| (scan > 0).then_some(if scan == 3 { 20.0 } else { 1.0 + k * 0.1 })).collect(),
            dimension: 2,
            moving: Some(MovingScore {
                scans: 6,
                spells: 2,
                spells_hit: job.run % 3,
                errors_m: vec![k / 7.0],
                ..MovingScore::default()
            }),
            scan_us_mean: Some(100.0 + k),
        }
    }

    pub(crate) fn plan(runs: usize, input_sets: usize) -> Plan {
        let filters = vec!["scphd".to_owned(), "rb-single".to_owned()];
        let settings = "[filter]\nlikelihood = \"single-cluster\"\n".into();
        Plan {
            format: Format,
            scenario: "made up".into(),
            filters,
            runs,
            input_sets,
            seed: 5,
            settings,
            variants: Vec::new(),
        }
    }

    /// Three runs of each of two filters, the second worse by one.
    pub(crate) fn of_two_filters() -> Study {
        let plan = plan(3, 3);
        let runs =
            plan.filters.iter().enumerate().flat_map(|(place, filter)| (0..3).map(move |run| (place, filter, run)));
        let results = runs.map(|(place, filter, run)| result(&plan.job(run), filter, place as f64)).collect();
        Study { results, plan }
    }

    fn study(plan: &Plan, shard: Option<Shard>, threads: usize) -> Study {
        let jobs = plan.jobs(shard);
        let run = |job: &Job, filter: usize| -> Result<RunResult, rayon::ThreadPoolBuildError> {
            Ok(result(job, &plan.filters[filter], filter as f64))
        };
        Study { plan: plan.clone(), results: execute(&jobs, plan.filters.len(), threads, run).unwrap() }
    }

    #[test]
    fn shards_merge_to_the_whole_through_their_files() {
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
    fn what_does_not_belong_together_is_refused() {
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
