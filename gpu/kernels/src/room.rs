//! The device memory of a filter, and the buffers of all filters of a launch.

use crate::buffer::{Feature, Prediction, Run, Scan, ScanResult, Status};
use crate::kind::{Kind, Particles};
use crate::run::{Filter, Sensing, Sighted};
use crate::slot::{MEASUREMENTS, Slot};
use core::mem::MaybeUninit;
use core::ops::Deref;
use core::ptr::NonNull;
use core::slice::{from_raw_parts, from_raw_parts_mut};
use core::sync::atomic::AtomicU32;
use nalgebra::{Vector2, Vector3};
use scphd::models::PlanarPose;
use scphd::numerics::{LnSum, Noise, Symmetric};
use scphd::storage::{
    COUNTS, Candidate, Draft, Dynamic, Lent, Lists, PART, Page, PageId, Row, Scanning, Static, TERMS, UpdateMemory,
};

/// A memory of filters with particles, as a kind of them.
pub trait Size: Particles + Kind<Room = Room<Self>, Desk = UpdateMemory<Self, 1>> {}

impl<M: Particles + Kind<Room = Room<M>, Desk = UpdateMemory<M, 1>>> Size for M {}

/// A filter and its scan in progress. They stay in memory from launch to launch.
#[derive(Debug)]
pub struct Room<M> {
    pub(crate) slot: Slot<M>,
    pub(crate) filter: MaybeUninit<Filter<'static>>,
    pub(crate) detector: MaybeUninit<Sighted<'static>>,
    pub(crate) between: MaybeUninit<Between>,
    pub(crate) prediction: Predicting,
    /// The greatest |V| of the weighed candidates.
    pub(crate) in_view: AtomicU32,
    /// Sums over the drafts of a scan, as bits of `f32`.
    pub(crate) kept: [AtomicU32; TERMS],
    /// The mean pose after the scan, as bits of `f32`.
    pub(crate) centre: [AtomicU32; 3],
}

/// Number of consecutive candidates for which one position in the random stream is stored.
pub const TOGETHER: usize = 32;

/// The prediction in progress. It starts as zeros.
#[derive(Debug)]
pub(crate) struct Predicting {
    /// Number of predictions since the last scan, including this one.
    pub(crate) taken: u32,
    /// The memory of all candidates while it is lent, and its length; 0 while it is not.
    pub(crate) candidates: (*mut Candidate<PlanarPose<f32>>, usize),
    pub(crate) particles: (*mut Candidate<PlanarPose<f32>>, usize),
    pub(crate) in_use: usize,
    /// Whether each particle is split into several candidates.
    pub(crate) splits: bool,
    /// The random stream after the last candidate.
    pub(crate) after: MaybeUninit<Noise>,
}

/// A slice that is lent, each element to one thread at a time.
#[derive(Debug)]
pub(crate) struct Many<T> {
    first: NonNull<T>,
    len: usize,
}

impl<T> Clone for Many<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Many<T> {}

impl<T> Many<T> {
    /// An empty slice.
    pub(crate) const NONE: Self = Self { first: NonNull::dangling(), len: 0 };

    pub(crate) fn of(things: &'static mut [T]) -> Self {
        Self::lent(things)
    }

    /// A slice that the lender does not use, nor give back, before the last thread has done with it.
    pub(crate) fn lent(things: &mut [T]) -> Self {
        Self { len: things.len(), first: NonNull::from(things).cast() }
    }

    /// A slice that is only read.
    pub(crate) fn read(things: &[T]) -> Self {
        Self { len: things.len(), first: NonNull::from(things).cast() }
    }

    /// Returns the whole slice, for the single thread that takes it back.
    pub(crate) unsafe fn back(self) -> &'static mut [T] {
        // SAFETY: it was lent as such a slice, and no other thread uses any element.
        unsafe { from_raw_parts_mut(self.first.as_ptr(), self.len) }
    }

    /// The whole slice, while no thread writes it.
    pub(crate) unsafe fn all<'r>(self) -> &'r [T] {
        // SAFETY: the caller guarantees it.
        unsafe { from_raw_parts(self.first.as_ptr(), self.len) }
    }

    /// At most `most` elements from `first` on, for the single thread that uses them.
    pub(crate) unsafe fn some<'r>(self, first: usize, most: usize) -> &'r mut [T] {
        let first = first.min(self.len);
        // SAFETY: the range is within the slice; the caller guarantees the rest.
        unsafe { from_raw_parts_mut(self.first.as_ptr().add(first), most.min(self.len - first)) }
    }

    /// Pointer to one element.
    pub(crate) fn at(self, place: usize) -> Option<*mut T> {
        (place < self.len).then(|| self.first.as_ptr().wrapping_add(place))
    }

    /// One element, for the single thread that uses it.
    pub(crate) unsafe fn one<'r>(self, place: usize) -> Option<&'r mut T> {
        // SAFETY: the index is within the slice; the caller guarantees the rest.
        (place < self.len).then(|| unsafe { &mut *self.first.as_ptr().add(place) })
    }
}

/// Slices that the library lends, as slices of which each element is lent to one thread at a time.
macro_rules! lending {
    ($(#[$about:meta])* $name:ident: $of:ident, $lent:ty, [$($generic:tt)*] {
        $($slice:ident: $element:ty),+ $(; $number:ident)?
    }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy)]
        pub(crate) struct $name {
            $(pub(crate) $slice: Many<$element>,)+
            $(pub(crate) $number: usize,)?
        }

        impl $name {
            pub(crate) const NONE: Self = Self { $($slice: Many::NONE,)+ $($number: 0,)? };

            pub(crate) fn of<$($generic)*>(lent: $lent) -> Self {
                Self { $($slice: Many::of(lent.$slice),)+ $($number: lent.$number,)? }
            }

            /// Returns the slices, for the single thread that takes them back.
            pub(crate) unsafe fn back<$($generic)*>(self) -> $lent {
                // SAFETY: the caller guarantees it.
                unsafe { $of { $($slice: self.$slice.back(),)+ $($number: self.$number,)? } }
            }
        }
    };
}

lending! {
    /// The arrays of candidates and particles, while they are lent.
    Lending: Lent, Lent<'static, PlanarPose<f32>>, [] {
        candidates: Candidate<PlanarPose<f32>>,
        ln_likelihoods: f32,
        selected: Candidate<PlanarPose<f32>>,
        survivors: u16,
        pose_covariances: Symmetric<Vector3<f32>>,
        selected_covariances: Symmetric<Vector3<f32>>
    }
}

lending! {
    /// The lists of the pages of one kind of maps, while they are lent.
    Listed: Lists, Lists<'static, F>, [F: scphd::storage::Feature<Position = Vector2<f32>>] {
        ids: PageId, rows: Row<Vector2<f32>>, row_of: u16, references: u16, free: PageId; map_pages
    }
}

/// The state between the launches of one scan.
#[derive(Debug)]
pub(crate) struct Between {
    pub(crate) scanning: Scanning<'static, 'static, Sensing>,
    /// Scratch of the sequential stages.
    pub(crate) eta: &'static mut [LnSum<f32>],
    pub(crate) pages: Many<Page<Static<Vector2<f32>>>>,
    pub(crate) moving_pages: Many<Page<Dynamic<Vector2<f32>>>>,
    pub(crate) lent: Lending,
    /// ln of the divisor that all weights still need.
    pub(crate) rest: f32,
    /// The uniform random number of the resampling; `None` without resampling.
    pub(crate) uniform: Option<f32>,
    /// The last candidate whose weight is not zero.
    pub(crate) last: usize,
    /// Number of drafts with a task.
    pub(crate) drafts: usize,
    /// The first unused label before the drafts were stored.
    pub(crate) first_fresh: u32,
    /// Number of new labels of all drafts.
    pub(crate) labels: u32,
    /// Pages of each kind that no updated map keeps, before the drafts allocate any.
    pub(crate) free: [usize; 2],
    /// Pages of each kind that all drafts allocate.
    pub(crate) wanted: [usize; 2],
    pub(crate) lists: [Listed; 2],
    /// Whether the drafts were stored one after the other because there were too few pages.
    pub(crate) in_turn: bool,
    /// Not zero if the drafts must be stored one after the other.
    pub(crate) crowded: AtomicU32,
    /// Counts over the drafts, the greatest numbers in view of either kind, and the peaks of pages of either kind.
    pub(crate) counts: [AtomicU32; COUNTS + 4],
    /// Sums of columns, as bits of `f32`.
    pub(crate) sums: [AtomicU32; COLUMNS],
}

/// Number of columns of `f32` with one number for each particle, which are summed in order: the terms of the drafts, and the
/// weight.
pub(crate) const COLUMNS: usize = TERMS + 1;
/// Number of columns of integers: the draft of each particle, and for each draft the labels and the pages of all drafts before
/// it.
pub(crate) const WHOLES: usize = 4;
/// Number of pages that one thread counts.
pub(crate) const PAGES_TOGETHER: usize = 256;

/// Number of parts of the pages of static features, and of those of moving features.
pub const fn page_parts<M: Kind>() -> [usize; 2] {
    [M::PAGES.div_ceil(PAGES_TOGETHER), M::MOVING_PAGES.div_ceil(PAGES_TOGETHER)]
}

/// Number of parts of the candidates.
pub const fn parts(candidates: usize) -> usize {
    candidates.div_ceil(PART)
}

/// Words of scratch of a filter with `particles` particles and `samples` samples of each.
pub const fn words<M: Kind>(particles: usize, samples: usize) -> usize {
    let [of_static, of_moving] = page_parts::<M>();
    particles * (samples + COLUMNS + WHOLES) + M::PAGES + M::MOVING_PAGES + of_static + of_moving
}

/// Sums over one part of the candidates or of the drafts, and over all parts before it.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct PartPlace {
    pub(crate) ln: f32,
    pub(crate) squares: f32,
    pub(crate) weight: f32,
    /// Σ ζ of the parts before this one.
    pub(crate) before: f32,
    /// Index of the last candidate with a weight above zero, plus one; 0 if there is none.
    pub(crate) last: u32,
    /// Number of survivors that differ from the preceding one; later, the sum over the parts before this one.
    pub(crate) heads: u32,
    pub(crate) heaviest: u32,
    pub(crate) heaviest_ln_weight: f32,
    /// What the drafts of the part claim; later, the sum over the parts before this one.
    pub(crate) claimed: Claimed,
}

/// What some drafts claim.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Claimed {
    /// Number of new labels.
    pub(crate) labels: u32,
    /// Number of allocated pages of either kind.
    pub(crate) pages: [u32; 2],
    /// Number of pages that the drafts free as their only owners.
    pub(crate) regained: [u32; 2],
}

/// Scratch of the thread that weighs a candidate, or that updates the maps of a survivor.
pub type Sight = [LnSum<f32>; MEASUREMENTS];

/// The update of one survivor's maps.
pub(crate) type DraftOf = Draft<'static, Vector2<f32>>;

/// The buffers of all filters of a launch, in the device's memory. In each buffer, the data of a filter is followed by that of
/// the next, all with capacity for the particles and samples of the largest filter.
#[derive(Debug)]
#[repr(C)]
pub struct Filters<M: Kind> {
    /// The runs, one for each filter.
    pub runs: *const Run,
    /// The scans of all runs.
    pub scans: *const Scan,
    /// The predictions of all runs.
    pub predictions: *const Prediction,
    /// The measurements of all runs.
    pub measurements: *const Vector2<f32>,
    /// The filters, which start as zeros.
    pub rooms: *mut M::Room,
    /// One for each candidate.
    pub sights: *mut Sight,
    /// One for each particle. They start as zeros.
    pub desks: *mut M::Desk,
    /// One for each particle.
    pub drafts: *mut MaybeUninit<Draft<'static, Vector2<f32>>>,
    /// One for each [`TOGETHER`] candidates.
    pub streams: *mut MaybeUninit<Noise>,
    /// One for each [part](parts) of the candidates.
    pub parts: *mut PartPlace,
    /// Scratch, [words](words) for each filter.
    pub words: *mut u32,
    /// The status of every run.
    pub statuses: *mut Status,
    /// A result for each scan.
    pub results: *mut ScanResult,
    /// Memory for the estimated features of all runs.
    pub features: *mut Feature,
    /// Number of filters.
    pub count: u64,
    /// The greatest number of particles of a filter.
    pub particles: u64,
    /// The greatest number of samples of a particle.
    pub samples: u64,
}

impl<M: Kind> Clone for Filters<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: Kind> Copy for Filters<M> {}

/// The data of one filter of a launch: its part of every buffer, and the columns of its scratch.
#[derive(Debug)]
pub struct Group<M: Kind> {
    pub(crate) own: Filters<M>,
    pub(crate) cumulated: *mut f32,
    /// Distance between two columns, in numbers.
    pub(crate) stride: usize,
    pub(crate) columns: *mut f32,
    pub(crate) wholes: *mut u32,
    pub(crate) held: *mut AtomicU32,
    pub(crate) firsts: *mut u32,
}

impl<M: Kind> Deref for Group<M> {
    type Target = Filters<M>;

    fn deref(&self) -> &Filters<M> {
        &self.own
    }
}

/// Number of positions in the random stream that a filter with `candidates` candidates stores.
pub const fn streams(candidates: usize) -> usize {
    candidates.div_ceil(TOGETHER)
}

/// Bytes of one element of each buffer (room, sight, desk, draft, stream, part), and the greatest alignment of all of them.
pub fn bytes<M: Kind>() -> [u64; 7] {
    const fn of<T>() -> [usize; 2] {
        [size_of::<T>(), align_of::<T>()]
    }
    let all = [of::<M::Room>(), of::<Sight>(), of::<M::Desk>(), of::<DraftOf>(), of::<Noise>(), of::<PartPlace>()];
    let alignment = all.iter().fold(1, |most, [_, alignment]| most.max(*alignment));
    let [room, sight, desk, draft, stream, part] = all.map(|[size, _]| size);
    [room, sight, desk, draft, stream, part, alignment].map(|x| x as u64)
}
