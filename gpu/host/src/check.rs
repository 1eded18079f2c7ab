//! The same runs on the host: the states after every scan, and the time.

use crate::batch::{Batch, Sort, Unfit};
use crate::device::DeviceError;
use crate::emulated::alone;
use crate::source::{Source, SourceError};
use scphd_filters::kind::Kind;
use scphd_filters::settings::Settings;
use scphd_gpu_kernels::joined;
use scphd_log::dimensions::Planar;
use scphd_log::events::{Event, events};
use scphd_log::log::Log;
use scphd_run::session::{SessionError, with_roomy_stack};
use std::time::Instant;

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

/// Runs the filter over a log on one core, as `scphd-sim` does, or a large one by the library's own scan. Returns the digest after
/// every scan or, without `digests`, whose computation would count as time, only after the last; and the wall time of all predictions
/// and scans, s.
///
/// # Errors
/// The filter refused the settings or a step.
pub fn on_host(
    source: &Source,
    log: &Log,
    settings: &Settings,
    seed: u64,
    digests: bool,
) -> Result<(Vec<u64>, f64), StudyError> {
    if source.sort(settings) == Sort::Large {
        let mut batch = Batch::new(Sort::Large);
        batch.push(log, settings, seed)?;
        let outcome = alone(&batch, u32::from(digests));
        let found = outcome.results.iter().map(|result| joined(result.digest)).filter(|digest| *digest != 0);
        return Ok((found.collect(), outcome.launched_s));
    }
    let drive = || {
        let mut slam = Planar::slam(source.filter(), log, settings, seed).map_err(SessionError::Start)?;
        let (mut found, mut seconds, mut scan) = (Vec::new(), 0.0, 0);
        for event in events(log) {
            let refused = |step| move |refusal| SessionError::Step { scan, t_s: log.scans[scan].t_s, step, refusal };
            let started = Instant::now();
            match event {
                Event::Predict { control, dt_s, .. } => {
                    slam.predict(control, dt_s).map_err(refused("the prediction"))?;
                }
                Event::Fix { fix } => {
                    slam.observe(&fix).map_err(refused("the fix"))?;
                }
                Event::Scan { index } => {
                    let taken = &log.scans[index];
                    slam.scan(taken.sensor, &taken.detections).map_err(refused("the scan"))?;
                    scan += 1;
                }
            }
            seconds += started.elapsed().as_secs_f64();
            if matches!(event, Event::Scan { .. }) && (digests || scan == log.scans.len()) {
                found.extend(slam.digest());
            }
            if scan == log.scans.len() {
                break;
            }
        }
        Ok((found, seconds))
    };
    let run = with_roomy_stack(drive).map_err(SessionError::Thread).and_then(|done| done);
    run.map_err(|why| StudyError::Session { run: 0, why })
}
