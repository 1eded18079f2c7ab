//! Artificial studies, for tests of tables and plots.

use super::{Curve, Job, Plan, RunResult, Series, Study};
use scphd_score::moving::MovingScore;

/// A result that depends only on the run and the filter.
pub fn result(job: &Job, filter: &str, offset: f64) -> RunResult {
    let k = job.run as f64;
    let values = Curve::ALL.map(|curve| {
        (0..6).map(|scan| (scan > 0).then(|| offset + k * 0.1 + f64::from(scan) / 3.0 + curve as u8 as f64)).collect()
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

/// A plan for two filters.
pub fn plan(runs: usize, input_sets: usize) -> Plan {
    let filters = vec!["scphd".to_owned(), "rb-single".to_owned()];
    let settings = "[filter]\nlikelihood = \"single-cluster\"\n".into();
    Plan { scenario: "made up".into(), filters, runs, input_sets, seed: 5, settings, variants: Vec::new() }
}

/// Three runs of each of two filters, the second worse by one.
pub fn of_two_filters() -> Study {
    let plan = plan(3, 3);
    let runs = plan.filters.iter().enumerate().flat_map(|(place, filter)| (0..3).map(move |run| (place, filter, run)));
    let results = runs.map(|(place, filter, run)| result(&plan.job(run), filter, place as f64)).collect();
    Study { results, plan }
}
