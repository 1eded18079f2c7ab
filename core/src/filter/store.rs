//! Storing updated maps: pruning until they fit, and writing to pages.

use crate::filter::draft::Renaming;
use crate::filter::tally::Tally;
use crate::filter::task::Task;
use crate::map::reduce::keep_heaviest;
use crate::map::workspace::{Entry, Origin, Ranked, Workspace};
use crate::map::{MapDraft, MapTable, PAGE_LEN, Page, PageId, Pool};
use crate::numerics::sort::BUCKETS;
use crate::{Bounds, Feature, Place, Real, Vector};

/// Writes an updated map. Returns `false`, and keeps the predicted map, if even its confirmed components do not fit. `regained`
/// is the number of replaced pages that no other map holds.
pub(crate) fn store<T: Real, F: Feature<Position: Place<Scalar = T>>>(
    (table, pool): (&mut MapTable<'_, F::Position>, &mut Pool<'_, F>),
    workspace: &mut Workspace<'_, F::State>,
    task: &Task,
    regained: usize,
    bounds: &Bounds<F::Position>,
    tally: &mut Tally<T>,
) -> bool {
    let fits = workspace.fit(room((table, pool), task, regained), tally);
    if fits {
        table.release_replaced(pool);
        write((table, pool), workspace, task.particle, bounds, tally);
    } else {
        table.restore_replaced(task.particle);
    }
    fits
}

/// Writes the workspace to new pages in spatial order, so that the bounding boxes of the pages are small.
fn write<T: Real, F: Feature<Position: Place<Scalar = T>>>(
    (table, pool): (&mut MapTable<'_, F::Position>, &mut Pool<'_, F>),
    workspace: &mut Workspace<'_, F::State>,
    particle: usize,
    bounds: &Bounds<F::Position>,
    tally: &mut Tally<T>,
) {
    let (entries, order) = in_spatial_order::<T, F>(workspace, bounds);
    for chunk in order.chunks(PAGE_LEN) {
        let Some((id, page)) = pool.take() else {
            tally.lost += chunk.len();
            continue;
        };
        fill(page, entries, chunk);
        if !table.push_updated(particle, id) {
            pool.release(id);
            tally.lost += chunk.len();
        }
    }
}

impl<T: Real, F: Feature<Position: Place<Scalar = T>>> MapDraft<'_, F> {
    /// Writes the workspace to the pages of the draft, as [`store`] does to those of the pool.
    pub(crate) fn write(&mut self, bounds: &Bounds<F::Position>) {
        let (entries, order) = in_spatial_order::<T, F>(&mut self.workspace, bounds);
        let chunks = order.chunks(PAGE_LEN);
        self.pages_len = chunks.len();
        chunks.zip(self.pages.iter_mut()).for_each(|(chunk, page)| fill(page, entries, chunk));
    }

    /// As [`store`], but only allocates the pages if there is room for all components: their content is in the draft already, and
    /// [`fill`](Self::fill) writes it.
    pub(crate) fn place(
        &mut self,
        (table, pool): (&mut MapTable<'_, F::Position>, &mut Pool<'_, F>),
        task: &Task,
        regained: usize,
        bounds: &Bounds<F::Position>,
        renaming: &Renaming,
        tally: &mut Tally<T>,
    ) -> bool {
        let room = room((table, pool), task, regained);
        if self.workspace.len() > room * PAGE_LEN {
            self.workspace.in_view_mut().iter_mut().for_each(|entry| renaming.apply(&mut entry.component.label));
            return store((table, pool), &mut self.workspace, task, regained, bounds, tally);
        }
        table.release_replaced(pool);
        // After the first page without room, none of the following has room either.
        for (written, slot) in self.pages.iter().take(self.pages_len).zip(self.page_ids.iter_mut()) {
            let Some((id, _)) = pool.take() else {
                tally.lost += written.components().len();
                continue;
            };
            if table.push_updated(task.particle, id) {
                *slot = id;
                self.placed_len += 1;
            } else {
                pool.release(id);
                tally.lost += written.components().len();
            }
        }
        true
    }

    /// Writes the draft's pages to the allocated ones.
    pub(crate) fn fill(&mut self, renaming: &Renaming, mut write: impl FnMut(PageId, &Page<F>)) {
        self.rename(renaming);
        let (ids, pages) = self.placed();
        ids.iter().zip(pages).for_each(|(&id, page)| write(id, page));
    }

    /// Assigns the final values to the new labels.
    pub(crate) fn rename(&mut self, renaming: &Renaming) {
        for page in self.pages.iter_mut().take(self.placed_len) {
            page.labels_mut().for_each(|label| renaming.apply(label));
        }
    }

    /// The allocated pages, and their content.
    pub(crate) fn placed(&self) -> (&[PageId], &[Page<F>]) {
        (self.page_ids.get(..self.placed_len).unwrap_or(&[]), self.pages)
    }
}

/// The components of a workspace, and their order along a Morton curve.
fn in_spatial_order<'w, T: Real, F: Feature<Position: Place<Scalar = T>>>(
    workspace: &'w mut Workspace<'_, F::State>,
    bounds: &Bounds<F::Position>,
) -> (&'w [Entry<F::State>], &'w [Ranked]) {
    let cells = morton_cells(bounds);
    workspace.in_order(|component| morton(&component.position(), bounds, &cells))
}

/// Fills a page with a part of the ordered components.
fn fill<T: Real, F: Feature<Position: Place<Scalar = T>>>(
    page: &mut Page<F>,
    entries: &[Entry<F::State>],
    chunk: &[Ranked],
) {
    let components = chunk.iter().filter_map(|ranked| entries.get(usize::from(ranked.entry)));
    page.fill(components.map(|entry| &entry.component));
}

/// Number of pages that an updated map may allocate.
fn room<T: Real, F: Feature<Position: Place<Scalar = T>>>(
    (table, pool): (&MapTable<'_, F::Position>, &Pool<'_, F>),
    task: &Task,
    regained: usize,
) -> usize {
    let share = pool.free().saturating_sub(task.reserved).checked_div(task.remaining).unwrap_or(0) + regained;
    table.room(task.particle).min(share)
}

impl<T: Real, N: Vector<Scalar = T>> Workspace<'_, N> {
    /// Reduces the updated components to `room` pages: removes components below half a feature, the lightest first, then births.
    /// Returns `false` if the confirmed components alone do not fit.
    fn fit(&mut self, room: usize, tally: &mut Tally<T>) -> bool {
        let slots = room * PAGE_LEN;
        if self.len() <= slots {
            return true;
        }
        let Some(limit) = slots.checked_sub(self.outside()) else { return false };
        let ln_half = T::from_f64(0.5).ln();
        let confirmed = |entry: &Entry<N>| entry.component.ln_weight >= ln_half;
        let class = |entry: &Entry<N>| match entry.origin {
            Origin::Born if confirmed(entry) => 1,
            _ if confirmed(entry) => 0,
            _ => 2,
        };
        if self.in_view().iter().filter(|entry| class(entry) == 0).count() > limit {
            return false;
        }
        tally.tightened += 1;
        keep_heaviest(self, limit, class);
        true
    }
}

/// Number of bits of each coordinate in the Morton curve.
const fn morton_bits<D: Vector>() -> u32 {
    // At most four, because of the size of the table in `spaced`.
    let bits = BUCKETS.ilog2() / D::DIMENSION as u32;
    if bits > 4 { 4 } else { bits }
}

/// Number of cells of the Morton curve per unit of each coordinate.
fn morton_cells<T: Real, D: Vector<Scalar = T>>(bounds: &Bounds<D>) -> D {
    let cells = T::from_usize(1 << const { morton_bits::<D>() });
    let extent = bounds.high - bounds.low;
    D::with(|k| cells / extent.at(k))
}

/// The index of a position along a Morton curve over `bounds`, as a [bucket](BUCKETS).
#[inline]
fn morton<T: Real, D: Vector<Scalar = T>>(position: &D, bounds: &Bounds<D>, per_unit: &D) -> usize {
    let offset = *position - bounds.low;
    let places = D::with(|k| offset.at(k) * per_unit.at(k));
    let mut key = 0;
    for (axis, place) in places.as_slice().iter().enumerate() {
        let cell = place.to_index((1 << const { morton_bits::<D>() }) - 1);
        let spaced = const { spaced::<D>() };
        key |= usize::from(spaced.get(cell).copied().unwrap_or(0)) << axis;
    }
    key
}

/// For every cell along an axis, its bits with a spacing of D.
#[expect(clippy::indexing_slicing, reason = "evaluated by the compiler alone")]
const fn spaced<D: Vector>() -> [u8; 16] {
    let mut spaced = [0; 16];
    let mut cell = 0;
    while cell < spaced.len() {
        let mut bit = 0;
        while bit < morton_bits::<D>() {
            spaced[cell] |= ((cell >> bit & 1) << (bit * D::DIMENSION as u32)) as u8;
            bit += 1;
        }
        cell += 1;
    }
    spaced
}
