//! The functions of the kernels, on the host, have the same state and results as `scphd-sim`'s own filter, bit for bit.

use scphd_filters::slam::Precision;
use scphd_gpu::{Batch, Checked, Device, Emulated, Source, Tuning, study};
use scphd_gpu_kernels::Status;
use scphd_log::dimensions::Planar;
use scphd_run::monte_carlo::RunResult;
use scphd_run::session::{self, Filter};
use scphd_view::output::overview;

const SCANS: usize = 300;

fn source(scenario: &str, particles: Option<usize>) -> Source {
    Source::new(scenario, Tuning { particles, ..Tuning::default() }).unwrap()
}

/// Checks that every run has the host's digest after each scan.
fn same_digests(source: &Source, seeds: &[u64]) -> Checked {
    let checked = Checked::of(&mut Emulated::new(None), source, seeds, SCANS).unwrap();
    assert_eq!(checked.differences, []);
    checked
}

#[test]
fn thesis_dynamic_has_the_digests_of_the_host() {
    let checked = same_digests(&source("thesis-dynamic", None), &[1, 2, 3]);
    assert_eq!(checked.digests, 3 * SCANS);
    assert!(checked.peak_pages.iter().all(|&pages| pages > 0), "{checked:?}");
}

#[test]
fn survey_has_the_digests_of_the_host() {
    let checked = same_digests(&source("survey", Some(32)), &[1, 2, 3]);
    assert_eq!(checked.digests, 3 * SCANS);
}

#[test]
fn other_vehicles_and_tunings_have_the_digests_of_the_host() {
    assert!(same_digests(&source("thesis-compare", Some(32)), &[5]).digests > 100);
    assert!(same_digests(&source("worlds-exact", Some(4)), &[900_001]).digests > 100);
}

/// The result of `scphd-sim`'s own run, without times.
fn plain(source: &Source, job: &scphd_run::monte_carlo::Job) -> RunResult {
    let log = source.log(job.scenario_seed).unwrap();
    let settings = source.settings(&log).unwrap();
    let filter = Filter::Core(Precision::F32);
    let session = session::run::<Planar>(&log, &settings, filter, job.filter_seed, &mut |_| {}).unwrap();
    RunResult { scan_us_mean: None, ..RunResult::of(job, settings.filter.samples, session) }
}

fn same_results(scenario: &str, particles: Option<usize>, runs: usize, resident: usize) {
    let source = source(scenario, particles);
    let plan = source.plan(runs, None, 7).unwrap();
    let done = study(&mut Emulated::new(None), &source, &plan, Some(resident)).unwrap();
    assert_eq!(done.study.results.len(), runs);
    assert_eq!(done.short.runs, 0, "{:?}", done.short);
    let expected: Vec<RunResult> = plan.jobs(None).iter().map(|job| plain(&source, job)).collect();
    for (found, expected) in done.study.results.iter().zip(&expected) {
        assert_eq!(found, expected, "run {}", expected.run);
    }
    let plain = scphd_run::monte_carlo::Study { plan, results: expected };
    assert_eq!(overview::render(&done.study), overview::render(&plain));
}

#[test]
fn a_study_of_thesis_dynamic_has_the_results_of_the_host() {
    same_results("thesis-dynamic", None, 4, 3);
}

#[test]
fn a_study_of_survey_has_the_results_of_the_host() {
    same_results("survey", Some(32), 2, 1);
}

#[test]
fn unfit_runs_are_refused() {
    let refusal = |scenario, particles| {
        let source = source(scenario, particles);
        let log = source.log(1).unwrap();
        Batch::default().push(&log, &source.settings(&log).unwrap(), 1).unwrap_err().to_string()
    };
    assert!(refusal("two-sensors", Some(8)).contains("2 sensors"));
    assert!(refusal("survey-fixes", Some(8)).contains("fixes"));
    assert!(refusal("thesis-dynamic", Some(33)).contains("33 particles"));
}

#[test]
fn a_stopped_run_reports_a_code_and_does_not_affect_the_others() {
    let source = source("thesis-dynamic", None);
    let log = source.log(1).unwrap();
    let settings = source.settings(&log).unwrap();
    let mut batch = Batch::default();
    for seed in 1..=5 {
        let mut log = source.log(seed).unwrap();
        log.scans.truncate(12);
        batch.push(&log, &settings, seed).unwrap();
    }
    let whole = Emulated::new(Some(2)).run(&batch, 0).unwrap();
    assert!(whole.statuses.iter().all(|status| *status == Status { code: Status::DONE, scans: 12 }));
    let mut bad = batch.clone();
    bad.runs[0].setup.range_sigma_m = f32::NAN;
    let prediction = bad.runs[1].first_prediction + bad.scans[bad.runs[1].first_scan as usize + 5].first_prediction;
    bad.predictions[prediction as usize].control[0] = f32::INFINITY;
    let measurement = bad.runs[2].first_measurement + bad.scans[bad.runs[2].first_scan as usize + 3].first_measurement;
    bad.measurements[measurement as usize][0] = f32::NAN;
    bad.runs[3].features = 1;
    let outcome = Emulated::new(Some(2)).run(&bad, 0).unwrap();
    let statuses: Vec<[u32; 2]> = outcome.statuses.iter().map(|status| [status.code, status.scans]).collect();
    assert_eq!(statuses[..3], [[Status::SETUP, 0], [Status::PREDICTION, 5], [Status::SCAN, 3]]);
    assert_eq!(statuses[3][0], Status::FEATURES);
    assert_eq!(statuses[4], [Status::DONE, 12]);
    let last = |outcome: &scphd_gpu::Outcome| outcome.results[batch.runs[4].first_scan as usize + 11];
    assert_eq!(last(&outcome), last(&whole));
}
