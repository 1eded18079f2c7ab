//! Memory of all particles' maps of one kind of features.

use super::{DraftMemory, DraftStorage, MapDraft, MapTable, MapTableMemory, Pool, PoolMemory};
use crate::Feature;
use crate::map::workspace::{Workspace, WorkspaceMemory};
use core::fmt::Debug;

mod sealed {
    pub trait Sealed {}
}

/// Memory of the maps of one kind of features, static or moving, of all particles: [`MapMemory`] or [`NoMoving`].
pub trait MapStorage<F: Feature>: sealed::Sealed + Debug {
    /// All zero.
    const ZERO: Self;
    /// Capacity, in particles.
    const PARTICLES: usize;
    /// Memory of the draft of one such map.
    #[doc(hidden)]
    type Draft: DraftStorage<F>;

    /// The maps in this memory.
    #[doc(hidden)]
    fn maps(&mut self) -> Maps<'_, F>;
}

/// Memory of the maps of one kind of features, with every capacity in the type.
///
/// | parameter | meaning |
/// |---|---|
/// | `F` | the kind of features: [`Static`](crate::Static) or [`Dynamic`](crate::Dynamic), with their positions |
/// | `PARTICLES` | maximum number of particles |
/// | `PAGES` | total number of pages in the pool that all maps share, with [`PAGE_LEN`](crate::PAGE_LEN) components each |
/// | `MAP_PAGES` | maximum number of pages of one map |
/// | `VIEW` | maximum number of components of one map in the update of a scan, before reduction |
#[derive(Debug)]
pub struct MapMemory<F: Feature, const PARTICLES: usize, const PAGES: usize, const MAP_PAGES: usize, const VIEW: usize>
{
    table: MapTableMemory<F::Position, PARTICLES, MAP_PAGES>,
    pool: PoolMemory<F, PAGES>,
    workspace: WorkspaceMemory<F::State, VIEW>,
}

impl<F: Feature, const PARTICLES: usize, const PAGES: usize, const MAP_PAGES: usize, const VIEW: usize> sealed::Sealed
    for MapMemory<F, PARTICLES, PAGES, MAP_PAGES, VIEW>
{
}

impl<F: Feature, const PARTICLES: usize, const PAGES: usize, const MAP_PAGES: usize, const VIEW: usize> MapStorage<F>
    for MapMemory<F, PARTICLES, PAGES, MAP_PAGES, VIEW>
{
    const ZERO: Self = {
        assert!(PAGES >= 1 && PAGES <= u16::MAX as usize, "pages are counted in 16 bits");
        assert!(MAP_PAGES >= 1 && MAP_PAGES <= PAGES, "a map cannot have more pages than the pool");
        assert!(VIEW >= crate::PAGE_LEN && VIEW < u16::MAX as usize, "VIEW must hold a page, and fit 16 bits");
        Self { table: MapTableMemory::ZERO, pool: PoolMemory::ZERO, workspace: WorkspaceMemory::ZERO }
    };
    const PARTICLES: usize = PARTICLES;
    type Draft = DraftMemory<F, MAP_PAGES, VIEW>;

    fn maps(&mut self) -> Maps<'_, F> {
        Maps { table: self.table.view(), pool: self.pool.view(), workspace: self.workspace.view() }
    }
}

/// No memory for moving features, for a filter in which all features are static.
#[derive(Debug)]
pub struct NoMoving {
    free_len: u16,
}

impl sealed::Sealed for NoMoving {}

impl<F: Feature> MapStorage<F> for NoMoving {
    const ZERO: Self = Self { free_len: 0 };
    const PARTICLES: usize = 0;
    type Draft = Self;

    fn maps(&mut self) -> Maps<'_, F> {
        Maps { table: MapTable::none(), pool: Pool::none(&mut self.free_len), workspace: Workspace::none() }
    }
}

impl<F: Feature> DraftStorage<F> for NoMoving {
    const ZERO: Self = Self { free_len: 0 };

    fn draft(&mut self) -> MapDraft<'_, F> {
        MapDraft::none()
    }
}

/// The maps of all particles, of one kind of features: page lists, pages, and the working memory of the update of one map.
#[derive(Debug)]
pub struct Maps<'s, F: Feature> {
    pub(crate) table: MapTable<'s, F::Position>,
    pub(crate) pool: Pool<'s, F>,
    pub(crate) workspace: Workspace<'s, F::State>,
}

impl<F: Feature> Maps<'_, F> {
    /// Empties every map.
    pub(crate) fn clear(&mut self) {
        self.table.clear();
        self.pool.clear();
    }

    /// The components of one particle's map, in no particular order.
    pub(crate) fn of(&self, particle: usize) -> impl Iterator<Item = &crate::Component<F::State>> {
        let pages = self.table.pages(particle).iter();
        pages.filter_map(|&id| self.pool.get(id)).flat_map(|page| page.components())
    }

    /// Number of pages in use.
    pub(crate) fn pages_used(&self) -> usize {
        self.pool.capacity() - self.pool.free()
    }
}
