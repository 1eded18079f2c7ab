//! Comparisons of runs on a device with the host.

use crate::source::Source;
use scphd_filters::kind::Kind;
use scphd_filters::settings::Settings;
use scphd_filters::slam::{Refusal, ScanOutcome, Slam};
use scphd_gpu::{Asked, Batch, Failure, Input, Machine, Played, Sort, Took, run_all};
use scphd_gpu_kernels::{LargeMemory, Prediction, Slot, Status, control_of, over};
use scphd_log::dimensions::Planar;
use scphd_log::events::{Event, events};
use scphd_log::log::Log;
use scphd_run::session::with_roomy_stack;
use std::time::Instant;

/// Of a run, the wall time on one core of the host, s, the number of compared scans, and the first difference, if there is one.
pub type Compared = (f64, usize, Option<String>);

/// Processes the first `most_scans` scans of `runs` runs with consecutive seeds from `seed` on, and compares digests and outputs after
/// each of them with the host's; without `every`, only those of the first run after its last scan, so that the device's time is that
/// of the scans alone.
pub fn check(
    device: &mut dyn Machine,
    source: &Source,
    (runs, seed): (usize, u64),
    most_scans: usize,
    every: bool,
) -> Result<(Took, Vec<Compared>), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().build().map_err(|error| Failure::of("cannot start threads", error))?;
    let input = |run| source.input(seed + run as u64, most_scans);
    let compare = |run, mut played: Played<'_>, input: &Input<'_>| -> Result<Compared, Failure> {
        let (log, settings, seed) = input;
        let (mut scans, mut first) = (0, None);
        if !every && run > 0 {
            return Ok((0.0, scans, first));
        }
        let mut compare = |scan: usize, same: bool| {
            scans += 1;
            first = first.take().or((!same).then(|| format!("seed {seed}, scan {scan}: not as on the host")));
        };
        let seconds = if Sort::of(source.filter(), settings)? == Sort::Large {
            follow_large(input, every, |scan, digest| {
                compare(
                    scan,
                    played.results().get(scan).is_some_and(|own| bytemuck::cast::<_, u64>(own.digest) == digest),
                );
            })?
        } else {
            let mut foreseen = true;
            let compared = |scan: usize, host: &mut dyn Slam<Planar>, outcome: Option<ScanOutcome>| {
                let Some(outcome) = outcome else {
                    foreseen = !every || host.pose().ok().map(|(pose, _)| pose) == played.predicted_pose();
                    return;
                };
                let own = played.scan(0, &[]);
                if every || scan + 1 == log.scans.len() {
                    let same = foreseen
                        && own.is_ok_and(|own| own == ScanOutcome { stages_us: None, ..outcome })
                        && host.digest() == played.digest()
                        && host.pose().ok() == played.pose().ok()
                        && host.map().ok() == played.map().ok()
                        && host.moving().ok() == played.moving().ok();
                    compare(scan, same);
                }
            };
            follow_host(source, log, settings, *seed, compared)?
        };
        Ok((seconds, scans, first))
    };
    let asked = Asked { digest_every: every.into(), predicted: every };
    run_all(device, &pool, (source.filter(), asked), runs, input, compare)
}

/// Runs the filter over a log on one core, as `scphd-sim` does, and calls `each` before every scan and with its outcome. Returns the
/// wall time of all predictions and scans, s.
fn follow_host(
    source: &Source,
    log: &Log,
    settings: &Settings,
    seed: u64,
    mut each: impl FnMut(usize, &mut dyn Slam<Planar>, Option<ScanOutcome>) + Send,
) -> Result<f64, Failure> {
    let drive = || {
        let mut slam = Planar::slam(source.filter(), log, settings, seed)?;
        let mut seconds = 0.0;
        for event in events(log) {
            if let Event::Scan { index } = event {
                each(index, &mut *slam, None);
            }
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
                    each(index, &mut *slam, Some(outcome));
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
fn follow_large(input: &Input<'_>, every: bool, mut each: impl FnMut(usize, u64)) -> Result<f64, Failure> {
    let batch = Batch::of(Sort::Large, std::slice::from_ref(input))?;
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
