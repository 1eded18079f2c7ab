//! A Monte Carlo study on a device: batches of runs, and the simulator's scores of each run.

use crate::batch::Batch;
use crate::check::{StudyError, on_host};
use crate::device::Machine;
use crate::played::Played;
use crate::source::Source;
use scphd::Health;
use scphd_filters::settings::Settings;
use scphd_gpu_kernels::{ScanResult, Status, joined};
use scphd_log::log::Log;
use scphd_run::monte_carlo::{Job, Plan, RunResult, Study};
use scphd_run::session;

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

    fn add(&mut self, results: &[ScanResult]) {
        let bits = Self::CONDITIONS.iter().fold(0, |bits, condition| bits | u32::from(condition.bits()));
        let scans = results.iter().filter(|result| result.health & bits != 0).count();
        self.scans += scans;
        self.runs += usize::from(scans > 0);
    }
}

/// Processes all runs of a plan, `resident` at a time or as many as the device has memory for, and scores them.
///
/// # Errors
/// The kernels cannot do a run, a run has stopped, or the device does not work.
pub fn study(
    device: &mut dyn Machine,
    source: &Source,
    plan: &Plan,
    resident: Option<usize>,
) -> Result<Studied, StudyError> {
    let (mut results, mut short) = (Vec::with_capacity(plan.runs), Short::default());
    let took = run_all(device, source, plan, resident, (usize::MAX, 0), |mut played, log, settings, job| {
        short.add(played.results());
        let session = session::run_of(&mut played, log, settings, source.filter(), job.filter_seed)
            .map_err(|why| StudyError::Session { run: job.run, why })?;
        let result = RunResult::of(job, settings.filter.samples, session);
        // The measured time is that of the replay, not of the scan.
        results.push(RunResult { scan_us_mean: None, ..result });
        Ok(())
    })?;
    Ok(Studied { study: Study { plan: plan.clone(), results }, took, short })
}

/// The result of a comparison of several runs with the host.
#[derive(Debug, Clone, PartialEq)]
pub struct Checked {
    /// The cost of the runs.
    pub took: Took,
    /// Number of scans of a run.
    pub scans: usize,
    /// Wall time of the first run on one core of the host, s.
    pub host_s: f64,
    /// Number of digests that were compared.
    pub digests: usize,
    /// The first difference of every run that has one.
    pub differences: Vec<Difference>,
    /// The greatest numbers of pages of static and of moving features that a scan has used; of a joint map, of features and tracks.
    pub peaks: [u32; 2],
    /// Runs whose memory was too small at some scan.
    pub short: Short,
}

/// A digest of the device that differs from the host's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Difference {
    /// Seed of the filter.
    pub seed: u64,
    /// The scan, from 0.
    pub scan: usize,
    /// The digest of the host.
    pub host: u64,
    /// The digest of the device.
    pub device: u64,
}

/// Processes the first `most_scans` scans of all runs of a plan, and compares the digests after each of them with the host's; without
/// `every`, only that of the first run after its last scan, so that the device's time is that of the scans alone.
///
/// # Errors
/// As of [`study`].
pub fn check(
    device: &mut dyn Machine,
    source: &Source,
    plan: &Plan,
    most_scans: usize,
    every: bool,
) -> Result<Checked, StudyError> {
    let (mut digests, mut differences, mut peaks, mut short) = (0, Vec::new(), [0; 2], Short::default());
    let (mut host_s, mut scans) = (0.0, 0);
    let took = run_all(device, source, plan, None, (most_scans, u32::from(every)), |played, log, settings, job| {
        let results = played.results();
        short.add(results);
        for result in results {
            peaks = [peaks[0].max(result.peak_pages), peaks[1].max(result.peak_moving_pages)];
        }
        if !every && job.run > 0 {
            return Ok(());
        }
        let (host, seconds) = on_host(source, log, settings, job.filter_seed, every)?;
        if job.run == 0 {
            (host_s, scans) = (seconds, log.scans.len());
        }
        digests += host.len();
        let of_device =
            results.iter().map(|result| joined(result.digest)).enumerate().filter(|(_, digest)| *digest != 0);
        let mut pairs = host.iter().zip(of_device).map(|(&host, (scan, device))| (scan, host, device));
        differences.extend(pairs.find(|(_, host, device)| host != device).map(|(scan, host, device)| Difference {
            seed: job.filter_seed,
            scan,
            host,
            device,
        }));
        Ok(())
    })?;
    Ok(Checked { took, scans, host_s, digests, differences, peaks, short })
}

/// Processes the first scans of all runs of a plan, with a digest after every so many of them, and calls `each` with every run.
fn run_all(
    device: &mut dyn Machine,
    source: &Source,
    plan: &Plan,
    resident: Option<usize>,
    (most_scans, digest_every): (usize, u32),
    mut each: impl FnMut(Played<'_>, &Log, &Settings, &Job) -> Result<(), StudyError>,
) -> Result<Took, StudyError> {
    let jobs = plan.jobs(None);
    let sort = source.sort(&source.settings(&source.log(plan.seed)?)?);
    let batch_of = |jobs: &[Job]| -> Result<_, StudyError> {
        let (mut batch, mut inputs) = (Batch::new(sort), Vec::with_capacity(jobs.len()));
        for job in jobs {
            let mut log = source.log(job.scenario_seed)?;
            let settings = source.settings(&log)?;
            log.scans.truncate(most_scans);
            batch.push(&log, &settings, job.filter_seed)?;
            inputs.push((log, settings));
        }
        Ok((batch, inputs))
    };
    let (first, _) = batch_of(&jobs[..1])?;
    let bytes_a_run = first.bytes() + device.run_bytes(&first)?;
    let resident = match resident {
        Some(resident) => resident.max(1),
        None => device.resident(bytes_a_run)?.min(jobs.len()),
    };
    let mut took = Took { resident, bytes_a_run, launched_s: 0.0 };
    for jobs in jobs.chunks(resident) {
        let (batch, inputs) = batch_of(jobs)?;
        let outcome = device.run(&batch, digest_every)?;
        took.launched_s += outcome.launched_s;
        for (place, (job, (log, settings))) in jobs.iter().zip(&inputs).enumerate() {
            let Status { code, scans } = outcome.statuses[place];
            let played = Played::of(&batch, &outcome, place, bytes_a_run).filter(|_| code == Status::DONE);
            let stopped = StudyError::Stopped { run: job.run, scan: scans, why: Status::text(code) };
            each(played.ok_or(stopped)?, log, settings, job)?;
        }
    }
    Ok(took)
}
