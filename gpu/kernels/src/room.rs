//! The device memory of a filter, and where that of all filters of a launch lies.

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

/// A filter and the scan that it is taking in, as they stay from launch to launch.
#[derive(Debug)]
pub struct Room<M> {
    pub(crate) slot: Slot<M>,
    pub(crate) filter: MaybeUninit<Filter<'static>>,
    pub(crate) detector: MaybeUninit<Sighted<'static>>,
    pub(crate) between: MaybeUninit<Between>,
    pub(crate) prediction: Predicting,
    /// The greatest |V| of the candidates that have been weighed.
    pub(crate) in_view: AtomicU32,
    /// What is summed over the drafts of a scan, as bits.
    pub(crate) kept: [AtomicU32; TERMS],
    /// The mean pose after it, as bits.
    pub(crate) centre: [AtomicU32; 3],
}

/// Candidates that start from one place of the random stream.
pub const TOGETHER: usize = 32;

/// The prediction that is being taken in. It begins as zeros.
#[derive(Debug)]
pub(crate) struct Predicting {
    /// How many have been since the last scan, this one included.
    pub(crate) taken: u32,
    /// The memory of all candidates, while that is lent, and how many of them are to move.
    pub(crate) candidates: (*mut Candidate<PlanarPose<f32>>, usize),
    pub(crate) particles: (*mut Candidate<PlanarPose<f32>>, usize),
    pub(crate) in_use: usize,
    /// Whether every particle is split into candidates.
    pub(crate) splits: bool,
    /// The random stream behind the last of them.
    pub(crate) after: MaybeUninit<Noise>,
}

/// Things that are lent out, each to one thread at a time.
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
    /// None.
    pub(crate) const NONE: Self = Self { first: NonNull::dangling(), len: 0 };

    /// These.
    pub(crate) fn of(things: &'static mut [T]) -> Self {
        Self { len: things.len(), first: NonNull::from(things).cast() }
    }

    /// All of them, for the one thread that has them back.
    pub(crate) unsafe fn back(self) -> &'static mut [T] {
        // SAFETY: they came as such a slice, and nobody else has any of them.
        unsafe { from_raw_parts_mut(self.first.as_ptr(), self.len) }
    }

    /// All of them, while nobody writes any.
    pub(crate) unsafe fn all<'r>(self) -> &'r [T] {
        // SAFETY: the caller's word.
        unsafe { from_raw_parts(self.first.as_ptr(), self.len) }
    }

    /// Some of them, for the one thread that has these.
    pub(crate) unsafe fn some<'r>(self, first: usize, most: usize) -> &'r mut [T] {
        let first = first.min(self.len);
        // SAFETY: there are as many; the rest is the caller's word.
        unsafe { from_raw_parts_mut(self.first.as_ptr().add(first), most.min(self.len - first)) }
    }

    /// Where one of them is.
    pub(crate) fn at(self, place: usize) -> Option<*mut T> {
        (place < self.len).then(|| self.first.as_ptr().wrapping_add(place))
    }

    /// One of them, for the one thread that has this.
    pub(crate) unsafe fn one<'r>(self, place: usize) -> Option<&'r mut T> {
        // SAFETY: there is such a one; the rest is the caller's word.
        (place < self.len).then(|| unsafe { &mut *self.first.as_ptr().add(place) })
    }
}

/// What there is of candidates and particles, while it is lent out.
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

    /// For the one thread that has it back.
    pub(crate) unsafe fn back(self) -> Lent<'static, PlanarPose<f32>> {
        // SAFETY: the caller's word.
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

/// The lists of the pages of one kind of maps, while they are lent out.
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

    /// For the one thread that has them back.
    pub(crate) unsafe fn back<F: scphd::storage::Feature<Position = Vector2<f32>>>(self) -> Lists<'static, F> {
        // SAFETY: the caller's word.
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

/// What there is between the launches of one scan.
#[derive(Debug)]
pub(crate) struct Between {
    pub(crate) scanning: Scanning<'static, 'static, Models>,
    /// Scratch of the sequential stages.
    pub(crate) eta: &'static mut [LnSum<f32>],
    pub(crate) pages: Many<Page<Static<Vector2<f32>>>>,
    pub(crate) moving_pages: Many<Page<Dynamic<Vector2<f32>>>>,
    pub(crate) lent: Lending,
    /// What all weights are still to be divided by, in the log domain.
    pub(crate) rest: f32,
    /// The number that all particles are drawn with, if they are drawn anew.
    pub(crate) uniform: Option<f32>,
    /// The last candidate that weighs anything.
    pub(crate) last: usize,
    /// Drafts with a task.
    pub(crate) drafts: usize,
    /// The first label that was fresh for all drafts.
    pub(crate) first_fresh: u32,
    /// Fresh labels of all drafts.
    pub(crate) labels: u32,
    /// Free pages of either kind once the drafts are stored, and before they take any.
    pub(crate) free: [usize; 2],
    /// Pages of either kind that all drafts take.
    pub(crate) wanted: [usize; 2],
    pub(crate) lists: [Listed; 2],
    /// Whether the drafts have been stored one after the other, for want of pages.
    pub(crate) in_turn: bool,
    /// Not zero where they have to be.
    pub(crate) crowded: AtomicU32,
    /// What the drafts count, and the most in view of either kind, and the most pages.
    pub(crate) counts: [AtomicU32; COUNTS + 4],
    /// Sums of columns, as bits.
    pub(crate) sums: [AtomicU32; COLUMNS],
}

/// Columns of numbers, one a particle, that are summed in order: what drafts sum up, and the weight.
pub(crate) const COLUMNS: usize = TERMS + 1;
/// Columns of whole numbers: of a particle its draft, and of a draft the labels and pages of those before.
pub(crate) const WHOLES: usize = 4;
/// Pages that one thread counts.
pub(crate) const PAGES_TOGETHER: usize = 256;

/// Parts of so many pages of both kinds: static ones first.
pub const fn page_parts<M: Size>() -> [usize; 2] {
    [M::PAGES.div_ceil(PAGES_TOGETHER), M::MOVING_PAGES.div_ceil(PAGES_TOGETHER)]
}

/// Parts of so many candidates.
#[must_use]
pub const fn parts(candidates: usize) -> usize {
    candidates.div_ceil(PART)
}

/// Words of scratch of a filter of so many particles and samples.
#[must_use]
pub const fn words<M: Size>(particles: usize, samples: usize) -> usize {
    let [of_static, of_moving] = page_parts::<M>();
    particles * (samples + COLUMNS + WHOLES) + M::PAGES + M::MOVING_PAGES + of_static + of_moving
}

/// Sums of some candidates, or of some drafts, and what those before come to.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct PartPlace {
    pub(crate) ln: f32,
    pub(crate) squares: f32,
    pub(crate) weight: f32,
    /// Σ ζ of the parts before.
    pub(crate) before: f32,
    /// One more than the place of the last that weighs anything; 0 where none does.
    pub(crate) last: u32,
    /// Survivors that differ from the one before; afterwards those of the parts before.
    pub(crate) heads: u32,
    pub(crate) heaviest: u32,
    pub(crate) heaviest_ln_weight: f32,
    /// Fresh labels; afterwards those of the parts before.
    pub(crate) labels: u32,
    /// Pages of either kind; afterwards likewise.
    pub(crate) pages: [u32; 2],
    /// Of these, those that the drafts give back as their only holders; afterwards likewise.
    pub(crate) regained: [u32; 2],
}

/// Scratch of the thread that weighs a candidate, or updates the map of a survivor.
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

/// A place for that.
#[derive(Debug)]
pub struct DraftPlace {
    pub(crate) draft: MaybeUninit<DraftOf>,
}

/// The random stream as it is for the first of every so many candidates.
#[derive(Debug)]
pub struct StreamPlace {
    pub(crate) stream: MaybeUninit<Noise>,
}

/// The buffers of all filters of a launch, in the memory of whoever runs its kernels. What there is of a filter lies beside that of the next,
/// with room for as many particles and samples as the largest has.
#[derive(Debug)]
#[repr(C)]
pub struct Filters<M: Size> {
    /// The runs, one a filter.
    pub runs: *const Run,
    /// The scans of all runs.
    pub scans: *const Scan,
    /// The predictions of all runs.
    pub predictions: *const Prediction,
    /// The measurements of all runs.
    pub measurements: *const Vector2<f32>,
    /// The filters, which begin as zeros.
    pub rooms: *mut Room<M>,
    /// One for every candidate.
    pub sights: *mut Sight,
    /// One for every particle, which begins as zeros.
    pub desks: *mut Desk<M>,
    /// One for every particle.
    pub drafts: *mut DraftPlace,
    /// One for every [so many](TOGETHER) candidates.
    pub streams: *mut StreamPlace,
    /// One for every [part](parts) of the candidates.
    pub parts: *mut PartPlace,
    /// So many [words](words).
    pub words: *mut u32,
    /// How every run stands.
    pub statuses: *mut Status,
    /// A result for every scan.
    pub results: *mut ScanResult,
    /// Room for the estimated features of all runs.
    pub features: *mut Feature,
    /// Room for the estimated moving features of all runs.
    pub movers: *mut Mover,
    /// Number of filters.
    pub count: u64,
    /// The most particles of a filter.
    pub particles: u64,
    /// The most samples of a particle.
    pub samples: u64,
}

impl<M: Size> Clone for Filters<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: Size> Copy for Filters<M> {}

/// What belongs to one filter of a launch.
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
    /// So many places from one column to the next.
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

/// Places of the random stream that a filter of so many candidates keeps.
#[must_use]
pub const fn streams(candidates: usize) -> usize {
    candidates.div_ceil(TOGETHER)
}

/// Bytes of what the buffers of filters are made of, room, sight, desk, draft, stream and part, and what all of them are aligned to at most.
#[must_use]
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
