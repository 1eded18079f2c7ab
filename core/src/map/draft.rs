//! The updated map of one survivor before it is stored, for updates of several maps at a time.

use super::table::MARGIN;
use super::{Feature, MapTable, Page, PageId, Pool, Row};
use crate::map::workspace::{Workspace, WorkspaceMemory};
use crate::{Bounds, Place, Real};
use core::fmt::Debug;

/// Memory of a draft, sized for the maps of one kind of features.
pub trait DraftStorage<F: Feature>: Debug + Send {
    /// All zero.
    const ZERO: Self;

    /// The draft in this memory.
    #[doc(hidden)]
    fn draft(&mut self) -> MapDraft<'_, F>;
}

/// Memory of the draft of a map of up to `MAP_PAGES` pages, with up to `VIEW` components in view.
#[derive(Debug)]
pub struct DraftMemory<F: Feature, const MAP_PAGES: usize, const VIEW: usize> {
    workspace: WorkspaceMemory<F::State, VIEW>,
    page_ids: [PageId; MAP_PAGES],
    row: [PageId; MAP_PAGES],
    pages: [Page<F>; MAP_PAGES],
}

impl<T: Real, F: Feature<Position: Place<Scalar = T>>, const MAP_PAGES: usize, const VIEW: usize> DraftStorage<F>
    for DraftMemory<F, MAP_PAGES, VIEW>
{
    const ZERO: Self = Self {
        workspace: WorkspaceMemory::ZERO,
        page_ids: [PageId::ZERO; MAP_PAGES],
        row: [PageId::ZERO; MAP_PAGES],
        pages: [Page::ZERO; MAP_PAGES],
    };

    fn draft(&mut self) -> MapDraft<'_, F> {
        MapDraft {
            workspace: self.workspace.view(),
            page_ids: &mut self.page_ids,
            replaced_len: 0,
            placed_len: 0,
            pages: &mut self.pages,
            pages_len: 0,
            row: &mut self.row,
            row_len: 0,
            head: Row::EMPTY,
            regained: 0,
        }
    }
}

/// The updated map of one kind of features.
#[derive(Debug)]
pub struct MapDraft<'w, F: Feature> {
    /// Its components in view.
    pub(crate) workspace: Workspace<'w, F::State>,
    /// First, the pages of the predicted map that the update replaces, in order: `replaced_len` of them. Later, the pages
    /// allocated for the updated map: `placed_len` of them.
    pub(crate) page_ids: &'w mut [PageId],
    pub(crate) replaced_len: usize,
    pub(crate) placed_len: usize,
    /// The pages to store if there is room for all: `pages_len` of them, which may be greater than the capacity.
    pub(crate) pages: &'w mut [Page<F>],
    pub(crate) pages_len: usize,
    /// The pages of the updated map, `row_len` of them; used if several drafts are stored at the same time.
    row: &'w mut [PageId],
    pub(crate) row_len: usize,
    head: Row<F::Position>,
    /// Number of replaced pages that no other map holds, not considering the drafts before.
    pub(crate) regained: usize,
}

impl<T: Real, F: Feature<Position: Place<Scalar = T>>> MapDraft<'_, F> {
    /// A draft without memory.
    pub(crate) fn none() -> Self {
        Self {
            workspace: Workspace::none(),
            page_ids: &mut [],
            replaced_len: 0,
            placed_len: 0,
            pages: &mut [],
            pages_len: 0,
            row: &mut [],
            row_len: 0,
            head: Row::EMPTY,
            regained: 0,
        }
    }

    /// Whether its capacities are those of the table and the workspace.
    pub(crate) fn fits(&self, table: &MapTable<'_, F::Position>, workspace: &Workspace<'_, F::State>) -> bool {
        self.workspace.capacity() == workspace.capacity() && self.page_ids.len() == table.map_pages()
    }

    /// The pages that the update replaces.
    pub(crate) fn replaced(&self) -> &[PageId] {
        self.page_ids.get(..self.replaced_len).unwrap_or(&[])
    }

    /// Finds the pages that the updated map keeps from the parent's, in the order that storing the draft by itself would give.
    pub(crate) fn line_up(
        &mut self,
        (table, pool): (&MapTable<'_, F::Position>, &Pool<'_, F>),
        parent: usize,
        only_child: bool,
        bounds: &Bounds<F::Position>,
    ) {
        let pages = table.pages(parent);
        let (known_far, known_vicinity) = table.far(parent);
        // Pages of moving features do not stay out of view.
        let sorted_anew = !F::MOVES && !known_vicinity.covers(bounds);
        let vicinity = if sorted_anew { bounds.grown(T::from_f64(MARGIN)) } else { known_vicinity };
        let first_near = if sorted_anew { 0 } else { known_far };
        let is_far = |id: PageId| sorted_anew && pool.get(id).is_some_and(|page| !page.bounds().meets(&vicinity));
        let Self { page_ids, replaced_len, row, row_len, regained, .. } = self;
        (*row_len, *regained) = (0, 0);
        let mut keep = |id: PageId| {
            if let Some(slot) = row.get_mut(*row_len) {
                *slot = id;
                *row_len += 1;
            }
            *row_len
        };
        let known = pages.get(..first_near).unwrap_or(&[]).iter();
        let far = known.chain(pages.iter().filter(|&&id| is_far(id))).fold(0, |_, &id| keep(id));
        let mut replaced = page_ids.iter().take(*replaced_len).peekable();
        for &id in pages.get(first_near..).unwrap_or(&[]) {
            if is_far(id) {
                continue;
            }
            if replaced.next_if_eq(&&id).is_none() {
                keep(id);
            } else if only_child {
                *regained += usize::from(pool.references(id) == 1);
            }
        }
        self.head = Row { len: self.row_len as u16, far: far as u16, vicinity };
    }

    /// The pages of the updated map.
    pub(crate) fn row(&self) -> &[PageId] {
        self.row.get(..self.row_len).unwrap_or(&[])
    }

    /// Whether the updated map has room for its new pages.
    pub(crate) fn fits_row(&self) -> bool {
        self.pages_len <= self.pages.len() && self.row_len + self.pages_len <= self.row.len()
    }

    /// Allocates the new pages.
    pub(crate) fn take(&mut self, mut next: impl FnMut(usize) -> Option<PageId>) {
        for (place, slot) in self.page_ids.iter_mut().enumerate().take(self.pages_len) {
            let Some(id) = next(place) else { break };
            *slot = id;
            self.placed_len += 1;
            if let Some(slot) = self.row.get_mut(self.row_len) {
                *slot = id;
                self.row_len += 1;
            }
        }
        self.head.len = self.row_len as u16;
    }

    /// Writes the page list of the updated map.
    pub(crate) fn write_row(&self, ids: &mut [PageId], head: &mut Row<F::Position>) {
        ids.iter_mut().zip(self.row()).for_each(|(slot, &id)| *slot = id);
        *head = self.head;
    }
}
