//! The device memory of a filter, and where that of all filters of a launch lies.

use crate::buffer::{Feature, Mover, Prediction, Run, Scan, ScanResult, Status};
use crate::run::{Filter, Sighted};
use crate::setup::Models;
use crate::size::Size;
use crate::slot::{MEASUREMENTS, Slot};
use core::mem::MaybeUninit;
use core::sync::atomic::AtomicU32;
use nalgebra::Vector2;
use scphd::models::PlanarPose;
use scphd::numerics::{LnSum, Noise};
use scphd::storage::{Candidate, Draft, Dynamic, Page, Scanning, Static, UpdateMemory};

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
    pub(crate) in_use: usize,
    /// The random stream behind the last of them.
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

/// Bytes of what the buffers of filters are made of, room, sight, desk, draft and stream, and what all of them are aligned to at most.
#[must_use]
pub fn bytes<M: Size>() -> [u64; 6] {
    let alignments = [
        align_of::<Room<M>>(),
        align_of::<Sight>(),
        align_of::<Desk<M>>(),
        align_of::<DraftPlace>(),
        align_of::<StreamPlace>(),
    ];
    let alignment = alignments.into_iter().fold(1, usize::max);
    let sizes = [
        size_of::<Room<M>>(),
        size_of::<Sight>(),
        size_of::<Desk<M>>(),
        size_of::<DraftPlace>(),
        size_of::<StreamPlace>(),
    ];
    let [room, sight, desk, draft, stream] = sizes;
    [room, sight, desk, draft, stream, alignment].map(|x| x as u64)
}
