//! Runs on a device, as many at a time as it has memory for.

use crate::batch::{Batch, Sort};
use crate::device::{Asked, Machine};
use crate::failure::Failure;
use crate::played::Played;
use rayon::prelude::*;
use scphd::Health;
use scphd_filters::settings::Settings;
use scphd_filters::slam::Filter;
use scphd_log::log::Log;
use std::borrow::Cow;

/// The inputs of a run: log, settings and seed.
pub type Input<'l> = (Cow<'l, Log>, Settings, u64);

/// The cost of all runs on a device.
#[derive(Debug, Default)]
pub struct Took {
    /// Number of runs at a time.
    pub resident: usize,
    /// Wall time of all launches, s.
    pub launched_s: f64,
    /// Numbers of runs and of scans whose memory was too small, so that more memory would have given other results.
    pub short: [usize; 2],
}

/// Number of runs at a time if there is no limit of the memory, and the greatest one: more would not be faster, and outputs take
/// memory of the host too.
const RESIDENT: usize = 64;
const MOST: usize = 4096;
/// The conditions that report that memory was too small.
const SHORT: [Health; 3] = [Health::PRUNING_TIGHTENED, Health::MAP_NOT_UPDATED, Health::COMPONENTS_LOST];

/// Processes `runs` runs of a filter, and passes each of them to `each`; inputs and outputs are processed by the threads of a pool.
pub fn run_all<'l, R: Send, E: From<Failure> + Send>(
    device: &mut dyn Machine,
    pool: &rayon::ThreadPool,
    (filter, asked): (Filter, Asked),
    runs: usize,
    input: impl Fn(usize) -> Result<Input<'l>, E> + Sync,
    each: impl Fn(usize, Played<'_>, &Input<'l>) -> Result<R, E> + Sync,
) -> Result<(Took, Vec<R>), E> {
    let mut took = Took { resident: runs.min(MOST), ..Took::default() };
    let mut done = Vec::with_capacity(runs);
    let batch_of = |inputs: &[Input<'l>]| Batch::of(Sort::of(filter, &inputs[0].1)?, inputs);
    let free = device.free()?;
    // A tenth of the free memory is for the stacks of all threads.
    let fitting = |bytes: usize| free.map_or(RESIDENT, |free| (free / 10 * 9 / bytes).max(1));
    while done.len() < runs {
        let first = done.len();
        let places = first..runs.min(first + took.resident);
        let mut inputs: Vec<Input<'l>> =
            pool.install(|| places.into_par_iter().map(&input).collect::<Result<_, E>>())?;
        let mut batch = batch_of(&inputs)?;
        let bytes = batch.bytes() / inputs.len() + device.run_bytes(&batch)?;
        if fitting(bytes) < inputs.len() {
            took.resident = fitting(bytes);
            inputs.truncate(took.resident);
            batch = batch_of(&inputs)?;
        }
        let outcome = device.run(&batch, asked)?;
        took.launched_s += outcome.launched_s;
        let of_one = |(place, input): (usize, &Input<'l>)| {
            let played = Played::of(&batch, &outcome, place, bytes);
            let bits = SHORT.iter().fold(0, |bits, condition| bits | u32::from(condition.bits()));
            let short = played.results().iter().filter(|result| result.health & bits != 0).count();
            Ok((short, each(first + place, played, input)?))
        };
        let of_all: Vec<(usize, R)> =
            pool.install(|| inputs.par_iter().enumerate().map(of_one).collect::<Result<_, E>>())?;
        for (short, result) in of_all {
            took.short = [took.short[0] + usize::from(short > 0), took.short[1] + short];
            done.push(result);
        }
    }
    Ok((took, done))
}
