//! The page lists of the maps, which several threads write at the same time: for a GPU.

use super::{Feature, Maps, PageId, Row};

/// The page lists of all maps of one kind of features, and those of the pool.
#[derive(Debug)]
pub struct Lists<'s, F: Feature> {
    /// The pages of every row, [`map_pages`](Self::map_pages) elements each.
    pub ids: &'s mut [PageId],
    /// The other data of every row.
    pub rows: &'s mut [Row<F::Position>],
    /// The row of every map.
    pub row_of: &'s mut [u16],
    /// The reference count of every page.
    pub references: &'s mut [u16],
    /// The free pages.
    pub free: &'s mut [PageId],
    /// Capacity of a map, in pages.
    pub map_pages: usize,
}

impl<'s, F: Feature> Maps<'s, F> {
    /// Hands over the lists until they are given back.
    pub(crate) fn lend_lists(&mut self) -> Lists<'s, F> {
        let (ids, rows, row_of, map_pages) = self.table.lend();
        let (references, free) = self.pool.lend_lists();
        Lists { ids, rows, row_of, references, free, map_pages }
    }

    /// Takes the lists back, with the number of free pages.
    pub(crate) fn give_lists_back(&mut self, lists: Lists<'s, F>, free_pages: usize) {
        let Lists { ids, rows, row_of, references, free, .. } = lists;
        self.table.give_back(ids, rows, row_of);
        self.pool.give_lists_back(references, free, free_pages);
    }
}
