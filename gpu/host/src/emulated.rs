//! An emulated device: runs the threads of a batch on the host, with the same functions, places and buffers.

use crate::batch::Batch;
use crate::device::{Device, DeviceError, Outcome, buffers, of_scan};
use scphd_gpu_kernels::{
    Filters, Inputs, LargeMemory, Memory, Outputs, Places, Room, Size, Slot, Stage, bytes, follow,
};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{Builder, available_parallelism, scope};
use std::time::Instant;

/// Element of the memory of all buffers, with an alignment that suffices for all of them.
type Word = u64;

/// Number of runs at a time. The host needs no other limit than the memory for them.
const RESIDENT: usize = 64;

/// Threads of the host that stand in for those of a device.
#[derive(Debug, Clone)]
pub struct Emulated {
    threads: usize,
    name: String,
}

impl Emulated {
    /// An emulated device with this number of threads; by default, one for each core.
    pub fn new(threads: Option<usize>) -> Self {
        let threads = threads.unwrap_or_else(|| available_parallelism().map_or(1, usize::from)).max(1);
        let name = format!("emulated, {threads} thread{} of the host", if threads == 1 { "" } else { "s" });
        Self { threads, name }
    }
}

/// Number of places that a thread takes at a time, if there are many.
const PLACES: usize = 16;

/// Makes a value usable by several threads.
struct Shared<L>(L);

// SAFETY: every place is processed by one thread, and data that places share is only read.
unsafe impl<L> Sync for Shared<L> {}

/// Memory of at least `bytes` bytes, all zero, as on a device.
fn zeros(bytes: usize) -> Vec<Word> {
    vec![0; bytes.div_ceil(size_of::<Word>())]
}

impl Device for Emulated {
    fn name(&self) -> &str {
        &self.name
    }

    fn run_bytes(&self, batch: &Batch) -> usize {
        let bytes = if batch.is_large() { sizes::<LargeMemory>() } else { sizes::<Memory>() };
        buffers(batch, bytes).iter().sum::<usize>() / batch.runs.len().max(1)
    }

    fn resident(&self, _bytes_a_run: usize) -> Result<usize, DeviceError> {
        Ok(RESIDENT)
    }

    fn run(&mut self, batch: &Batch, digest_every: u32) -> Result<Outcome, DeviceError> {
        if batch.is_large() {
            self.run_of::<LargeMemory>(batch, digest_every)
        } else {
            self.run_of::<Memory>(batch, digest_every)
        }
    }
}

/// Bytes of one element of each buffer.
fn sizes<M: Size>() -> [usize; 6] {
    let [room, sight, desk, draft, stream, part, _] = bytes::<M>();
    [room, sight, desk, draft, stream, part].map(|bytes| bytes as usize)
}

impl Emulated {
    fn run_of<M: Size>(&mut self, batch: &Batch, digest_every: u32) -> Result<Outcome, DeviceError> {
        const { assert!(align_of::<Room<M>>() <= align_of::<Word>()) };
        let mut outcome = Outcome::untouched(batch);
        let [particles, samples] = batch.most();
        let [mut rooms, mut sights, mut desks, mut drafts, mut streams, mut parts, mut words] =
            buffers(batch, sizes::<M>()).map(zeros);
        let filters = Filters::<M> {
            runs: batch.runs.as_ptr(),
            scans: batch.scans.as_ptr(),
            predictions: batch.predictions.as_ptr(),
            measurements: batch.measurements.as_ptr().cast(),
            rooms: rooms.as_mut_ptr().cast(),
            sights: sights.as_mut_ptr().cast(),
            desks: desks.as_mut_ptr().cast(),
            drafts: drafts.as_mut_ptr().cast(),
            streams: streams.as_mut_ptr().cast(),
            parts: parts.as_mut_ptr().cast(),
            words: words.as_mut_ptr().cast(),
            statuses: outcome.statuses.as_mut_ptr(),
            results: outcome.results.as_mut_ptr(),
            features: outcome.features.as_mut_ptr(),
            movers: outcome.movers.as_mut_ptr(),
            count: batch.runs.len() as u64,
            particles: particles as u64,
            samples: samples as u64,
        };
        let shared = Shared(filters);
        let launch = |stage: &Stage<M>, scan| {
            let threads = batch.runs.len() * stage.places.count::<M>(particles, samples);
            // SAFETY: the buffers are those of the batch, and the memory that its runs need, as zeros; they do not move. The
            // launches come in order, each with every place once, and `places` returns when its launch has ended.
            let body = |place| unsafe { stage.run(place, &shared.get(), scan, digest_every) };
            self.places(threads, if stage.places == Places::One { 1 } else { PLACES }, body)
        };
        Stage::STARTING.iter().try_for_each(|stage| launch(stage, 0))?;
        let (started, mut digests_s) = (Instant::now(), 0.0);
        for scan in 0..batch.most_scans() {
            of_scan(batch, scan, [Stage::PREDICTING, Stage::SCANNING]).try_for_each(|stage| launch(stage, scan))?;
            if batch.asks_for_digest(scan, digest_every) {
                let begun = Instant::now();
                launch(&Stage::DIGEST, scan)?;
                digests_s += begun.elapsed().as_secs_f64();
            }
        }
        outcome.launched_s = started.elapsed().as_secs_f64() - digests_s;
        Ok(outcome)
    }
}

impl<L: Copy> Shared<L> {
    fn get(&self) -> L {
        self.0
    }
}

impl Emulated {
    /// Runs every place once, and one place more, as a grid may have; each thread takes `each` places at a time.
    fn places(&self, count: usize, each: usize, body: impl Fn(usize) + Sync) -> Result<(), DeviceError> {
        let next = AtomicUsize::new(0);
        let work = || {
            loop {
                let first = next.fetch_add(each, Ordering::Relaxed);
                if first > count {
                    break;
                }
                (first..first + each).filter(|&place| place <= count).for_each(&body);
            }
        };
        if count == 1 {
            work();
            return Ok(());
        }
        scope(|scope| {
            let started = (0..self.threads).map(|_| Builder::new().spawn_scoped(scope, work).map(drop));
            started.collect::<Result<(), _>>().map_err(DeviceError::Thread)
        })
    }
}

/// Processes the batch's first run by the library's own scan, on this thread, over the state of a large filter.
pub(crate) fn alone(batch: &Batch, digest_every: u32) -> Outcome {
    let mut outcome = Outcome::untouched(batch);
    let Some(run) = batch.runs.first() else { return outcome };
    let mut memory = zeros(size_of::<Slot<LargeMemory>>());
    // SAFETY: the memory is large and aligned enough, and zeros are a valid slot, which `slot.rs` of the kernels checks.
    let slot = unsafe { &mut *memory.as_mut_ptr().cast::<Slot<LargeMemory>>() };
    let measurements: Vec<_> = batch.measurements.iter().map(|&z| z.into()).collect();
    let inputs = Inputs { run, scans: &batch.scans, predictions: &batch.predictions, measurements: &measurements };
    let Outcome { statuses, results, features, movers, .. } = &mut outcome;
    let mut outputs = Outputs { results, features, movers };
    let started = Instant::now();
    let status = follow(inputs, slot, &mut outputs, digest_every as usize);
    statuses.fill(status);
    outcome.launched_s = started.elapsed().as_secs_f64();
    outcome
}
