//! Runs that the kernels refuse or stop, and a proposal that no scenario has.

use crate::check::check;
use crate::source::{Source, Tuning};
use scphd_gpu::{Asked, Batch, Interpreted, Machine, Sort};
use scphd_gpu_kernels::{Prediction, Status};
use scphd_vehicle::Setting;

/// The batch of a scenario's first scans with the seeds up to `runs`.
fn batch(scenario: &str, particles: Option<usize>, [runs, scans]: [usize; 2]) -> Result<Batch, String> {
    let source = Source { scenario: scenario.into(), tuning: Tuning { particles, ..Tuning::default() } };
    let inputs: Vec<_> = (1..=runs as u64).map(|seed| source.input(seed, scans).unwrap()).collect();
    Batch::of(Sort::Many, &inputs).map_err(|error| error.to_string())
}

/// The module that `cargo xtask module` has built.
fn device() -> Box<dyn Machine> {
    let folder = std::env::var("SCPHD_GPU_MODULES").expect("the folder of the module");
    Box::new(Interpreted::open(folder.as_ref(), true).unwrap())
}

#[test]
fn unfit_runs_are_refused() {
    let refusal = |scenario, particles| batch(scenario, Some(particles), [1, 300]).unwrap_err();
    assert!(refusal("two-sensors", 8).contains("2 sensors"));
    assert!(refusal("survey-fixes", 8).contains("fixes"));
    assert!(refusal("thesis-dynamic", 33).contains("33 particles"));
}

#[test]
#[ignore = "needs the module: cargo xtask module"]
fn a_stopped_run_reports_a_code_and_does_not_affect_the_others() {
    let mut batch = batch("thesis-dynamic", None, [5, 6]).unwrap();
    let mut device = device();
    let whole = device.run(&batch, Asked::default()).unwrap();
    assert!(whole.statuses.iter().all(|status| *status == Status { code: Status::DONE, scans: 6 }));
    let first = |batch: &Batch, run: usize, scan: usize| batch.scans[batch.runs[run].first_scan as usize + scan];
    batch.runs[0].setup[Setting::of_name("sensor.range_sigma_m").unwrap().place()] = -1.0;
    let prediction = batch.runs[1].first_prediction + first(&batch, 1, 5).first_prediction;
    batch.predictions[prediction as usize] = Prediction { control: [f32::INFINITY; 3], dt_s: 0.1 };
    let measurement = batch.runs[2].first_measurement + first(&batch, 2, 3).first_measurement;
    batch.measurements[measurement as usize][0] = f32::NAN;
    batch.runs[3].features = 1;
    let outcome = device.run(&batch, Asked::default()).unwrap();
    let statuses: Vec<[u32; 2]> = outcome.statuses.iter().map(|status| [status.code, status.scans]).collect();
    assert_eq!(statuses[..3], [[Status::SETUP, 0], [Status::PREDICTION, 5], [Status::SCAN, 3]]);
    assert_eq!((statuses[3][0], statuses[4]), (Status::FEATURES, [Status::DONE, 6]));
    let last = batch.runs[4].first_scan as usize + 5;
    assert_eq!(outcome.results[last], whole.results[last]);
}

#[test]
#[ignore = "needs the module: cargo xtask module"]
fn informed_particles_are_those_of_the_host() {
    let settings = Some("[filter]\nproposal = \"informed\"\nproposal_sampled_fraction = 0.2\n".to_owned());
    let tuning = Tuning { settings, particles: Some(16), ..Tuning::default() };
    let source = Source { scenario: "survey".into(), tuning };
    let (_, compared) = check(&mut *device(), &source, (1, 3), 12, true).unwrap();
    assert!(matches!(compared[..], [(_, 12, None)]), "{compared:?}");
}
