//! The threads of a batch on the host: the same bodies, over the same places, in the same buffers.

use crate::batch::Batch;
use crate::device::{Device, DeviceError, Launches, Outcome, spans};
use scphd_gpu_kernels::{Launch, Slot, thread};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{Builder, available_parallelism, scope};
use std::time::Instant;

/// Slots are made of these, which are as much aligned.
type Word = u64;
const _: () = assert!(align_of::<Slot>() <= align_of::<Word>() && size_of::<Slot>().is_multiple_of(size_of::<Word>()));

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

/// What the threads share.
struct Shared(Launch);

// SAFETY: every place is taken by one thread, and what places have in common is only read.
unsafe impl Sync for Shared {}

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
        // All zero, as the memory of a device is set to be.
        let mut slots: Vec<Word> = vec![0; batch.runs.len() * size_of::<Slot>() / size_of::<Word>()];
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
            self.launch(&Shared(launch))?;
        }
        outcome.launched_s = started.elapsed().as_secs_f64();
        Ok(outcome)
    }
}

impl Emulated {
    /// Every place once, and one more than there are, as a grid has.
    fn launch(&self, shared: &Shared) -> Result<(), DeviceError> {
        let next = AtomicUsize::new(0);
        let work = || {
            loop {
                let place = next.fetch_add(1, Ordering::Relaxed);
                // SAFETY: the buffers are those of a batch, whose runs have places of their own; each place comes once.
                unsafe { thread(place, &shared.0) };
                if place >= shared.0.threads as usize {
                    break;
                }
            }
        };
        scope(|scope| {
            let started = (0..self.threads).map(|_| Builder::new().spawn_scoped(scope, work).map(drop));
            started.collect::<Result<(), _>>().map_err(DeviceError::Thread)
        })
    }
}
