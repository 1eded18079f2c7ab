//! A Monte Carlo study on a device: batches of runs, and the simulator's scores of each run.

use crate::batch::Batch;
use crate::device::{Device, DeviceError, Outcome};
use crate::played::Played;
use crate::source::{FILTER, Source, SourceError};
use crate::unfit::Unfit;
use scphd::Health;
use scphd_filters::settings::Settings;
use scphd_gpu_kernels::{ScanResult, Status};
use scphd_log::log::Log;
use scphd_run::monte_carlo::{Job, Plan, RunResult, Study};
use scphd_run::session::{self, SessionError};

/// Why a study failed.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The scenario or its settings are invalid.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The kernels cannot do a run.
    #[error(transparent)]
    Unfit(#[from] Unfit),
    /// The device does not work.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A run has stopped.
    #[error("run {run}, scan {scan}: {why}")]
    Stopped {
        /// Index of the run.
        run: usize,
        /// The scan that was not processed, from 0.
        scan: u32,
        /// The reason.
        why: &'static str,
    },
    /// The outputs of the device make no valid session.
    #[error("run {run}: {why}")]
    Session {
        /// Index of the run.
        run: usize,
        /// The reason.
        why: SessionError,
    },
}

/// A study, and its cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Studied {
    /// The study, as `scphd-sim monte-carlo` makes it, except for the times of scans, which a device does not measure.
    pub study: Study,
    /// The cost of its runs.
    pub took: Took,
    /// Runs whose memory was too small at some scan, so that more memory would have given other results.
    pub short: Short,
}

/// The cost of all runs of a plan on a device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Took {
    /// Number of runs at a time.
    pub resident: usize,
    /// Bytes of a run on the device, with its inputs and results.
    pub bytes_a_run: usize,
    /// Wall time of all launches, s.
    pub launched_s: f64,
}

/// How often the memory of a filter was too small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Short {
    /// Number of runs with such a scan.
    pub runs: usize,
    /// Number of such scans of all runs.
    pub scans: usize,
}

impl Short {
    /// The conditions that report it.
    const CONDITIONS: [Health; 3] = [Health::PRUNING_TIGHTENED, Health::MAP_NOT_UPDATED, Health::COMPONENTS_LOST];

    fn add(&mut self, played: &Played<'_>) {
        let scans = Self::scans_of(played.results());
        self.scans += scans;
        self.runs += usize::from(scans > 0);
    }

    pub(crate) fn scans_of(results: &[ScanResult]) -> usize {
        let bits = Self::CONDITIONS.iter().fold(0, |bits, condition| bits | u32::from(condition.bits()));
        results.iter().filter(|result| result.health & bits != 0).count()
    }
}

/// Processes all runs of a plan, `resident` at a time or as many as the device has memory for, and scores them.
///
/// # Errors
/// The kernels cannot do a run, a run has stopped, or the device does not work.
pub fn study(
    device: &mut dyn Device,
    source: &Source,
    plan: &Plan,
    resident: Option<usize>,
) -> Result<Studied, StudyError> {
    let (mut results, mut short) = (Vec::with_capacity(plan.runs), Short::default());
    let took = run_all(device, source, plan, resident, |played, log, settings, job| {
        short.add(&played);
        results.push(scored(played, log, settings, job)?);
        Ok(())
    })?;
    Ok(Studied { study: Study { plan: plan.clone(), results }, took, short })
}

/// [`study`] without scores.
pub fn time(
    device: &mut dyn Device,
    source: &Source,
    plan: &Plan,
    resident: Option<usize>,
) -> Result<Took, StudyError> {
    run_all(device, source, plan, resident, |_, _, _, _| Ok(()))
}

fn run_all(
    device: &mut dyn Device,
    source: &Source,
    plan: &Plan,
    resident: Option<usize>,
    mut each: impl FnMut(Played<'_>, &Log, &Settings, &Job) -> Result<(), StudyError>,
) -> Result<Took, StudyError> {
    let jobs = plan.jobs(None);
    let mut first = Batch::default();
    if let Some(job) = jobs.first() {
        let log = source.log(job.scenario_seed)?;
        first.push(&log, &source.settings(&log)?, job.filter_seed)?;
    }
    let bytes_a_run = first.bytes() + device.run_bytes(&first);
    let resident = match resident {
        Some(resident) => resident.max(1),
        None => device.resident(bytes_a_run)?.min(jobs.len().max(1)),
    };
    let mut took = Took { resident, bytes_a_run, launched_s: 0.0 };
    for jobs in jobs.chunks(resident) {
        let mut batch = Batch::default();
        let mut inputs: Vec<(Log, Settings)> = Vec::with_capacity(jobs.len());
        for job in jobs {
            let log = source.log(job.scenario_seed)?;
            let settings = source.settings(&log)?;
            batch.push(&log, &settings, job.filter_seed)?;
            inputs.push((log, settings));
        }
        let outcome = device.run(&batch, 0)?;
        took.launched_s += outcome.launched_s;
        for (place, (job, (log, settings))) in jobs.iter().zip(&inputs).enumerate() {
            each(played(&batch, &outcome, place, job.run, device.run_bytes(&batch))?, log, settings, job)?;
        }
    }
    Ok(took)
}

/// The outputs of a completed run of a batch. `number` is the index of the run in the plan.
pub(crate) fn played<'o>(
    batch: &'o Batch,
    outcome: &'o Outcome,
    place: usize,
    number: usize,
    state_bytes: usize,
) -> Result<Played<'o>, StudyError> {
    let Status { code, scans } = outcome.statuses[place];
    match Played::of(batch, outcome, place, state_bytes) {
        Some(played) if code == Status::DONE => Ok(played),
        _ => Err(StudyError::Stopped { run: number, scan: scans, why: Status::text(code) }),
    }
}

fn scored(mut played: Played<'_>, log: &Log, settings: &Settings, job: &Job) -> Result<RunResult, StudyError> {
    let session = session::run_of(&mut played, log, settings, FILTER, job.filter_seed)
        .map_err(|why| StudyError::Session { run: job.run, why })?;
    let result = RunResult::of(job, settings.filter.samples, session);
    // The measured time is that of the replay, not of the scan.
    Ok(RunResult { scan_us_mean: None, ..result })
}
