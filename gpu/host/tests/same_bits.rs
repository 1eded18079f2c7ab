//! The functions of the kernels, on the host, have the same state and results as `scphd-sim`'s own filter, bit for bit.

use scphd_gpu::{Batch, Checked, Emulated, FilterName, Machine, Sort, Source, Tuning, check, study};
use scphd_gpu_kernels::Status;
use scphd_log::dimensions::Planar;
use scphd_run::monte_carlo::{Job, RunResult, Study};
use scphd_run::session;
use scphd_vehicle::Setting;
use scphd_view::output::overview;

fn source(scenario: &str, particles: Option<usize>) -> Source {
    Source::new(scenario, Tuning { particles, ..Tuning::default() }).unwrap()
}

fn joint(scenario: &str) -> Source {
    Source::new(scenario, Tuning { filter: FilterName::Joint, ..Tuning::default() }).unwrap()
}

/// Checks that every run has the host's digest after each scan.
fn same_digests(source: &Source, runs: usize, seed: u64, scans: usize) -> Checked {
    let plan = source.plan(runs, Some(runs), seed).unwrap();
    let checked = check(&mut Emulated::default(), source, &plan, scans, true).unwrap();
    assert_eq!(checked.differences, []);
    assert_eq!(checked.digests, runs * checked.scans);
    checked
}

#[test]
fn thesis_dynamic_has_the_digests_of_the_host() {
    let checked = same_digests(&source("thesis-dynamic", None), 3, 1, 300);
    assert!(checked.peaks.iter().all(|&pages| pages > 0), "{checked:?}");
}

#[test]
fn survey_has_the_digests_of_the_host() {
    same_digests(&source("survey", Some(32)), 3, 1, 300);
}

#[test]
fn other_vehicles_and_tunings_have_the_digests_of_the_host() {
    assert!(same_digests(&source("thesis-compare", Some(32)), 1, 5, 300).digests > 100);
    assert!(same_digests(&source("worlds-exact", Some(4)), 1, 900_001, 300).digests > 100);
}

#[test]
fn joint_maps_have_the_digests_of_the_host() {
    for scenario in ["thesis-dynamic", "survey", "worlds-exact"] {
        let checked = same_digests(&joint(scenario), 2, 900_001, 300);
        assert!(checked.digests > 200 && checked.short.runs == 0, "{checked:?}");
    }
}

#[test]
fn sixty_four_particles_match_the_simulator() {
    let mut settings = source("thesis-dynamic", Some(64));
    same_digests(&settings, 1, 3, 300);
    let text = "[filter]\nproposal = \"informed\"\nproposal_sampled_fraction = 0.2\n".to_owned();
    settings =
        Source::new("survey", Tuning { settings: Some(text), particles: Some(16), ..Tuning::default() }).unwrap();
    same_digests(&settings, 1, 3, 60);
}

#[test]
fn thousands_of_particles_match_the_library() {
    assert_eq!(same_digests(&source("thesis-dynamic", Some(4096)), 1, 3, 12).short.scans, 0);
    // More particles than pages.
    assert!(same_digests(&source("thesis-dynamic", Some(16_384)), 1, 3, 4).short.scans > 0);
}

/// The result of `scphd-sim`'s own run, without times.
fn plain(source: &Source, job: &Job) -> RunResult {
    let log = source.log(job.scenario_seed).unwrap();
    let settings = source.settings(&log).unwrap();
    let session = session::run::<Planar>(&log, &settings, source.filter(), job.filter_seed, &mut |_| {}).unwrap();
    RunResult { scan_us_mean: None, ..RunResult::of(job, settings.filter.samples, session) }
}

fn same_results(source: &Source, runs: usize, resident: usize) {
    let plan = source.plan(runs, None, 7).unwrap();
    let done = study(&mut Emulated::default(), source, &plan, Some(resident)).unwrap();
    assert_eq!(done.study.results.len(), runs);
    assert_eq!(done.short.runs, 0, "{:?}", done.short);
    let expected: Vec<RunResult> = plan.jobs(None).iter().map(|job| plain(source, job)).collect();
    for (found, expected) in done.study.results.iter().zip(&expected) {
        assert_eq!(found, expected, "run {}", expected.run);
    }
    let plain = Study { plan, results: expected };
    assert_eq!(overview::render(&done.study), overview::render(&plain));
}

#[test]
fn studies_have_the_results_of_the_host() {
    same_results(&source("thesis-dynamic", None), 4, 3);
    same_results(&source("survey", Some(32)), 2, 1);
    same_results(&joint("thesis-dynamic"), 2, 2);
    same_results(&joint("survey"), 2, 1);
}

#[test]
fn unfit_runs_are_refused() {
    let refusal = |scenario, particles| {
        let source = source(scenario, particles);
        let log = source.log(1).unwrap();
        Batch::new(Sort::Many).push(&log, &source.settings(&log).unwrap(), 1).unwrap_err().to_string()
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
    let mut batch = Batch::new(Sort::Many);
    for seed in 1..=5 {
        let mut log = source.log(seed).unwrap();
        log.scans.truncate(12);
        batch.push(&log, &settings, seed).unwrap();
    }
    let mut device = Emulated::default();
    let device: &mut dyn Machine = &mut device;
    let whole = device.run(&batch, 0).unwrap();
    assert!(whole.statuses.iter().all(|status| *status == Status { code: Status::DONE, scans: 12 }));
    let mut bad = batch.clone();
    bad.runs[0].setup[Setting::of_name("sensor.range_sigma_m").unwrap().place()] = -1.0;
    let prediction = bad.runs[1].first_prediction + bad.scans[bad.runs[1].first_scan as usize + 5].first_prediction;
    bad.predictions[prediction as usize].control[0] = f32::INFINITY;
    let measurement = bad.runs[2].first_measurement + bad.scans[bad.runs[2].first_scan as usize + 3].first_measurement;
    bad.measurements[measurement as usize][0] = f32::NAN;
    bad.runs[3].features = 1;
    let outcome = device.run(&bad, 0).unwrap();
    let statuses: Vec<[u32; 2]> = outcome.statuses.iter().map(|status| [status.code, status.scans]).collect();
    assert_eq!(statuses[..3], [[Status::SETUP, 0], [Status::PREDICTION, 5], [Status::SCAN, 3]]);
    assert_eq!(statuses[3][0], Status::FEATURES);
    assert_eq!(statuses[4], [Status::DONE, 12]);
    let last = |outcome: &scphd_gpu::Outcome| outcome.results[batch.runs[4].first_scan as usize + 11];
    assert_eq!(last(&outcome), last(&whole));
}
