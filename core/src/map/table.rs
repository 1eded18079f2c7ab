//! For every particle the list of the pages that make up its map.

use super::{PageId, Pool};
use crate::{Dim, Packed, Real};

/// Memory of the page lists of PARTICLES maps, each of up to `MAP_PAGES` pages.
#[derive(Debug)]
pub struct MapTableMemory<const PARTICLES: usize, const MAP_PAGES: usize> {
    ids: [[PageId; MAP_PAGES]; PARTICLES],
    lengths: [u16; PARTICLES],
}

impl<const PARTICLES: usize, const MAP_PAGES: usize> MapTableMemory<PARTICLES, MAP_PAGES> {
    /// Every map empty.
    pub(crate) const ZERO: Self = Self { ids: [[PageId::ZERO; MAP_PAGES]; PARTICLES], lengths: [0; PARTICLES] };

    /// The table over this memory.
    pub(crate) fn view(&mut self) -> MapTable<'_> {
        MapTable { ids: self.ids.as_flattened_mut(), lengths: &mut self.lengths, map_pages: MAP_PAGES }
    }
}

/// Page lists, whatever their capacity.
#[derive(Debug)]
pub struct MapTable<'s> {
    ids: &'s mut [PageId],
    lengths: &'s mut [u16],
    map_pages: usize,
}

impl MapTable<'_> {
    /// A table without maps.
    pub(crate) fn none() -> Self {
        Self { ids: &mut [], lengths: &mut [], map_pages: 0 }
    }

    /// Pages one map can have.
    pub(crate) fn map_pages(&self) -> usize {
        self.map_pages
    }

    /// Empties every list, without regard to references.
    pub(crate) fn clear(&mut self) {
        self.lengths.fill(0);
    }

    /// The pages of a map.
    #[inline]
    pub(crate) fn pages(&self, map: usize) -> &[PageId] {
        let length = usize::from(self.lengths.get(map).copied().unwrap_or(0));
        let start = map * self.map_pages;
        self.ids.get(start..start + length).unwrap_or(&[])
    }

    /// Adds a page to a map, whose reference the map takes over; `false` when the list is full.
    pub(crate) fn push(&mut self, map: usize, id: PageId) -> bool {
        let Some(length) = self.lengths.get_mut(map) else { return false };
        let place = usize::from(*length);
        if place >= self.map_pages {
            return false;
        }
        let Some(slot) = self.ids.get_mut(map * self.map_pages + place) else { return false };
        *slot = id;
        *length += 1;
        true
    }

    /// Empties a map and gives its references back.
    pub(crate) fn release<T: Real, const N: usize, const D: usize>(&mut self, map: usize, pool: &mut Pool<'_, T, N, D>)
    where
        Dim<N>: Packed,
    {
        self.pages(map).iter().for_each(|&id| pool.release(id));
        if let Some(length) = self.lengths.get_mut(map) {
            *length = 0;
        }
    }

    /// Makes map `to` one more holder of the pages of map `from`. What `to` held before is forgotten, not released.
    pub(crate) fn share_within<T: Real, const N: usize, const D: usize>(
        &mut self,
        from: usize,
        to: usize,
        pool: &mut Pool<'_, T, N, D>,
    ) where
        Dim<N>: Packed,
    {
        let length = self.pages(from).len();
        let start = from * self.map_pages;
        self.pages(from).iter().for_each(|&id| pool.share(id));
        // The standard library's copy has a panic that the compiler cannot see to be out of reach.
        let target = to * self.map_pages;
        for offset in 0..length {
            let Some(&id) = self.ids.get(start + offset) else { break };
            if let Some(slot) = self.ids.get_mut(target + offset) {
                *slot = id;
            }
        }
        if let Some(slot) = self.lengths.get_mut(to) {
            *slot = length as u16;
        }
    }

    /// Takes over the lists of the first `maps` maps of another table of the same shape, references included, and
    /// leaves the other empty.
    pub(crate) fn take_over(&mut self, other: &mut MapTable<'_>, maps: usize) {
        self.clear();
        for map in 0..maps {
            for &id in other.pages(map) {
                self.push(map, id);
            }
        }
        other.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::MapTableMemory;
    use crate::map::PoolMemory;

    #[test]
    fn copies_share_pages_until_released() {
        let mut pool_memory = PoolMemory::<f32, 2, 2, 4>::ZERO;
        let mut pool = pool_memory.view();
        pool.clear();
        let mut table_memory = MapTableMemory::<3, 2>::ZERO;
        let mut table = table_memory.view();
        let (first, second) = (pool.take().unwrap().0, pool.take().unwrap().0);
        assert!(table.push(0, first) && table.push(0, second) && !table.push(0, first));
        table.share_within(0, 2, &mut pool);
        assert_eq!(table.pages(2), [first, second]);
        assert_eq!((pool.free(), pool.references(first)), (2, 2));
        table.release(0, &mut pool);
        assert_eq!((table.pages(0).len(), pool.references(second), pool.free()), (0, 1, 2));
        table.release(2, &mut pool);
        assert_eq!(pool.free(), 4);
    }
}
