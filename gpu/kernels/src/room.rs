//! The device memory of one large filter.

use crate::buffer::{Feature, Mover, Prediction, Run, Scan, ScanResult, Status};
use crate::run::{Filter, Sighted};
use crate::setup::Models;
use crate::slot::{MEASUREMENTS, SAMPLES, SlotOf};
use core::mem::MaybeUninit;
use core::sync::atomic::AtomicU32;
use nalgebra::Vector2;
use scphd::memory;
use scphd::models::{PlanarPose, Unicycle};
use scphd::numerics::{LnSum, Noise};
use scphd::storage::{Candidate, Draft, Dynamic, Page, Scanning, Static, UpdateMemory};

/// Room for particles of a large filter.
pub const LARGE_PARTICLES: usize = 16_384;
/// Pages of moving features of all its maps, and as many of static ones: the most that can be counted.
pub const LARGE_PAGES: usize = 65_535;

memory! {
    /// What a large filter knows: maps as large as those of a slot.
    pub type LargeMemory: Unicycle<f32> {
        particles: LARGE_PARTICLES, samples: 2,
        features { pages: LARGE_PAGES, pages_per_map: 64, in_view: 768 },
        moving { pages: LARGE_PAGES, pages_per_map: 48, in_view: 384 },
    }
}

/// All that a large filter knows, with the scratch of its sensor and room for estimates.
pub type LargeSlot = SlotOf<LargeMemory>;

/// A filter and the scan that it is taking in, as they stay from launch to launch.
#[derive(Debug)]
pub struct Room {
    pub(crate) slot: LargeSlot,
    pub(crate) filter: MaybeUninit<Filter<'static>>,
    pub(crate) detector: MaybeUninit<Sighted<'static>>,
    pub(crate) between: MaybeUninit<Between>,
    pub(crate) prediction: Predicting,
    /// The greatest |V| of the candidates that have been weighed.
    pub(crate) in_view: AtomicU32,
}

/// Candidates that start from one place of the random stream.
pub(crate) const TOGETHER: usize = 32;

/// The prediction that is being taken in. It begins as zeros.
#[derive(Debug)]
pub(crate) struct Predicting {
    /// How many have been since the last scan, this one included.
    pub(crate) taken: u32,
    /// The memory of all candidates, while that is lent, and how many of them are to move.
    pub(crate) candidates: (*mut Candidate<PlanarPose<f32>>, usize),
    pub(crate) in_use: usize,
    /// The random stream as it is for the first of every so many candidates.
    pub(crate) streams: [MaybeUninit<Noise>; (LARGE_PARTICLES * SAMPLES).div_ceil(TOGETHER)],
    /// The same behind the last one.
    pub(crate) after: MaybeUninit<Noise>,
}

/// What there is between the launches of one scan.
#[derive(Debug)]
pub(crate) struct Between {
    pub(crate) scanning: Scanning<'static, 'static, Models>,
    /// Scratch of the sequential stages.
    pub(crate) eta: &'static mut [LnSum<f32>],
    /// What is lent out, a place to a thread: where it begins, and how many places there are.
    pub(crate) ln_likelihoods: (*mut f32, usize),
    pub(crate) pages: (*mut Page<Static<Vector2<f32>>>, usize),
    pub(crate) moving_pages: (*mut Page<Dynamic<Vector2<f32>>>, usize),
    /// Drafts with a task.
    pub(crate) drafts: usize,
}

/// Scratch of the thread that weighs a candidate, or updates the map of a survivor.
#[derive(Debug)]
pub struct Sight {
    pub(crate) eta: [LnSum<f32>; MEASUREMENTS],
}

/// Memory for the update of one survivor's maps.
#[derive(Debug)]
pub struct Desk {
    pub(crate) memory: UpdateMemory<LargeMemory, 1>,
}

/// The update of one survivor's maps.
pub(crate) type DraftOf = Draft<'static, Vector2<f32>>;

/// A place for that.
#[derive(Debug)]
pub struct DraftPlace {
    pub(crate) draft: MaybeUninit<DraftOf>,
}

/// The buffers of one large filter, in the memory of whoever runs its kernels; with one run.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Large {
    /// The run.
    pub run: *const Run,
    /// Its scans.
    pub scans: *const Scan,
    /// Its predictions.
    pub predictions: *const Prediction,
    /// Its measurements.
    pub measurements: *const Vector2<f32>,
    /// The filter, which begins as zeros.
    pub room: *mut Room,
    /// One for every candidate.
    pub sights: *mut Sight,
    /// One for every particle, which begins as zeros.
    pub desks: *mut Desk,
    /// One for every particle.
    pub drafts: *mut DraftPlace,
    /// How the run stands.
    pub status: *mut Status,
    /// A result for every scan.
    pub results: *mut ScanResult,
    /// Room for the estimated features of all scans.
    pub features: *mut Feature,
    /// Room for the estimated moving features of all scans.
    pub movers: *mut Mover,
}

/// Bytes of what a large filter's buffers are made of, room, sight, desk and draft, and what all of them are aligned to at most.
#[must_use]
pub fn large_bytes() -> [u64; 5] {
    let alignments = [align_of::<Room>(), align_of::<Sight>(), align_of::<Desk>(), align_of::<DraftPlace>()];
    let alignment = alignments.into_iter().fold(1, usize::max);
    [size_of::<Room>(), size_of::<Sight>(), size_of::<Desk>(), size_of::<DraftPlace>(), alignment].map(|x| x as u64)
}
