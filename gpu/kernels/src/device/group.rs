//! The data of one filter of a launch, and what every stage needs first: whether its filter continues, and the state between the
//! launches of a scan.

use super::room::{Between, DraftOf, Kind, PartPlace, Sight, WHOLES};
use crate::buffer::{Feature, Layout, Prediction, Run, Scan, ScanResult, Status};
use crate::launches::{COLUMNS, page_parts};
use crate::memory::Particles;
use core::mem::MaybeUninit;
use core::ops::{Deref, Range};
use core::slice::{from_raw_parts, from_raw_parts_mut};
use core::sync::atomic::AtomicU32;
use nalgebra::Vector2;
use scphd::storage::PART;

/// The data of one filter in the buffers, with capacity for the particles and samples of the largest filter. The host writes it, in
/// the order of [`Layout::buffers`].
#[repr(C)]
pub(super) struct Buffers<M: Kind> {
    pub(super) run: *const Run,
    scans: *const Scan,
    predictions: *const Prediction,
    measurements: *const Vector2<f32>,
    /// The filter, which starts as zeros.
    pub(super) room: *mut M::Room,
    /// One for each candidate.
    pub(super) sights: *mut Sight,
    /// One for each particle. They start as zeros.
    pub(super) desks: *mut M::Desk,
    /// One for each particle.
    pub(super) drafts: *mut MaybeUninit<DraftOf>,
    /// One for each part of the candidates.
    pub(super) parts: *mut PartPlace,
    /// One for each candidate.
    pub(super) cumulated: *mut f32,
    /// Columns with one number for each particle.
    pub(super) columns: *mut f32,
    pub(super) wholes: *mut u32,
    /// One for each page, and for each part of them.
    pub(super) held: *mut AtomicU32,
    pub(super) firsts: *mut u32,
    pub(super) status: *mut Status,
    /// One for each scan.
    pub(super) results: *mut ScanResult,
    pub(super) features: *mut Feature,
    /// Distance between two columns, in numbers.
    pub(super) stride: usize,
}

/// The data of one filter in a launch for a scan.
pub(super) struct Group<'g, M: Kind> {
    pub(super) own: &'g Buffers<M>,
    pub(super) scan: u32,
    /// Number of scans between two digests; 0 for one after the last scan only.
    pub(super) digest_every: u32,
}

impl<M: Kind> Deref for Group<'_, M> {
    type Target = Buffers<M>;

    fn deref(&self) -> &Buffers<M> {
        self.own
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

/// The memory of a filter with `particles` particles and `samples` samples of each.
pub(super) fn layout<M: Kind>(particles: usize, samples: usize) -> Layout {
    const fn of<T>(count: usize) -> u64 {
        const { assert!(align_of::<T>() <= 256, "devices allocate memory with this alignment") };
        (size_of::<T>() * count) as u64
    }
    let candidates = particles * samples;
    let [of_static, of_moving] = page_parts(M::PAGES);
    let buffers = [
        of::<M::Room>(1),
        of::<Sight>(candidates),
        of::<M::Desk>(particles),
        of::<DraftOf>(particles),
        of::<PartPlace>(candidates.div_ceil(PART)),
        of::<f32>(candidates),
        of::<f32>(COLUMNS * particles),
        of::<u32>(WHOLES * particles),
        of::<AtomicU32>(M::ALL_PAGES),
        of::<u32>(of_static + of_moving),
    ];
    Layout { buffers }
}

impl<M: Kind> Group<'_, M> {
    /// Whether the run has not stopped and has this scan. Safety: only launches of one thread write the status.
    pub(super) unsafe fn goes_on(&self) -> bool {
        (*self.status).code == Status::DONE && self.scan < (*self.run).scans
    }

    /// Whether the run needs a digest after this scan. Safety: as of `goes_on`.
    pub(super) unsafe fn asks_for_digest(&self) -> bool {
        let taken = self.scan.saturating_add(1);
        self.goes_on() && (taken.checked_rem(self.digest_every) == Some(0) || taken == (*self.run).scans)
    }

    /// The predictions before the scan. Safety: the run has this scan; inputs are never written.
    pub(super) unsafe fn predictions<'r>(&self) -> &'r [Prediction] {
        let scan = &*self.scans.add(whole(self.scan));
        from_raw_parts(self.predictions.add(whole(scan.first_prediction)), whole(scan.predictions))
    }

    /// The measurements of the scan. Safety: as of `predictions`.
    pub(super) unsafe fn measurements<'r>(&self) -> &'r [Vector2<f32>] {
        let scan = &*self.scans.add(whole(self.scan));
        from_raw_parts(self.measurements.add(whole(scan.first_measurement)), whole(scan.measurements))
    }
}

impl<M: Particles> Group<'_, M> {
    /// The state between the launches of a scan; `None` if the run has stopped. Safety: `open` has initialised it, or has stopped the
    /// run.
    pub(super) unsafe fn between<'r>(&self) -> Option<&'r Between> {
        self.goes_on().then(|| (*self.room).between.assume_init_ref())
    }

    /// The same state, mutable, for the only thread of a launch. Safety: as of `between`.
    pub(super) unsafe fn alone<'r>(&self) -> Option<&'r mut Between> {
        self.goes_on().then(|| (*self.room).between.assume_init_mut())
    }

    /// The parts of `things` elements, for one thread. Safety: the buffer has this number of parts.
    pub(super) unsafe fn all_parts<'r>(&self, things: usize) -> &'r mut [PartPlace] {
        from_raw_parts_mut(self.parts, things.div_ceil(PART))
    }

    /// The first `count` drafts, for one thread. Safety: `furnish` has initialised one for each particle.
    pub(super) unsafe fn all_drafts<'r>(&self, count: usize) -> &'r mut [DraftOf] {
        from_raw_parts_mut(self.drafts.cast(), count)
    }

    /// The draft at this place, for its thread. Safety: `furnish` has initialised it.
    pub(super) unsafe fn draft<'r>(&self, place: usize) -> &'r mut DraftOf {
        (*self.drafts.add(place)).assume_init_mut()
    }
}
