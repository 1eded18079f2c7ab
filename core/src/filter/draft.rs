//! Drafts: updated maps before they are stored, on which several cores work at the same time.

use crate::detection::normalise::Normalisers;
use crate::detection::seen::{Seen, reset_eta};
use crate::filter::survivor::{ScanView, Workspaces};
use crate::filter::tally::Tally;
use crate::filter::task::Task;
use crate::filter::waiting::memory::Noted;
use crate::map::workspace::Workspace;
use crate::map::{DraftStorage, MapDraft, Maps, Page, PageId};
use crate::{Bounds, Dynamic, Feature, LnSum, MapStorage, MeasurementModel, Place, Pose, Real, State, Static};
use core::fmt::Debug;

mod sealed {
    pub trait Sealed {}
}

/// The capacities of a [`State`], from which [`UpdateMemory`] takes its own.
pub trait Capacities: sealed::Sealed {
    /// Position of a feature.
    #[doc(hidden)]
    type Position: Place;
    /// Memory of the draft of a static map.
    #[doc(hidden)]
    type StaticDraft: DraftStorage<Static<Self::Position>>;
    /// Memory of the draft of a moving map.
    #[doc(hidden)]
    type MovingDraft: DraftStorage<Dynamic<Self::Position>>;
}

impl<P: Pose, const PARTICLES: usize, const CANDIDATES: usize, S, V, const WAITING: usize> sealed::Sealed
    for State<P, PARTICLES, CANDIDATES, S, V, WAITING>
{
}

impl<P: Pose, const PARTICLES: usize, const CANDIDATES: usize, S, V, const WAITING: usize> Capacities
    for State<P, PARTICLES, CANDIDATES, S, V, WAITING>
where
    S: MapStorage<Static<P::Position>>,
    V: MapStorage<Dynamic<P::Position>>,
{
    type Position = P::Position;
    type StaticDraft = S::Draft;
    type MovingDraft = V::Draft;
}

/// Working memory to update several maps at the same time, on several cores: for [`ScPhd::scan_on`](crate::ScPhd::scan_on).
///
/// `M` is the [`State`] that has the maps. `DRAFTS` is at least the number of cores, better several times that: as many survivors
/// are updated before their maps are stored in order, and the cores wait for the last of them. Each draft has memory for the pages
/// of one map and for the components that an update may change: in single precision 276 bytes for every page of static features and
/// 50 for every component, 564 and 86 for moving features. No data is kept from scan to scan.
#[derive(Debug)]
pub struct UpdateMemory<M: Capacities, const DRAFTS: usize> {
    drafts: [(M::StaticDraft, M::MovingDraft); DRAFTS],
}

impl<M: Capacities, const DRAFTS: usize> UpdateMemory<M, DRAFTS> {
    /// An empty memory, all zero and meant to be a `static`, like [`State`].
    pub const fn new() -> Self {
        Self { drafts: [const { (M::StaticDraft::ZERO, M::MovingDraft::ZERO) }; DRAFTS] }
    }

    /// The drafts in this memory.
    pub fn drafts(&mut self) -> [Draft<'_, M::Position>; DRAFTS] {
        self.drafts.each_mut().map(|(of_static, of_moving)| Draft::over(of_static.draft(), of_moving.draft()))
    }
}

/// The mapping of a draft's new labels to their final values, which depend on the drafts that are stored before it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Renaming {
    /// The first label that was free for all drafts of the round.
    pub(crate) first_fresh: u32,
    /// Number of new labels of the draft.
    pub(crate) fresh: u32,
    /// Number of labels that drafts before it have used.
    pub(crate) label_offset: u32,
}

impl Renaming {
    const NONE: Self = Self { first_fresh: 0, fresh: 0, label_offset: 0 };

    #[inline]
    pub(crate) fn apply(&self, label: &mut u32) {
        if label.wrapping_sub(self.first_fresh) < self.fresh {
            *label = label.wrapping_add(self.label_offset);
        }
    }
}

/// The updated maps of one survivor before they are stored; part of an [`UpdateMemory`].
#[derive(Debug)]
pub struct Draft<'w, D: Place> {
    pub(crate) of_static: MapDraft<'w, Static<D>>,
    pub(crate) of_moving: MapDraft<'w, Dynamic<D>>,
    /// The survivor that is updated.
    pub(crate) task: Task,
    /// The bounding box of the view.
    pub(crate) bounds: Bounds<D>,
    /// Counts of the update.
    pub(crate) tally: Tally<D::Scalar>,
    /// Delayed births.
    pub(crate) noted: Noted<D::Scalar>,
    /// Number of new labels; the first is the argument of [`make`](Self::make).
    pub(crate) labels: u32,
    /// The mapping to their final values.
    pub(crate) renaming: Renaming,
    /// Whether the draft is complete: the same as an update in sequence would give.
    pub(crate) is_whole: bool,
}

impl<'w, T: Real, D: Place<Scalar = T>> Draft<'w, D> {
    fn over(of_static: MapDraft<'w, Static<D>>, of_moving: MapDraft<'w, Dynamic<D>>) -> Self {
        Self {
            of_static,
            of_moving,
            task: Task::NONE,
            bounds: Bounds::EMPTY,
            tally: Tally::new(),
            noted: Noted::NOTHING,
            labels: 0,
            renaming: Renaming::NONE,
            is_whole: false,
        }
    }

    /// Assigns the draft to another survivor, and empties it.
    pub(crate) fn begin(&mut self, task: Task) {
        (self.task, self.is_whole) = (task, false);
        (self.of_static.placed_len, self.of_moving.placed_len) = (0, 0);
    }

    /// Whether its capacities are those of the maps.
    pub(crate) fn fits(&self, (static_maps, moving_maps): (&Maps<'_, Static<D>>, &Maps<'_, Dynamic<D>>)) -> bool {
        self.of_static.fits(&static_maps.table, &static_maps.workspace)
            && self.of_moving.fits(&moving_maps.table, &moving_maps.workspace)
    }

    /// Updates the maps of its survivor from those of its parent. New labels begin with `first_fresh`.
    pub(crate) fn make<X: MeasurementModel<Pose: Pose<Scalar = T, Position = D>>>(
        &mut self,
        scan_view: &ScanView<'_, X>,
        (static_maps, moving_maps): (&Maps<'_, Static<D>>, &Maps<'_, Dynamic<D>>),
        eta: &mut [LnSum<T>],
        first_fresh: u32,
    ) {
        let Self { of_static, of_moving, task, bounds, tally, noted, labels, is_whole, .. } = self;
        *bounds = scan_view.bounds;
        *tally = Tally::new();
        let workspaces = (&mut of_static.workspace, &mut of_moving.workspace);
        reset_eta(eta, scan_view.scan);
        let mut seen = Seen::with_missed(scan_view.view.missed);
        let parent = task.parent;
        of_static.replaced_len =
            collect(workspaces.0, of_static.page_ids, static_maps, parent, scan_view, eta, &mut seen, tally);
        let mut both = Workspaces { of_static: workspaces.0, of_moving: workspaces.1 };
        both.add_expected_births(scan_view, eta, &mut seen, tally);
        of_moving.replaced_len =
            collect(both.of_moving, of_moving.page_ids, moving_maps, parent, scan_view, eta, &mut seen, tally);
        tally.expected_detections = seen.expected_detections;
        // Labels wrap around: an old label may equal a new one. The draft is then incomplete.
        let most_fresh = both.of_static.capacity() + both.of_moving.capacity();
        let is_fresh = |label: u32| (label.wrapping_sub(first_fresh) as usize) < most_fresh;
        let clash = both.of_static.labels().chain(both.of_moving.labels()).any(is_fresh);
        let mut next_label = first_fresh;
        let normalisers = Normalisers::of(eta, scan_view.scan);
        both.complete(scan_view, &normalisers, &mut next_label, noted, tally, &mut ());
        both.of_static.count(tally);
        both.of_moving.count(tally);
        *labels = next_label.wrapping_sub(first_fresh);
        of_static.write(bounds);
        of_moving.write(bounds);
        *is_whole = !clash;
    }

    /// Writes the content of the pages that were [allocated](MapDraft::place); none if the map had to be reduced and was stored
    /// directly.
    pub(crate) fn fill(
        &mut self,
        write_static: impl FnMut(PageId, &Page<Static<D>>),
        write_moving: impl FnMut(PageId, &Page<Dynamic<D>>),
    ) {
        self.of_static.fill(&self.renaming, write_static);
        self.of_moving.fill(&self.renaming, write_moving);
    }
}

/// Fills the workspace with the updated components of the parent's map in view, and adds their terms to η_z. Returns the number
/// of pages that they replace, which are the first elements of `page_ids`.
#[expect(clippy::too_many_arguments, reason = "what the update reads and what it writes")]
fn collect<T: Real, F, X>(
    workspace: &mut Workspace<'_, F::State>,
    page_ids: &mut [PageId],
    maps: &Maps<'_, F>,
    parent: usize,
    scan_view: &ScanView<'_, X>,
    eta: &mut [LnSum<T>],
    seen: &mut Seen<T>,
    tally: &mut Tally<T>,
) -> usize
where
    F: Feature<Position: Place<Scalar = T>>,
    X: MeasurementModel<Pose: Pose<Scalar = T, Position = F::Position>>,
{
    workspace.clear(scan_view.config.prune_weight.ln());
    let ln_unconfirmed = scan_view.config.unconfirmed_weight.ln();
    let mut replaced = 0;
    for id in maps.table.pages_to_update(parent, &scan_view.bounds, &maps.pool) {
        if let Some(page) = maps.pool.get(id)
            && workspace.update_page::<F, X>(page, scan_view, ln_unconfirmed, eta, seen, tally)
            && let Some(slot) = page_ids.get_mut(replaced)
        {
            *slot = id;
            replaced += 1;
        }
    }
    replaced
}
