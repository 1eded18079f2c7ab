//! Memory of all particles' maps of one kind of features.

use super::{MapTable, MapTableMemory, Pool, PoolMemory};
use crate::workspace::{Workspace, WorkspaceMemory};
use crate::{Dim, Packed, Real};
use core::fmt::Debug;

mod sealed {
    pub trait Sealed {}
}

/// Memory for the maps of one kind of features, static or moving, of every particle: [`MapMemory`], or [`NoMoving`].
pub trait MapStorage<T: Real, const N: usize, const D: usize>: sealed::Sealed + Debug
where
    Dim<N>: Packed,
{
    /// All zero.
    const ZERO: Self;
    /// Particles it has maps for.
    const PARTICLES: usize;

    /// The maps over this memory.
    #[doc(hidden)]
    fn maps(&mut self) -> Maps<'_, T, N, D>;
}

/// Memory for the maps of one kind of features, with every capacity in the type.
///
/// | parameter | meaning |
/// |---|---|
/// | `T` | scalar |
/// | `N`, `D` | dimensions of a feature's state and of its position: N = D for static features, 2D for moving ones |
/// | `PARTICLES` | particles |
/// | `PAGES` | pages of [`PAGE_LEN`](crate::PAGE_LEN) components in the pool that all maps share |
/// | `MAP_PAGES` | pages one map can have |
/// | `VIEW` | components of one map that the update of a scan may touch, before reduction |
#[derive(Debug)]
pub struct MapMemory<
    T: Real,
    const N: usize,
    const D: usize,
    const PARTICLES: usize,
    const PAGES: usize,
    const MAP_PAGES: usize,
    const VIEW: usize,
> where
    Dim<N>: Packed,
{
    table: MapTableMemory<T, D, PARTICLES, MAP_PAGES>,
    pool: PoolMemory<T, N, D, PAGES>,
    workspace: WorkspaceMemory<T, N, VIEW>,
}

impl<
    T: Real,
    const N: usize,
    const D: usize,
    const PARTICLES: usize,
    const PAGES: usize,
    const MAP_PAGES: usize,
    const VIEW: usize,
> sealed::Sealed for MapMemory<T, N, D, PARTICLES, PAGES, MAP_PAGES, VIEW>
where
    Dim<N>: Packed,
{
}

impl<
    T: Real,
    const N: usize,
    const D: usize,
    const PARTICLES: usize,
    const PAGES: usize,
    const MAP_PAGES: usize,
    const VIEW: usize,
> MapStorage<T, N, D> for MapMemory<T, N, D, PARTICLES, PAGES, MAP_PAGES, VIEW>
where
    Dim<N>: Packed,
{
    const ZERO: Self = {
        assert!(PAGES >= 1 && PAGES <= u16::MAX as usize, "pages are counted in 16 bits");
        assert!(MAP_PAGES >= 1 && MAP_PAGES <= PAGES, "a map cannot have more pages than the pool");
        assert!(VIEW >= crate::PAGE_LEN && VIEW < u16::MAX as usize, "VIEW must hold a page, and fit 16 bits");
        Self { table: MapTableMemory::ZERO, pool: PoolMemory::ZERO, workspace: WorkspaceMemory::ZERO }
    };
    const PARTICLES: usize = PARTICLES;

    fn maps(&mut self) -> Maps<'_, T, N, D> {
        Maps { table: self.table.view(), pool: self.pool.view(), workspace: self.workspace.view() }
    }
}

/// No memory at all, for a filter that takes everything for static.
#[derive(Debug)]
pub struct NoMoving {
    free_len: u16,
}

impl sealed::Sealed for NoMoving {}

impl<T: Real, const N: usize, const D: usize> MapStorage<T, N, D> for NoMoving
where
    Dim<N>: Packed,
{
    const ZERO: Self = Self { free_len: 0 };
    const PARTICLES: usize = 0;

    fn maps(&mut self) -> Maps<'_, T, N, D> {
        Maps { table: MapTable::none(), pool: Pool::none(&mut self.free_len), workspace: Workspace::none() }
    }
}

/// The maps of all particles, of one kind of features: page lists, the pages, and the scratch of one map's update.
#[derive(Debug)]
pub struct Maps<'s, T: Real, const N: usize, const D: usize>
where
    Dim<N>: Packed,
{
    pub(crate) table: MapTable<'s, T, D>,
    pub(crate) pool: Pool<'s, T, N, D>,
    pub(crate) workspace: Workspace<'s, T, N>,
}

impl<T: Real, const N: usize, const D: usize> Maps<'_, T, N, D>
where
    Dim<N>: Packed,
{
    /// Empties every map.
    pub(crate) fn clear(&mut self) {
        self.table.clear();
        self.pool.clear();
    }

    /// The components of one particle's map, in no particular order.
    pub(crate) fn of(&self, particle: usize) -> impl Iterator<Item = &crate::Component<T, N>> {
        let pages = self.table.pages(particle).iter();
        pages.filter_map(|&id| self.pool.get(id)).flat_map(|page| page.components())
    }

    /// Pages in use.
    pub(crate) fn pages_used(&self) -> usize {
        self.pool.capacity() - self.pool.free()
    }
}
