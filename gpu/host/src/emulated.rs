//! The threads of a batch on the host: the same bodies, over the same places, in the same buffers.

use crate::batch::Batch;
use crate::device::{Device, DeviceError, Launches, Outcome, of_scan, spans};
use scphd_gpu_kernels::{
    Inputs, Large, LargeSlot, Launch, Outputs, PREDICT, Room, STAGES, START, Slot, Span, Stage, follow, large_bytes,
    thread,
};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{Builder, available_parallelism, scope};
use std::time::Instant;

/// Slots are made of these, which are as much aligned.
type Word = u64;
const _: () = assert!(align_of::<Slot>() <= align_of::<Word>() && size_of::<Slot>().is_multiple_of(size_of::<Word>()));
const _: () = assert!(align_of::<Room>() <= align_of::<Word>());

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

/// Memory of so many things of so many bytes; all zero, as the memory of a device is set to be.
fn zeros(bytes: u64, count: usize) -> Vec<Word> {
    vec![0; (bytes as usize * count).div_ceil(size_of::<Word>())]
}

impl Device for Emulated {
    fn name(&self) -> &str {
        &self.name
    }

    fn slot_bytes(&self) -> usize {
        size_of::<Slot>()
    }

    fn resident(&self, _bytes_a_run: usize) -> Result<usize, DeviceError> {
        Ok(RESIDENT)
    }

    fn run(&mut self, batch: &Batch, launches: Launches) -> Result<Outcome, DeviceError> {
        let mut outcome = Outcome::untouched(batch);
        let mut slots = zeros(size_of::<Slot>() as u64, batch.runs.len());
        let started = Instant::now();
        for (first_scan, take_scans) in spans(batch.most_scans(), launches) {
            let launch = Launch {
                runs: batch.runs.as_ptr(),
                scans: batch.scans.as_ptr(),
                predictions: batch.predictions.as_ptr(),
                measurements: batch.measurements.as_ptr().cast(),
                slots: slots.as_mut_ptr().cast(),
                statuses: outcome.statuses.as_mut_ptr(),
                results: outcome.results.as_mut_ptr(),
                features: outcome.features.as_mut_ptr(),
                movers: outcome.movers.as_mut_ptr(),
                threads: batch.runs.len() as u32,
                first_scan,
                take_scans,
                digest_every: launches.digest_every,
            };
            let (threads, shared) = (batch.runs.len(), Shared(launch));
            // SAFETY: the buffers are those of a batch, whose runs have places of their own; each place comes once.
            self.places(threads, 1, |place| unsafe { thread(place, &shared.get()) })?;
        }
        outcome.launched_s = started.elapsed().as_secs_f64();
        Ok(outcome)
    }

    fn run_large(&mut self, batch: &Batch, digest_every: u32) -> Result<Outcome, DeviceError> {
        let mut outcome = Outcome::untouched(batch);
        let Some(run) = batch.runs.first() else { return Ok(outcome) };
        let [particles, samples] = [run.setup.particles, run.setup.samples].map(|count| count as usize);
        let [room, sight, desk, draft, _] = large_bytes();
        let mut room = zeros(room, 1);
        let mut sights = zeros(sight, particles * samples);
        let mut desks = zeros(desk, particles);
        let mut drafts = zeros(draft, particles);
        let shared = Shared(Large {
            run,
            scans: batch.scans.as_ptr(),
            predictions: batch.predictions.as_ptr(),
            measurements: batch.measurements.as_ptr().cast(),
            room: room.as_mut_ptr().cast(),
            sights: sights.as_mut_ptr().cast(),
            desks: desks.as_mut_ptr().cast(),
            drafts: drafts.as_mut_ptr().cast(),
            status: outcome.statuses.as_mut_ptr(),
            results: outcome.results.as_mut_ptr(),
            features: outcome.features.as_mut_ptr(),
            movers: outcome.movers.as_mut_ptr(),
        });
        let launch = |&(_, places, body): &Stage, scan| {
            // SAFETY: the buffers are those of a batch with this run, and what else it asks for, as zeros; they stay where they are. The
            // launches come in order, each with every place once, and this returns when it has ended.
            let body = |place| unsafe { body(place, &shared.get(), scan, digest_every) };
            self.places(places.count(particles, samples), PLACES, body)
        };
        START.iter().try_for_each(|stage| launch(stage, 0))?;
        let started = Instant::now();
        for scan in 0..run.scans {
            of_scan(batch, scan, [&PREDICT, &STAGES]).try_for_each(|stage| launch(stage, scan))?;
        }
        outcome.launched_s = started.elapsed().as_secs_f64();
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
    let mut memory = zeros(size_of::<LargeSlot>() as u64, 1);
    // SAFETY: it is as large and as much aligned, and zeros are a value of it, as `slot.rs` of the kernels holds all slots to.
    let slot = unsafe { &mut *memory.as_mut_ptr().cast::<LargeSlot>() };
    let measurements: Vec<_> = batch.measurements.iter().map(|&z| z.into()).collect();
    let inputs = Inputs { run, scans: &batch.scans, predictions: &batch.predictions, measurements: &measurements };
    let Outcome { statuses, results, features, movers, .. } = &mut outcome;
    let mut outputs = Outputs { results, features, movers };
    let started = Instant::now();
    let span = Span { first: 0, scans: batch.scans.len(), digest_every: digest_every as usize };
    let status = follow(inputs, slot, &mut outputs, span);
    statuses.fill(status);
    outcome.launched_s = started.elapsed().as_secs_f64();
    outcome
}
