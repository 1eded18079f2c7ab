//! The updated map of one survivor before it is stored, for those who update several at a time.

use super::{Feature, MapTable, Page, PageId};
use crate::map::workspace::{Workspace, WorkspaceMemory};
use crate::{Place, Real};
use core::fmt::Debug;

/// Memory of a draft, as large as the maps of one kind of features want it.
pub trait DraftStorage<F: Feature>: Debug + Send {
    /// All zero.
    const ZERO: Self;

    /// The draft over this memory.
    #[doc(hidden)]
    fn draft(&mut self) -> MapDraft<'_, F>;
}

/// Memory of the draft of a map of up to `MAP_PAGES` pages, of which VIEW components are in view.
#[derive(Debug)]
pub struct DraftMemory<F: Feature, const MAP_PAGES: usize, const VIEW: usize> {
    workspace: WorkspaceMemory<F::State, VIEW>,
    aside: [PageId; MAP_PAGES],
    pages: [Page<F>; MAP_PAGES],
}

impl<T: Real, F: Feature<Position: Place<Scalar = T>>, const MAP_PAGES: usize, const VIEW: usize> DraftStorage<F>
    for DraftMemory<F, MAP_PAGES, VIEW>
{
    const ZERO: Self =
        Self { workspace: WorkspaceMemory::ZERO, aside: [PageId::ZERO; MAP_PAGES], pages: [Page::ZERO; MAP_PAGES] };

    fn draft(&mut self) -> MapDraft<'_, F> {
        MapDraft {
            workspace: self.workspace.view(),
            aside: &mut self.aside,
            aside_len: 0,
            placed_len: 0,
            pages: &mut self.pages,
            pages_len: 0,
        }
    }
}

/// The updated map of one kind of features.
#[derive(Debug)]
pub struct MapDraft<'w, F: Feature> {
    /// Its components in view.
    pub(crate) workspace: Workspace<'w, F::State>,
    /// Pages of the predicted map that they replace, in order: the first `aside_len`. Afterwards those that are taken for the updated
    /// ones: the first `placed_len`.
    pub(crate) aside: &'w mut [PageId],
    pub(crate) aside_len: usize,
    pub(crate) placed_len: usize,
    /// The components as they are written to pages where there is room for all: the first `pages_len`, or more than there are.
    pub(crate) pages: &'w mut [Page<F>],
    pub(crate) pages_len: usize,
}

impl<F: Feature> MapDraft<'_, F> {
    /// A draft of no map.
    pub(crate) fn none() -> Self {
        Self { workspace: Workspace::none(), aside: &mut [], aside_len: 0, placed_len: 0, pages: &mut [], pages_len: 0 }
    }

    /// Whether it is as large as maps in this table and this workspace need.
    pub(crate) fn fits(&self, table: &MapTable<'_, F::Position>, workspace: &Workspace<'_, F::State>) -> bool {
        self.workspace.capacity() == workspace.capacity() && self.aside.len() == table.map_pages()
    }

    /// The pages aside.
    pub(crate) fn aside(&self) -> &[PageId] {
        self.aside.get(..self.aside_len).unwrap_or(&[])
    }
}
