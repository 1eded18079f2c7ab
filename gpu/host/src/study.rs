//! Runs of a plan on a device in batches: the simulator's scores of each run, or a comparison with the host.

use crate::batch::{Batch, Sort};
use crate::device::Machine;
use crate::failure::Failure;
use crate::played::Played;
use crate::source::Source;
use scphd::Health;
use scphd_filters::kind::Kind;
use scphd_filters::settings::Settings;
use scphd_filters::slam::{Refusal, ScanOutcome, Slam};
use scphd_gpu_kernels::{LargeMemory, Prediction, Slot, Status, control_of, over};
use scphd_log::dimensions::Planar;
use scphd_log::events::{Event, events};
use scphd_log::log::Log;
use scphd_run::monte_carlo::{Job, Plan, RunResult, Study};
use scphd_run::session::{run_of, with_roomy_stack};
use std::time::Instant;

/// The cost of all runs of a plan on a device.
#[derive(Debug, Default)]
pub struct Took {
    /// Number of runs at a time.
    pub resident: usize,
    /// Bytes of a run on the device, with its inputs and results.
    pub bytes_a_run: usize,
    /// Wall time of all launches, s.
    pub launched_s: f64,
    /// Numbers of runs and of scans whose memory was too small, so that more memory would have given other results.
    pub short: [usize; 2],
}

/// Number of runs at a time if there is no limit of the memory.
const RESIDENT: usize = 64;
/// The conditions that report that memory was too small.
const SHORT: [Health; 3] = [Health::PRUNING_TIGHTENED, Health::MAP_NOT_UPDATED, Health::COMPONENTS_LOST];

/// Processes all runs of a plan, and scores them as `scphd-sim monte-carlo` does, except for the times of scans.
pub fn study(device: &mut dyn Machine, source: &Source, plan: &Plan) -> Result<(Study, Took), Failure> {
    let mut results = Vec::with_capacity(plan.runs);
    let took = run_all(device, source, plan, (usize::MAX, 0), |mut played, log, settings, job| {
        let session = run_of(&mut played, log, settings, source.filter(), job.filter_seed);
        let session = session.map_err(|error| Failure::of(format_args!("run {}", job.run), error))?;
        let result = RunResult::of(job, settings.filter.samples, session);
        // The measured time is that of the replay, not of the scan.
        results.push(RunResult { scan_us_mean: None, ..result });
        Ok(())
    })?;
    Ok((Study { plan: plan.clone(), results }, took))
}

#[derive(Debug, Default)]
pub struct Checked {
    pub took: Took,
    /// Wall time of the first run on one core of the host, s.
    pub host_s: f64,
    /// Number of compared scans.
    pub scans: usize,
    /// The first difference of every run that has one.
    pub differences: Vec<String>,
}

/// Processes the first `most_scans` scans of all runs of a plan, and compares digests and outputs after each of them with the host's;
/// without `every`, only those of the first run after its last scan, so that the device's time is that of the scans alone.
pub fn check(
    device: &mut dyn Machine,
    source: &Source,
    plan: &Plan,
    most_scans: usize,
    every: bool,
) -> Result<Checked, Failure> {
    let mut checked = Checked::default();
    let took = run_all(device, source, plan, (most_scans, u32::from(every)), |mut played, log, settings, job| {
        if !every && job.run > 0 {
            return Ok(());
        }
        let mut first = None;
        let mut compare = |scan: usize, same: bool| {
            checked.scans += 1;
            first = first.or((!same).then_some(scan));
        };
        let seconds = if source.sort(settings) == Sort::Large {
            follow_large(log, settings, job.filter_seed, every, |scan, digest| {
                compare(scan, digest == bytemuck::cast::<_, u64>(played.results()[scan].digest));
            })?
        } else {
            let compared = |scan: usize, host: &mut dyn Slam<Planar>, outcome: ScanOutcome| {
                let own = played.scan(0, &[]);
                if every || scan + 1 == log.scans.len() {
                    let same = own.is_ok_and(|own| own == ScanOutcome { stages_us: None, ..outcome })
                        && host.digest() == played.digest()
                        && host.pose().ok() == played.pose().ok()
                        && host.map().ok() == played.map().ok()
                        && host.moving().ok() == played.moving().ok();
                    compare(scan, same);
                }
            };
            follow_host(source, log, settings, job.filter_seed, compared)?
        };
        if job.run == 0 {
            checked.host_s = seconds;
        }
        let difference = first.map(|scan| format!("seed {}, scan {scan}: not as on the host", job.filter_seed));
        checked.differences.extend(difference);
        Ok(())
    })?;
    Ok(Checked { took, ..checked })
}

/// Runs the filter over a log on one core, as `scphd-sim` does, and calls `each` after every scan. Returns the wall time of all
/// predictions and scans, s.
fn follow_host(
    source: &Source,
    log: &Log,
    settings: &Settings,
    seed: u64,
    mut each: impl FnMut(usize, &mut dyn Slam<Planar>, ScanOutcome) + Send,
) -> Result<f64, Failure> {
    let drive = || {
        let mut slam = Planar::slam(source.filter(), log, settings, seed)?;
        let mut seconds = 0.0;
        for event in events(log) {
            let started = Instant::now();
            match event {
                Event::Predict { control, dt_s, .. } => {
                    slam.predict(control, dt_s)?;
                    seconds += started.elapsed().as_secs_f64();
                }
                Event::Fix { .. } => {}
                Event::Scan { index } => {
                    let outcome = slam.scan(log.scans[index].sensor, &log.scans[index].detections)?;
                    seconds += started.elapsed().as_secs_f64();
                    each(index, &mut *slam, outcome);
                }
            }
        }
        Ok(seconds)
    };
    let done = with_roomy_stack(drive).map_err(|error| Failure::of("on the host", error))?;
    done.map_err(|Refusal(why)| Failure::of("on the host", why))
}

/// Runs a filter of many particles, for which `scphd-sim` has no room, by the library's own scan. Calls `each` with the digest after
/// every scan or, without `every`, after the last. Returns the wall time, s, with that of the digests.
fn follow_large(
    log: &Log,
    settings: &Settings,
    seed: u64,
    every: bool,
    mut each: impl FnMut(usize, u64),
) -> Result<f64, Failure> {
    let mut batch = Batch::new(Sort::Large);
    batch.push(log, settings, seed)?;
    let mut memory = vec![0_u64; size_of::<Slot<LargeMemory>>().div_ceil(size_of::<u64>())];
    #[expect(unsafe_code, reason = "a slot is too large for the stack")]
    // SAFETY: the memory is large and aligned enough, and zeros are a valid slot, which `memory.rs` of the kernels checks.
    let slot = unsafe { &mut *memory.as_mut_ptr().cast::<Slot<LargeMemory>>() };
    let stopped = |code| Failure::of("on the host", Status::text(code));
    let started = Instant::now();
    let (mut filter, mut detector) = over(&batch.runs[0], slot).map_err(stopped)?;
    for (place, scan) in batch.scans.iter().enumerate() {
        for Prediction { control, dt_s } in
            &batch.predictions[scan.first_prediction as usize..][..scan.predictions as usize]
        {
            let control = control_of(filter.motion(), *control);
            filter.predict(&control, *dt_s).map_err(|_| stopped(Status::PREDICTION))?;
        }
        let measurements = &batch.measurements[scan.first_measurement as usize..][..scan.measurements as usize];
        let scanned = filter.scan(&mut detector, bytemuck::cast_slice(measurements));
        scanned.map_err(|_| stopped(Status::SCAN))?;
        if every || place + 1 == batch.scans.len() {
            each(place, filter.digest());
        }
    }
    Ok(started.elapsed().as_secs_f64())
}

/// Processes the first scans of all runs of a plan, as many runs at a time as the device has memory for, with a digest after every
/// so many scans, and calls `each` with every run.
fn run_all(
    device: &mut dyn Machine,
    source: &Source,
    plan: &Plan,
    (most_scans, digest_every): (usize, u32),
    mut each: impl FnMut(Played<'_>, &Log, &Settings, &Job) -> Result<(), Failure>,
) -> Result<Took, Failure> {
    let jobs = plan.jobs();
    let sort = source.sort(&source.settings(&source.log(plan.seed)?)?);
    let batch_of = |jobs: &[Job]| -> Result<_, Failure> {
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
    // A tenth of the free memory is for the stacks of all threads.
    let fitting = device.free()?.map_or(RESIDENT, |free| (free / 10 * 9 / bytes_a_run).max(1));
    let resident = fitting.min(jobs.len());
    let mut took = Took { resident, bytes_a_run, ..Took::default() };
    for jobs in jobs.chunks(resident) {
        let (batch, inputs) = batch_of(jobs)?;
        let outcome = device.run(&batch, digest_every)?;
        took.launched_s += outcome.launched_s;
        for (place, (job, (log, settings))) in jobs.iter().zip(&inputs).enumerate() {
            let Status { code, scans } = outcome.statuses[place];
            if code != Status::DONE {
                return Err(Failure::of(format_args!("run {}, scan {scans}", job.run), Status::text(code)));
            }
            let played = Played::of(&batch, &outcome, place, bytes_a_run);
            let bits = SHORT.iter().fold(0, |bits, condition| bits | u32::from(condition.bits()));
            let short = played.results().iter().filter(|result| result.health & bits != 0).count();
            took.short = [took.short[0] + usize::from(short > 0), took.short[1] + short];
            each(played, log, settings, job)?;
        }
    }
    Ok(took)
}
