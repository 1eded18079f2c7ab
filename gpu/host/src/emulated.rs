//! The threads of a batch on the host: the same bodies, over the same places, in the same buffers.

use crate::batch::Batch;
use crate::device::{Device, DeviceError, Outcome, buffers, of_scan};
use scphd_gpu_kernels::{
    Filters, Inputs, LargeMemory, Memory, Outputs, Places, Room, Size, Slot, Stage, bytes, follow,
};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{Builder, available_parallelism, scope};
use std::time::Instant;

/// Buffers are made of these, which are as much aligned.
type Word = u64;

/// Runs at once, whatever there is of them: a host has no other limit than what it takes to hold them.
const RESIDENT: usize = 64;

/// Threads of the host in place of those of a device.
#[derive(Debug, Clone)]
pub struct Emulated {
    threads: usize,
    name: String,
}

impl Emulated {
    /// With so many threads; as many as the machine has cores where it is not said.
    #[must_use]
    pub fn new(threads: Option<usize>) -> Self {
        let threads = threads.unwrap_or_else(|| available_parallelism().map_or(1, usize::from)).max(1);
        let name = format!("emulated, {threads} thread{} of the host", if threads == 1 { "" } else { "s" });
        Self { threads, name }
    }
}

/// Places that a thread takes at once where there are thousands.
const PLACES: usize = 16;

/// What the threads share.
struct Shared<L>(L);

// SAFETY: every place is taken by one thread, and what places have in common is only read.
unsafe impl<L> Sync for Shared<L> {}

/// Memory of so many bytes; all zero, as the memory of a device is set to be.
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

/// Bytes of what the buffers are made of.
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
            // SAFETY: the buffers are those of a batch, and what else its runs ask for, as zeros; they stay where they are. The launches come
            // in order, each with every place once, and this returns when it has ended.
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
    /// Every place once, and one more than there are, as a grid has; `each` at a time.
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

/// The batch's first run by the library's own scan, on this thread, over the state of a large filter.
pub(crate) fn alone(batch: &Batch, digest_every: u32) -> Outcome {
    let mut outcome = Outcome::untouched(batch);
    let Some(run) = batch.runs.first() else { return outcome };
    let mut memory = zeros(size_of::<Slot<LargeMemory>>());
    // SAFETY: it is as large and as much aligned, and zeros are a value of it, as `slot.rs` of the kernels holds all slots to.
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
