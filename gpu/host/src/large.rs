//! One large filter on a device, compared with the library's own on one core of the host.

use crate::batch::Batch;
use crate::check::Difference;
use crate::device::{Device, Outcome};
use crate::emulated::alone;
use crate::source::Source;
use crate::study::{Short, StudyError};
use scphd_gpu_kernels::{LARGE_PARTICLES, SAMPLES, ScanResult, Status};

/// The inputs of a large filter: one run of at most `most_scans` scans.
///
/// # Errors
/// The kernels have no capacity or no code for it.
pub fn large(source: &Source, seed: u64, most_scans: usize) -> Result<Batch, StudyError> {
    let mut log = source.log(seed)?;
    let settings = source.settings(&log)?;
    log.scans.truncate(most_scans);
    let mut batch = Batch::with_room([LARGE_PARTICLES, SAMPLES]);
    batch.push(&log, &settings, seed)?;
    Ok(batch)
}

/// The outcome of a large filter's run.
#[derive(Debug, Clone)]
pub struct LargeRun {
    /// The result after every scan.
    pub results: Vec<ScanResult>,
    /// Mean wall time of a scan with the predictions before it, ms.
    pub scan_ms: f64,
}

impl LargeRun {
    /// Runs the filter on a device, with a digest after every `digest_every` scans.
    ///
    /// # Errors
    /// The run has stopped, or the device does not work.
    pub fn on(device: &mut dyn Device, batch: &Batch, digest_every: u32) -> Result<Self, StudyError> {
        Self::of(device.run(batch, digest_every)?)
    }

    /// Runs the filter by the library's own scan, on one core, over a state with the same capacities.
    pub fn alone(batch: &Batch, digest_every: u32) -> Result<Self, StudyError> {
        Self::of(alone(batch, digest_every))
    }

    fn of(outcome: Outcome) -> Result<Self, StudyError> {
        let Outcome { statuses, results, launched_s, .. } = outcome;
        match statuses[..] {
            [Status { code: Status::DONE, .. }] => {
                Ok(Self { scan_ms: 1e3 * launched_s / results.len().max(1) as f64, results })
            }
            [Status { code, scans }, ..] => Err(StudyError::Stopped { run: 0, scan: scans, why: Status::text(code) }),
            [] => Err(StudyError::Stopped { run: 0, scan: 0, why: Status::text(Status::UNTOUCHED) }),
        }
    }

    /// Number of scans for which the pages or the capacity of a map did not suffice.
    pub fn short_scans(&self) -> usize {
        Short::scans_of(&self.results)
    }

    /// The greatest numbers of pages of static and of moving features that a scan has used.
    pub fn peak_pages(&self) -> [u32; 2] {
        let most = |of: fn(&ScanResult) -> u32| self.results.iter().map(of).max().unwrap_or(0);
        [most(|result| result.peak_pages), most(|result| result.peak_moving_pages)]
    }

    /// The first scan after which the state differs from that of another run of the same filter.
    pub fn difference(&self, host: &Self, seed: u64) -> Option<Difference> {
        let pairs = host.results.iter().zip(&self.results).enumerate();
        let mut differ = pairs.filter(|(_, (host, device))| host.digest != device.digest);
        differ.next().map(|(scan, (host, device))| Difference { seed, scan, host: host.digest, device: device.digest })
    }
}
