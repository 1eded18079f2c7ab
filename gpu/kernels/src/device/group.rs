//! The buffers of all filters of a launch, the data of one of them, and what every stage needs first: whether its filter continues,
//! and the state between the launches of a scan.

use super::outputs::Outputs;
use super::room::{Between, COLUMNS, DraftOf, Kind, PAGES_TOGETHER, PartPlace, Sight, TOGETHER, WHOLES};
use super::store::LANES;
use crate::buffer::{Feature, Layout, Prediction, Run, Scan, ScanResult, Status};
use crate::launches::{HELPERS, Places};
use crate::memory::Particles;
use crate::run::Inputs;
use core::mem::MaybeUninit;
use core::ops::{Deref, Range};
use core::slice::{from_raw_parts, from_raw_parts_mut};
use core::sync::atomic::AtomicU32;
use nalgebra::Vector2;
use scphd::numerics::Noise;
use scphd::storage::PART;

/// The buffers of all filters of a launch, in the device's memory. In each buffer, the data of a filter is followed by that of
/// the next, all with capacity for the particles and samples of the largest filter. The host writes it.
#[repr(C)]
pub(super) struct Filters<M: Kind> {
    /// The runs, one for each filter.
    pub(super) runs: *const Run,
    /// The scans of all runs.
    pub(super) scans: *const Scan,
    /// The predictions of all runs.
    predictions: *const Prediction,
    /// The measurements of all runs.
    measurements: *const Vector2<f32>,
    /// The filters, which start as zeros.
    pub(super) rooms: *mut M::Room,
    /// One for each candidate.
    pub(super) sights: *mut Sight,
    /// One for each particle. They start as zeros.
    pub(super) desks: *mut M::Desk,
    /// One for each particle.
    pub(super) drafts: *mut MaybeUninit<DraftOf>,
    /// One for each [`TOGETHER`] candidates.
    pub(super) streams: *mut MaybeUninit<Noise>,
    /// One for each part of the candidates.
    pub(super) parts: *mut PartPlace,
    /// Scratch.
    words: *mut u32,
    /// The status of every run.
    pub(super) statuses: *mut Status,
    /// A result for each scan.
    pub(super) results: *mut ScanResult,
    /// Memory for the estimated features of all runs.
    features: *mut Feature,
    /// Number of filters.
    pub(super) count: u64,
    /// The greatest number of particles of a filter.
    particles: u64,
    /// The greatest number of samples of a particle.
    samples: u64,
}

impl<M: Kind> Clone for Filters<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: Kind> Copy for Filters<M> {}

/// The data of one filter of a launch: its part of every buffer, and the columns of its scratch.
pub(super) struct Group<M: Kind> {
    own: Filters<M>,
    pub(super) cumulated: *mut f32,
    /// Distance between two columns, in numbers.
    pub(super) stride: usize,
    pub(super) columns: *mut f32,
    pub(super) wholes: *mut u32,
    pub(super) held: *mut AtomicU32,
    pub(super) firsts: *mut u32,
    /// The scan, and the number of scans between two digests; 0 for one after the last scan only.
    pub(super) scan: u32,
    digest_every: u32,
}

impl<M: Kind> Deref for Group<M> {
    type Target = Filters<M>;

    fn deref(&self) -> &Filters<M> {
        &self.own
    }
}

/// A `u32` as `usize`. The machine has at least 32 bits.
pub(super) fn whole(number: u32) -> usize {
    number as usize
}

/// The elements of a part of `count` things; `None` beyond the last.
pub(super) fn part(place: usize, count: usize) -> Option<Range<usize>> {
    let first = place * PART;
    (first < count).then(|| first..count.min(first + PART))
}

/// Numbers of parts of the pages of static features, and of those of moving ones.
pub(super) fn page_parts<M: Kind>() -> [usize; 2] {
    M::PAGES.map(|pages| pages.div_ceil(PAGES_TOGETHER))
}

/// Numbers of parts and of words of scratch of a filter.
fn scratch<M: Kind>(particles: usize, samples: usize) -> [usize; 2] {
    let pages = M::ALL_PAGES + page_parts::<M>().iter().sum::<usize>();
    [(particles * samples).div_ceil(PART), particles * (samples + COLUMNS + WHOLES) + pages]
}

impl<M: Kind> Filters<M> {
    /// Number of threads of a launch for each filter.
    pub(super) fn threads(&self, places: Places) -> u64 {
        Self::places(places, self.particles, self.samples)
    }

    fn places(places: Places, particles: u64, samples: u64) -> u64 {
        match places {
            Places::One => 1,
            Places::Leader => HELPERS as u64 + 1,
            Places::Pages => M::ALL_PAGES as u64,
            Places::PageParts => page_parts::<M>().iter().sum::<usize>() as u64,
            Places::Candidates => particles * samples,
            Places::Particles => particles,
            Places::Lanes => particles * LANES as u64,
            Places::CandidateParts => (particles * samples).div_ceil(PART as u64),
            Places::ParticleParts => particles.div_ceil(PART as u64),
            Places::Columns => COLUMNS as u64,
        }
    }

    /// The memory and the threads of a filter with `particles` particles and `samples` samples of each.
    pub(super) fn layout(particles: u64, samples: u64) -> Layout {
        const fn of<T>() -> [usize; 2] {
            [size_of::<T>(), align_of::<T>()]
        }
        let all = [of::<M::Room>(), of::<Sight>(), of::<M::Desk>(), of::<DraftOf>(), of::<Noise>(), of::<PartPlace>()];
        let alignment = all.iter().fold(1, |most, [_, alignment]| most.max(*alignment));
        let [room, sight, desk, draft, stream, part] = all.map(|[size, _]| size);
        let (particles, samples) = (particles as usize, samples as usize);
        let (candidates, [parts, words]) = (particles * samples, scratch::<M>(particles, samples));
        let (streams, words) = (stream * candidates.div_ceil(TOGETHER), size_of::<u32>() * words);
        let buffers = [room, sight * candidates, desk * particles, draft * particles, streams, part * parts, words];
        let threads = Places::ALL.map(|places| Self::places(places, particles as u64, samples as u64));
        Layout { buffers: buffers.map(|bytes| bytes as u64), alignment: alignment as u64, threads }
    }

    /// The data of one filter, in a launch for a scan.
    ///
    /// # Safety
    /// There is such a filter, and every pointer leads to as many values as the numbers of filters, particles and samples and the
    /// runs require.
    pub(super) unsafe fn group(&self, filter: usize, [scan, digest_every]: [u32; 2]) -> Group<M> {
        let (particles, samples) = (self.particles as usize, self.samples as usize);
        let (candidates, [parts, words]) = (particles * samples, scratch::<M>(particles, samples));
        // SAFETY: the caller guarantees it.
        unsafe {
            let cumulated = self.words.add(filter * words);
            let columns = cumulated.add(candidates);
            let wholes = columns.add(COLUMNS * particles);
            let held = wholes.add(WHOLES * particles);
            let run = &*self.runs.add(filter);
            let own = Self {
                runs: run,
                scans: self.scans.add(whole(run.first_scan)),
                predictions: self.predictions.add(whole(run.first_prediction)),
                measurements: self.measurements.add(whole(run.first_measurement)),
                rooms: self.rooms.add(filter),
                sights: self.sights.add(filter * candidates),
                desks: self.desks.add(filter * particles),
                drafts: self.drafts.add(filter * particles),
                streams: self.streams.add(filter * candidates.div_ceil(TOGETHER)),
                parts: self.parts.add(filter * parts),
                statuses: self.statuses.add(filter),
                results: self.results.add(whole(run.first_scan)),
                features: self.features.add(whole(run.first_feature)),
                ..*self
            };
            Group {
                own,
                cumulated: cumulated.cast(),
                stride: particles,
                columns: columns.cast(),
                wholes,
                held: held.cast(),
                firsts: held.add(M::ALL_PAGES),
                scan,
                digest_every,
            }
        }
    }
}

impl<M: Kind> Group<M> {
    /// Whether the run has not stopped and has this scan.
    pub(super) unsafe fn goes_on(&self) -> bool {
        // SAFETY: there is a status, which only single-thread launches write, and a run, which is never written.
        unsafe { (*self.statuses).code == Status::DONE && self.scan < (*self.runs).scans }
    }

    /// Whether the run needs a digest after this scan.
    pub(super) unsafe fn asks_for_digest(&self) -> bool {
        let taken = self.scan.saturating_add(1);
        // SAFETY: as in `goes_on`.
        unsafe { self.goes_on() && (taken.checked_rem(self.digest_every) == Some(0) || taken == (*self.runs).scans) }
    }

    /// The inputs of the run.
    pub(super) unsafe fn inputs<'r>(&self) -> Inputs<'r> {
        // SAFETY: the inputs are where the run says, and are never written.
        unsafe {
            let run = &*self.runs;
            Inputs {
                run,
                scans: from_raw_parts(self.scans, whole(run.scans)),
                predictions: from_raw_parts(self.predictions, whole(run.predictions)),
                measurements: from_raw_parts(self.measurements, whole(run.measurements)),
            }
        }
    }

    /// The outputs of the run, for the only thread that writes them.
    pub(super) unsafe fn outputs<'r>(&self) -> Outputs<'r> {
        // SAFETY: the outputs are where the run says.
        unsafe {
            let run = &*self.runs;
            Outputs {
                results: from_raw_parts_mut(self.results, whole(run.scans)),
                features: from_raw_parts_mut(self.features, whole(run.features)),
            }
        }
    }
}

impl<M: Particles> Group<M> {
    /// The state between the launches of a scan; `None` if the run has stopped.
    pub(super) unsafe fn between<'r>(&self) -> Option<&'r Between> {
        // SAFETY: `open` has initialised it, or has stopped the run.
        unsafe { self.goes_on().then(|| (*self.rooms).between.assume_init_ref()) }
    }

    /// The same state, mutable, for the only thread of a launch.
    pub(super) unsafe fn alone<'r>(&self) -> Option<&'r mut Between> {
        // SAFETY: as in `between`, and no other thread accesses it.
        unsafe { self.goes_on().then(|| (*self.rooms).between.assume_init_mut()) }
    }

    /// The parts of `things` elements, for one thread.
    pub(super) unsafe fn all_parts<'r>(&self, things: usize) -> &'r mut [PartPlace] {
        // SAFETY: the buffer has this number of parts.
        unsafe { from_raw_parts_mut(self.parts, things.div_ceil(PART)) }
    }

    /// The first `count` drafts, for one thread.
    pub(super) unsafe fn all_drafts<'r>(&self, count: usize) -> &'r mut [DraftOf] {
        // SAFETY: `desks` has initialised one for each particle.
        unsafe { from_raw_parts_mut(self.drafts.cast(), count) }
    }

    /// The draft at this place, for its thread.
    pub(super) unsafe fn draft<'r>(&self, place: usize) -> &'r mut DraftOf {
        // SAFETY: `desks` has initialised it.
        unsafe { (*self.drafts.add(place)).assume_init_mut() }
    }
}
