//! The interface of devices that run the threads of a batch.

use crate::batch::Batch;
use bytemuck::Zeroable;
use scphd_gpu_kernels::{
    Feature, LargeMemory, Memory, Mover, Places, ScanResult, Size, Stage, Status, parts, streams, words,
};
use std::path::PathBuf;

/// The outputs of a batch.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// How each run ended.
    pub statuses: Vec<Status>,
    /// The results of all scans.
    pub results: Vec<ScanResult>,
    /// The estimated features of all runs.
    pub features: Vec<Feature>,
    /// The estimated moving features of all runs.
    pub movers: Vec<Mover>,
    /// Wall time of all launches except those of digests, without copies, s.
    pub launched_s: f64,
}

impl Outcome {
    /// The outputs before the first launch: zeros.
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
pub enum DeviceError {
    /// There is no device, because there is no driver.
    #[error("no CUDA driver (no libcuda on this machine)")]
    NoDriver,
    /// The driver has found no device.
    #[error("no CUDA device: {0}")]
    NoDevice(String),
    /// The module cannot be read.
    #[error("{path}: {why}", path = .path.display())]
    Module {
        /// The file or folder of the module.
        path: PathBuf,
        /// The reason.
        why: String,
    },
    /// The driver has refused a request.
    #[error("{doing}: {why}")]
    Driver {
        /// The request.
        doing: &'static str,
        /// The driver's reason.
        why: String,
    },
    /// The system cannot start a thread.
    #[error("cannot start a thread: {0}")]
    Thread(std::io::Error),
}

/// A device that runs the threads of a batch.
pub trait Device {
    /// Name of the device.
    fn name(&self) -> &str;

    /// Bytes of memory for one run of the batch, without inputs and results.
    fn run_bytes(&self, batch: &Batch) -> usize;

    /// Number of runs whose memory fits at the same time, if each needs `bytes_a_run` bytes.
    fn resident(&self, bytes_a_run: usize) -> Result<usize, DeviceError>;

    /// Processes all scans of every run of the batch, launch by launch, with a digest after every `digest_every` scans and after
    /// the last.
    fn run(&mut self, batch: &Batch, digest_every: u32) -> Result<Outcome, DeviceError>;

    /// A further report on the last batch, if there is one.
    fn report(&self) -> Option<String> {
        None
    }
}

/// Bytes of all rooms, sights, desks, drafts, streams and parts of a batch, given the bytes of one of each, and of all words.
pub(crate) fn buffers(batch: &Batch, [room, sight, desk, draft, stream, part]: [usize; 6]) -> [usize; 7] {
    let (filters, [particles, samples]) = (batch.runs.len(), batch.most());
    let candidates = particles * samples;
    let words = if batch.is_large() { words::<LargeMemory> } else { words::<Memory> };
    [
        room,
        sight * candidates,
        desk * particles,
        draft * particles,
        stream * streams(candidates),
        part * parts(candidates),
        size_of::<u32>() * words(particles, samples),
    ]
    .map(|each| each * filters)
}

/// The launches for a scan of a batch, in order: `predicting` for every prediction before it, then `scanning`.
pub(crate) fn of_scan<'s, S>(
    batch: &Batch,
    scan: u32,
    [predicting, scanning]: [&'s [S]; 2],
) -> impl Iterator<Item = &'s S> {
    (0..batch.predictions_before(scan)).flat_map(move |_| predicting).chain(scanning)
}

/// A kernel by its name, and how its number of threads is computed.
#[derive(Debug, Clone)]
pub(crate) struct Launch {
    pub(crate) kernel: String,
    count: fn(Places, usize, usize) -> usize,
    places: Places,
}

impl Launch {
    fn of<M: Size>(stage: &Stage<M>) -> Self {
        Self { kernel: format!("{}_{}", M::NAME, stage.name), count: Places::count::<M>, places: stage.places }
    }

    /// The launches that start filters of a size, those of a prediction, those of a scan, and that of a digest.
    pub(crate) fn all<M: Size>() -> [Vec<Self>; 4] {
        [Stage::<M>::STARTING, Stage::PREDICTING, Stage::SCANNING, Stage::DIGESTING]
            .map(|stages| stages.iter().map(Self::of).collect())
    }

    /// Name of the kernel that writes the bytes of the buffers' elements of filters of a size.
    pub(crate) fn bytes<M: Size>() -> String {
        format!("{}_bytes", M::NAME)
    }

    /// Number of threads for a batch.
    pub(crate) fn threads(&self, batch: &Batch) -> usize {
        let [particles, samples] = batch.most();
        batch.runs.len() * (self.count)(self.places, particles, samples)
    }
}
