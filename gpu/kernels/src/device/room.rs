//! The device memory of a filter.

use crate::launches::COLUMNS;
use crate::memory::{MEASUREMENTS, Particles, Slot};
use crate::setup::{Filter, Sensing, Sighted};
use core::mem::MaybeUninit;
use core::ops::Range;
use core::ptr::NonNull;
use core::slice::{from_raw_parts, from_raw_parts_mut};
use core::sync::atomic::AtomicU32;
use nalgebra::{Vector2, Vector3};
use scphd::models::PlanarPose;
use scphd::numerics::{LnSum, Noise, Symmetric};
use scphd::storage::{
    COUNTS, Candidate, Draft, Dynamic, Feature, Lent, Lists, Page, PageId, Row, Scanning, Static, UpdateMemory,
};

/// A kind of filters.
pub(super) trait Kind: Sized + 'static {
    /// Numbers of pages of static features and of moving ones.
    const PAGES: [usize; 2];
    /// The number of all pages.
    const ALL_PAGES: usize = Self::PAGES[0] + Self::PAGES[1];
    /// The memory of a filter, which starts as zeros.
    type Room;
    /// The memory for the update of one survivor's maps, which starts as zeros.
    type Desk;
}

impl<M: Particles> Kind for M {
    const PAGES: [usize; 2] = <M as Particles>::PAGES;
    type Room = Room<M>;
    type Desk = UpdateMemory<M, 1>;
}

/// A filter and its scan in progress. They stay in memory from launch to launch.
pub(super) struct Room<M> {
    pub(super) slot: Slot<M>,
    pub(super) filter: MaybeUninit<Filter<'static>>,
    pub(super) detector: MaybeUninit<Sighted<'static>>,
    pub(super) between: MaybeUninit<Between>,
    pub(super) prediction: Predicting,
    /// The greatest |V| of the weighed candidates.
    pub(super) in_view: AtomicU32,
}

/// All candidates and particles, and the covariances of the latter.
pub(super) struct Predicted {
    pub(super) candidates: Many<Candidate<PlanarPose<f32>>>,
    pub(super) particles: Many<Candidate<PlanarPose<f32>>>,
    pub(super) covariances: Many<Symmetric<Vector3<f32>>>,
    /// The random stream at the numbers of the first candidate, and behind the last.
    pub(super) noise: [Noise; 2],
}

/// The prediction in progress. It starts as zeros.
pub(super) struct Predicting {
    /// Number of predictions since the last scan, including this one.
    pub(super) taken: u32,
    /// All candidates and particles, while they are lent.
    pub(super) lent: Option<Predicted>,
    pub(super) in_use: usize,
    /// Whether each particle is split into several candidates.
    pub(super) splits: bool,
}

/// A slice that is lent, each element to one thread at a time.
pub(super) struct Many<T> {
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
    pub(super) const NONE: Self = Self { first: NonNull::dangling(), len: 0 };

    /// A slice that the lender does not use, nor give back, before the last thread has done with it.
    pub(super) fn lent(things: impl Into<NonNull<[T]>>) -> Self {
        let things = things.into();
        Self { first: things.cast(), len: things.len() }
    }

    /// Returns the whole slice, for the single thread that takes it back.
    pub(super) unsafe fn back(self) -> &'static mut [T] {
        from_raw_parts_mut(self.first.as_ptr(), self.len)
    }

    /// The whole slice, while no thread writes it.
    pub(super) unsafe fn all<'r>(self) -> &'r [T] {
        from_raw_parts(self.first.as_ptr(), self.len)
    }

    /// The elements of a range, as far as there are any, for the single thread that uses them.
    pub(super) unsafe fn some<'r>(self, range: Range<usize>) -> &'r mut [T] {
        let first = range.start.min(self.len);
        from_raw_parts_mut(self.first.as_ptr().add(first), range.end.min(self.len).saturating_sub(first))
    }

    /// Pointer to one element.
    pub(super) fn at(self, place: usize) -> Option<*mut T> {
        (place < self.len).then(|| self.first.as_ptr().wrapping_add(place))
    }

    /// One element, for the single thread that uses it.
    pub(super) unsafe fn one<'r>(self, place: usize) -> Option<&'r mut T> {
        (place < self.len).then(|| &mut *self.first.as_ptr().add(place))
    }
}

/// Slices that the library lends, as slices of which each element is lent to one thread at a time.
macro_rules! lending {
    ($(#[$about:meta])* $name:ident: $of:ident, $lent:ty, [$($generic:tt)*] {
        $($slice:ident: $element:ty),+ $(; $number:ident)?
    }) => {
        $(#[$about])*
        #[derive(Clone, Copy)]
        pub(super) struct $name {
            $(pub(super) $slice: Many<$element>,)+
            $(pub(super) $number: usize,)?
        }

        impl $name {
            pub(super) const NONE: Self = Self { $($slice: Many::NONE,)+ $($number: 0,)? };

            pub(super) fn of<$($generic)*>(lent: $lent) -> Self {
                Self { $($slice: Many::lent(lent.$slice),)+ $($number: lent.$number,)? }
            }

            /// Returns the slices, for the single thread that takes them back.
            pub(super) unsafe fn back<$($generic)*>(self) -> $lent {
                $of { $($slice: self.$slice.back(),)+ $($number: self.$number,)? }
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
    Listed: Lists, Lists<'static, F>, [F: Feature<Position = Vector2<f32>>] {
        ids: PageId, rows: Row<Vector2<f32>>, row_of: u16, references: u16, free: PageId; map_pages
    }
}

/// The state between the launches of one scan.
pub(super) struct Between {
    pub(super) scanning: Scanning<'static, 'static, Sensing>,
    /// Scratch of the sequential stages.
    pub(super) eta: &'static mut [LnSum<f32>],
    pub(super) pages: Many<Page<Static<Vector2<f32>>>>,
    pub(super) moving_pages: Many<Page<Dynamic<Vector2<f32>>>>,
    pub(super) lent: Lending,
    /// Number of random numbers that the candidates of each particle take in an informed proposal; 0 if the prediction has sampled them.
    pub(super) numbers: usize,
    /// The random stream at the numbers of the first particle, for the proposal and for a selection without resampling.
    pub(super) noise: Option<Noise>,
    /// Number of particles whose proposal had too little memory.
    pub(super) short: AtomicU32,
    /// ln of the divisor that all weights still need.
    pub(super) rest: f32,
    /// The uniform random number of the resampling; `None` without resampling.
    pub(super) uniform: Option<f32>,
    /// The last candidate whose weight is not zero.
    pub(super) last: usize,
    /// Number of drafts.
    pub(super) drafts: usize,
    /// The first unused label before the drafts were stored.
    pub(super) first_fresh: u32,
    /// Number of new labels of all drafts.
    pub(super) labels: u32,
    /// Pages of each kind that no updated map keeps, before the drafts allocate any.
    pub(super) free: [usize; 2],
    /// Pages of each kind that all drafts allocate.
    pub(super) wanted: [usize; 2],
    pub(super) lists: [Listed; 2],
    /// Whether the drafts were stored one after the other because there were too few pages.
    pub(super) in_turn: bool,
    /// Not zero if the drafts must be stored one after the other.
    pub(super) crowded: AtomicU32,
    /// Counts over the drafts, the greatest numbers in view of either kind, and the peaks of pages of either kind.
    pub(super) counts: [AtomicU32; COUNTS + 4],
    /// Sums of columns, as bits of `f32`.
    pub(super) sums: [AtomicU32; COLUMNS],
}

/// Number of columns of integers: the draft of each particle, and for each draft the labels and the pages of all drafts before
/// it.
pub(super) const WHOLES: usize = 4;
/// Sums over one part of the candidates or of the drafts, and over all parts before it.
pub(super) struct PartPlace {
    pub(super) ln: f32,
    pub(super) squares: f32,
    pub(super) weight: f32,
    /// Σ ζ of the parts before this one.
    pub(super) before: f32,
    /// Index of the last candidate with a weight above zero, plus one; 0 if there is none.
    pub(super) last: u32,
    /// Number of survivors that differ from the preceding one; later, the sum over the parts before this one.
    pub(super) heads: u32,
    pub(super) heaviest: u32,
    pub(super) heaviest_ln_weight: f32,
    /// What the drafts of the part claim; later, the sum over the parts before this one.
    pub(super) claimed: Claimed,
}

/// What some drafts claim.
#[derive(Clone, Copy, Default)]
pub(super) struct Claimed {
    /// Number of new labels.
    pub(super) labels: u32,
    /// Number of allocated pages of either kind.
    pub(super) pages: [u32; 2],
    /// Number of pages that the drafts free as their only owners.
    pub(super) regained: [u32; 2],
}

/// Scratch of the thread that weighs a candidate, or that updates the maps of a survivor.
pub(super) type Sight = [LnSum<f32>; MEASUREMENTS];

/// The update of one survivor's maps.
pub(super) type DraftOf = Draft<'static, Vector2<f32>>;

/// Gives the lent pages back. Safety: nothing else refers to them any more.
pub(super) unsafe fn give_pages_back(between: &mut Between) {
    let Between { scanning, pages, moving_pages, .. } = between;
    scanning.give_pages_back((pages.back(), moving_pages.back()));
}
