//! The device memory of a filter, and the buffers of all filters of a launch.

use crate::buffer::{Feature, Mover, Prediction, Run, Scan, ScanResult, Status};
use crate::run::{Filter, Sighted};
use crate::setup::Models;
use crate::size::Size;
use crate::slot::{MEASUREMENTS, Slot};
use core::mem::MaybeUninit;
use core::ptr::NonNull;
use core::slice::{from_raw_parts, from_raw_parts_mut};
use core::sync::atomic::AtomicU32;
use nalgebra::{Vector2, Vector3};
use scphd::models::PlanarPose;
use scphd::numerics::{LnSum, Noise, Symmetric};
use scphd::storage::{
    COUNTS, Candidate, Draft, Dynamic, Lent, Lists, PART, Page, PageId, Row, Scanning, Static, TERMS, UpdateMemory,
};

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

/// The arrays of candidates and particles, while they are lent.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lending {
    pub(crate) candidates: Many<Candidate<PlanarPose<f32>>>,
    pub(crate) ln_likelihoods: Many<f32>,
    pub(crate) selected: Many<Candidate<PlanarPose<f32>>>,
    pub(crate) survivors: Many<u16>,
    pub(crate) pose_covariances: Many<Symmetric<Vector3<f32>>>,
    pub(crate) selected_covariances: Many<Symmetric<Vector3<f32>>>,
}

impl Lending {
    pub(crate) const NONE: Self = Self {
        candidates: Many::NONE,
        ln_likelihoods: Many::NONE,
        selected: Many::NONE,
        survivors: Many::NONE,
        pose_covariances: Many::NONE,
        selected_covariances: Many::NONE,
    };

    pub(crate) fn of(lent: Lent<'static, PlanarPose<f32>>) -> Self {
        Self {
            candidates: Many::of(lent.candidates),
            ln_likelihoods: Many::of(lent.ln_likelihoods),
            selected: Many::of(lent.selected),
            survivors: Many::of(lent.survivors),
            pose_covariances: Many::of(lent.pose_covariances),
            selected_covariances: Many::of(lent.selected_covariances),
        }
    }

    /// Returns the arrays, for the single thread that takes them back.
    pub(crate) unsafe fn back(self) -> Lent<'static, PlanarPose<f32>> {
        // SAFETY: the caller guarantees it.
        unsafe {
            Lent {
                candidates: self.candidates.back(),
                ln_likelihoods: self.ln_likelihoods.back(),
                selected: self.selected.back(),
                survivors: self.survivors.back(),
                pose_covariances: self.pose_covariances.back(),
                selected_covariances: self.selected_covariances.back(),
            }
        }
    }
}

/// The lists of the pages of one kind of maps, while they are lent.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Listed {
    pub(crate) ids: Many<PageId>,
    pub(crate) rows: Many<Row<Vector2<f32>>>,
    pub(crate) row_of: Many<u16>,
    pub(crate) references: Many<u16>,
    pub(crate) free: Many<PageId>,
    pub(crate) map_pages: usize,
}

impl Listed {
    pub(crate) const NONE: Self = Self {
        ids: Many::NONE,
        rows: Many::NONE,
        row_of: Many::NONE,
        references: Many::NONE,
        free: Many::NONE,
        map_pages: 0,
    };

    pub(crate) fn of<F: scphd::storage::Feature<Position = Vector2<f32>>>(lists: Lists<'static, F>) -> Self {
        Self {
            ids: Many::of(lists.ids),
            rows: Many::of(lists.rows),
            row_of: Many::of(lists.row_of),
            references: Many::of(lists.references),
            free: Many::of(lists.free),
            map_pages: lists.map_pages,
        }
    }

    /// Returns the lists, for the single thread that takes them back.
    pub(crate) unsafe fn back<F: scphd::storage::Feature<Position = Vector2<f32>>>(self) -> Lists<'static, F> {
        // SAFETY: the caller guarantees it.
        unsafe {
            Lists {
                ids: self.ids.back(),
                rows: self.rows.back(),
                row_of: self.row_of.back(),
                references: self.references.back(),
                free: self.free.back(),
                map_pages: self.map_pages,
            }
        }
    }
}

/// The state between the launches of one scan.
#[derive(Debug)]
pub(crate) struct Between {
    pub(crate) scanning: Scanning<'static, 'static, Models>,
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
pub const fn page_parts<M: Size>() -> [usize; 2] {
    [M::PAGES.div_ceil(PAGES_TOGETHER), M::MOVING_PAGES.div_ceil(PAGES_TOGETHER)]
}

/// Number of parts of the candidates.
pub const fn parts(candidates: usize) -> usize {
    candidates.div_ceil(PART)
}

/// Words of scratch of a filter with `particles` particles and `samples` samples of each.
pub const fn words<M: Size>(particles: usize, samples: usize) -> usize {
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
    /// Number of new labels; later, the sum over the parts before this one.
    pub(crate) labels: u32,
    /// Number of allocated pages of either kind; later, the sum over the parts before this one.
    pub(crate) pages: [u32; 2],
    /// Number of pages that the drafts free as their only owners; later, the sum over the parts before this one.
    pub(crate) regained: [u32; 2],
}

/// Scratch of the thread that weighs a candidate, or that updates the maps of a survivor.
#[derive(Debug)]
pub struct Sight {
    pub(crate) eta: [LnSum<f32>; MEASUREMENTS],
}

/// Memory for the update of one survivor's maps.
#[derive(Debug)]
pub struct Desk<M: Size> {
    pub(crate) memory: UpdateMemory<M, 1>,
}

/// The update of one survivor's maps.
pub(crate) type DraftOf = Draft<'static, Vector2<f32>>;

/// An element of the buffer of drafts.
#[derive(Debug)]
pub struct DraftPlace {
    pub(crate) draft: MaybeUninit<DraftOf>,
}

/// The state of the random stream at the first of [`TOGETHER`] candidates.
#[derive(Debug)]
pub struct StreamPlace {
    pub(crate) stream: MaybeUninit<Noise>,
}

/// The buffers of all filters of a launch, in the device's memory. In each buffer, the data of a filter is followed by that of
/// the next, all with capacity for the particles and samples of the largest filter.
#[derive(Debug)]
#[repr(C)]
pub struct Filters<M: Size> {
    /// The runs, one for each filter.
    pub runs: *const Run,
    /// The scans of all runs.
    pub scans: *const Scan,
    /// The predictions of all runs.
    pub predictions: *const Prediction,
    /// The measurements of all runs.
    pub measurements: *const Vector2<f32>,
    /// The filters, which start as zeros.
    pub rooms: *mut Room<M>,
    /// One for each candidate.
    pub sights: *mut Sight,
    /// One for each particle. They start as zeros.
    pub desks: *mut Desk<M>,
    /// One for each particle.
    pub drafts: *mut DraftPlace,
    /// One for each [`TOGETHER`] candidates.
    pub streams: *mut StreamPlace,
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
    /// Memory for the estimated moving features of all runs.
    pub movers: *mut Mover,
    /// Number of filters.
    pub count: u64,
    /// The greatest number of particles of a filter.
    pub particles: u64,
    /// The greatest number of samples of a particle.
    pub samples: u64,
}

impl<M: Size> Clone for Filters<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: Size> Copy for Filters<M> {}

/// The data of one filter of a launch.
#[derive(Debug)]
pub struct Group<M: Size> {
    pub(crate) run: *const Run,
    pub(crate) scans: *const Scan,
    pub(crate) predictions: *const Prediction,
    pub(crate) measurements: *const Vector2<f32>,
    pub(crate) room: *mut Room<M>,
    pub(crate) sights: *mut Sight,
    pub(crate) desks: *mut Desk<M>,
    pub(crate) drafts: *mut DraftPlace,
    pub(crate) streams: *mut StreamPlace,
    pub(crate) parts: *mut PartPlace,
    pub(crate) cumulated: *mut f32,
    /// Distance between two columns, in numbers.
    pub(crate) stride: usize,
    pub(crate) columns: *mut f32,
    pub(crate) wholes: *mut u32,
    pub(crate) held: *mut AtomicU32,
    pub(crate) firsts: *mut u32,
    pub(crate) status: *mut Status,
    pub(crate) results: *mut ScanResult,
    pub(crate) features: *mut Feature,
    pub(crate) movers: *mut Mover,
}

/// Number of positions in the random stream that a filter with `candidates` candidates stores.
pub const fn streams(candidates: usize) -> usize {
    candidates.div_ceil(TOGETHER)
}

/// Bytes of one element of each buffer (room, sight, desk, draft, stream, part), and the greatest alignment of all of them.
pub fn bytes<M: Size>() -> [u64; 7] {
    let alignments = [
        align_of::<Room<M>>(),
        align_of::<Sight>(),
        align_of::<Desk<M>>(),
        align_of::<DraftPlace>(),
        align_of::<StreamPlace>(),
        align_of::<PartPlace>(),
    ];
    let alignment = alignments.into_iter().fold(1, usize::max);
    let sizes = [
        size_of::<Room<M>>(),
        size_of::<Sight>(),
        size_of::<Desk<M>>(),
        size_of::<DraftPlace>(),
        size_of::<StreamPlace>(),
        size_of::<PartPlace>(),
    ];
    let [room, sight, desk, draft, stream, part] = sizes;
    [room, sight, desk, draft, stream, part, alignment].map(|x| x as u64)
}
