//! Who runs the threads of a batch.

use crate::batch::Batch;
use bytemuck::Zeroable;
use scphd_gpu_kernels::{Feature, Mover, ScanResult, Status};
use std::path::PathBuf;

/// How a batch is launched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Launches {
    /// Digests after every so many scans, and after the last; 0: after the last alone.
    pub digest_every: u32,
    /// Scans of a launch; 0: all, so that the host has no part in a run. A display's card ends launches of more than some seconds.
    pub scans: u32,
}

/// What a batch leaves.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// How each run has ended.
    pub statuses: Vec<Status>,
    /// The results of all scans.
    pub results: Vec<ScanResult>,
    /// The estimated features of all runs.
    pub features: Vec<Feature>,
    /// The estimated moving features of all runs.
    pub movers: Vec<Mover>,
    /// Wall time of all launches, without copies, s.
    pub launched_s: f64,
}

impl Outcome {
    /// Nothing yet.
    pub(crate) fn untouched(batch: &Batch) -> Self {
        let [features, movers] = batch.rooms();
        Self {
            statuses: vec![Status::zeroed(); batch.runs.len()],
            results: vec![ScanResult::zeroed(); batch.scans.len()],
            features: vec![Feature::zeroed(); features],
            movers: vec![Mover::zeroed(); movers],
            launched_s: 0.0,
        }
    }
}

/// Why a device does not work.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DeviceError {
    /// There is none, because there is no driver for it.
    #[error("no CUDA driver (no libcuda on this machine)")]
    NoDriver,
    /// The driver knows no device.
    #[error("no CUDA device: {0}")]
    NoDevice(String),
    /// The module cannot be read.
    #[error("{path}: {why}", path = .path.display())]
    Module {
        /// Its file or folder.
        path: PathBuf,
        /// Why.
        why: String,
    },
    /// The driver has said no.
    #[error("{doing}: {why}")]
    Driver {
        /// What was asked of it.
        doing: &'static str,
        /// Its reason.
        why: String,
    },
    /// The system has no thread.
    #[error("cannot start a thread: {0}")]
    Thread(std::io::Error),
}

/// Whatever runs the threads of a batch.
pub trait Device {
    /// What it is.
    fn name(&self) -> &str;

    /// Bytes of a slot.
    fn slot_bytes(&self) -> usize;

    /// How many runs it has memory for at once, if each takes so many bytes beside its slot.
    ///
    /// # Errors
    /// It cannot tell.
    fn resident(&self, bytes_a_run: usize) -> Result<usize, DeviceError>;

    /// Takes every run of the batch through its scans.
    ///
    /// # Errors
    /// The device does not work.
    fn run(&mut self, batch: &Batch, launches: Launches) -> Result<Outcome, DeviceError>;

    /// Takes one large filter, the batch's first run, through its scans, launch by launch; with a digest after every so many of them.
    ///
    /// # Errors
    /// The device does not work.
    fn run_large(&mut self, batch: &Batch, digest_every: u32) -> Result<Outcome, DeviceError>;

    /// What else it has to say of the last batch.
    fn report(&self) -> Option<String> {
        None
    }
}

/// What is launched for a scan of a large filter, in order: `predict` for every prediction before it, then `stages`.
pub(crate) fn of_scan<'s, S>(batch: &Batch, scan: u32, [predict, stages]: [&'s [S]; 2]) -> impl Iterator<Item = &'s S> {
    (0..batch.predictions_before(scan)).flat_map(move |_| predict).chain(stages)
}

/// The first scans of every launch, and how many there are in each.
pub(crate) fn spans(most_scans: u32, launches: Launches) -> impl Iterator<Item = (u32, u32)> {
    let each = if launches.scans == 0 { most_scans.max(1) } else { launches.scans };
    (0..most_scans).step_by(each as usize).map(move |first| (first, each))
}

#[cfg(test)]
mod tests {
    use super::{Launches, spans};

    #[test]
    fn launches_cover_all_scans() {
        let of = |most, scans| spans(most, Launches { scans, digest_every: 0 }).collect::<Vec<_>>();
        assert_eq!(of(300, 0), [(0, 300)]);
        assert_eq!(of(300, 128), [(0, 128), (128, 128), (256, 128)]);
        assert_eq!(of(0, 0), []);
    }
}
