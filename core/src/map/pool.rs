//! The pool of pages that all maps share, with a reference count for every page.

use super::Page;
use crate::{Feature, Real, Vector};

/// Index of a page in its pool.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PageId(u16);

impl PageId {
    /// A placeholder for unused memory.
    pub(crate) const ZERO: Self = Self(0);

    /// The page with this index.
    pub fn of(index: u16) -> Self {
        Self(index)
    }

    /// The index of the page in its pool.
    pub fn index(self) -> usize {
        usize::from(self.0)
    }

    #[cfg(any(test, feature = "flips"))]
    pub(crate) fn number(&mut self) -> &mut u16 {
        &mut self.0
    }
}

/// Memory of a pool of PAGES pages.
#[derive(Debug)]
pub struct PoolMemory<F: Feature, const PAGES: usize> {
    pages: [Page<F>; PAGES],
    references: [u16; PAGES],
    /// The free pages are the first `free_len` of these.
    free: [PageId; PAGES],
    free_len: u16,
}

impl<F: Feature, const PAGES: usize> PoolMemory<F, PAGES> {
    /// All zero: a pool without a free page, until [`Pool::clear`].
    pub(crate) const ZERO: Self =
        Self { pages: [Page::ZERO; PAGES], references: [0; PAGES], free: [PageId::ZERO; PAGES], free_len: 0 };

    /// The pool in this memory.
    pub(crate) fn view(&mut self) -> Pool<'_, F> {
        Pool {
            pages: &mut self.pages,
            references: &mut self.references,
            free: &mut self.free,
            free_len: &mut self.free_len,
        }
    }
}

/// A pool of pages of any capacity.
#[derive(Debug)]
pub struct Pool<'s, F: Feature> {
    pages: &'s mut [Page<F>],
    references: &'s mut [u16],
    free: &'s mut [PageId],
    free_len: &'s mut u16,
}

impl<'s, F: Feature + Feature<Position: Vector<Scalar: Real>> + Feature<Position: Vector<Scalar: Real>>> Pool<'s, F> {
    /// A pool without pages.
    pub(crate) fn none(free_len: &'s mut u16) -> Self {
        Self { pages: &mut [], references: &mut [], free: &mut [], free_len }
    }

    /// Frees every page.
    pub(crate) fn clear(&mut self) {
        self.references.fill(0);
        *self.free_len = 0;
        // The last page freed is the first one allocated: so indices are allocated in ascending order.
        for index in (0..self.pages.len()).rev() {
            self.put_back(PageId(index as u16));
        }
    }

    fn put_back(&mut self, id: PageId) {
        if let Some(slot) = self.free.get_mut(usize::from(*self.free_len)) {
            *slot = id;
            *self.free_len += 1;
        }
    }

    /// Number of free pages, limited to the capacity because a memory fault may have increased it.
    pub(crate) fn free(&self) -> usize {
        usize::from(*self.free_len).min(self.pages.len())
    }

    /// Total number of pages.
    pub(crate) fn capacity(&self) -> usize {
        self.pages.len()
    }

    /// The page with this id.
    #[inline]
    pub(crate) fn get(&self, id: PageId) -> Option<&Page<F>> {
        self.pages.get(id.index())
    }

    /// All pages that maps hold, to change them for all maps at once.
    pub(crate) fn held_mut(&mut self) -> impl Iterator<Item = &mut Page<F>> {
        let held = self.pages.iter_mut().zip(self.references.iter()).filter(|(_, references)| **references > 0);
        held.map(|(page, _)| page)
    }

    /// The same pages, in at most `parts` parts.
    pub(crate) fn held_in_parts(
        &mut self,
        parts: usize,
    ) -> impl Iterator<Item = impl Iterator<Item = &mut Page<F>> + Send> + Send {
        // Pages are allocated from the front: often many pages behind the last held one are free.
        let len = self.references.iter().rposition(|&references| references > 0).map_or(0, |last| last + 1);
        let each = len.div_ceil(parts.max(1)).max(1);
        let parts = self.pages.get_mut(..len).unwrap_or(&mut []).chunks_mut(each).zip(self.references.chunks(each));
        parts.map(|(pages, references)| {
            let held = pages.iter_mut().zip(references).filter(|(_, references)| **references > 0);
            held.map(|(page, _)| page)
        })
    }

    /// Copies a page to a page that a map holds.
    pub(crate) fn write(&mut self, id: PageId, other: &Page<F>) {
        if let Some(page) = self.held(id.index()) {
            page.copy_from(other);
        }
    }

    /// Whether a map holds the page with this index.
    pub(crate) fn is_held(&self, index: usize) -> bool {
        self.references.get(index).is_some_and(|&references| references > 0)
    }

    /// Hands over all pages, until they are [given back](Self::give_pages_back). Meanwhile the pool has none.
    pub(crate) fn lend_pages(&mut self) -> &'s mut [Page<F>] {
        core::mem::take(&mut self.pages)
    }

    /// Takes the pages back.
    pub(crate) fn give_pages_back(&mut self, pages: &'s mut [Page<F>]) {
        self.pages = pages;
    }

    /// Hands over the reference counts and the list of free pages.
    pub(crate) fn lend_lists(&mut self) -> (&'s mut [u16], &'s mut [PageId]) {
        (core::mem::take(&mut self.references), core::mem::take(&mut self.free))
    }

    /// Takes them back, with the number of free pages.
    pub(crate) fn give_lists_back(&mut self, references: &'s mut [u16], free: &'s mut [PageId], free_pages: usize) {
        *self.free_len = free_pages.min(free.len()) as u16;
        (self.references, self.free) = (references, free);
    }

    /// Allocates a page, with one reference, for the caller to fill; `None` if no page is free.
    pub(crate) fn take(&mut self) -> Option<(PageId, &mut Page<F>)> {
        let last = self.free_len.checked_sub(1)?;
        let id = *self.free.get(usize::from(last))?;
        let references = self.references.get_mut(id.index())?;
        let page = self.pages.get_mut(id.index())?;
        *self.free_len = last;
        *references = 1;
        Some((id, page))
    }

    /// Allocates a page and copies a held page to it; `None` if no page is free.
    pub(crate) fn take_copy(&mut self, of: PageId) -> Option<PageId> {
        let (id, _) = self.take()?;
        if let Ok([copy, page]) = self.pages.get_disjoint_mut([id.index(), of.index()]) {
            copy.copy_from(page);
        }
        Some(id)
    }

    /// Adds a reference to a page.
    pub(crate) fn share(&mut self, id: PageId) {
        if let Some(references) = self.references.get_mut(id.index()) {
            *references = references.saturating_add(1);
        }
    }

    /// Removes a reference to a page, and frees it if that was the last.
    pub(crate) fn release(&mut self, id: PageId) {
        if let Some(references) = self.references.get_mut(id.index())
            && *references > 0
        {
            *references -= 1;
            if *references == 0 {
                self.put_back(id);
            }
        }
    }

    /// Changes the reference count of a page, for an audit that restores it.
    pub(crate) fn recount(&mut self, id: PageId, change: fn(u16) -> u16) {
        if let Some(references) = self.references.get_mut(id.index()) {
            *references = change(*references);
        }
    }

    /// Whether all reference counts are zero, after the audit has removed the references of all maps.
    pub(crate) fn is_accounted_for(&self) -> bool {
        self.references.iter().all(|&references| references == 0)
    }

    /// Whether the list of free pages has each page without references exactly once.
    pub(crate) fn free_is_sound(&mut self) -> bool {
        // Greater than any valid count.
        const COUNTED: u16 = u16::MAX;
        let unheld = self.references.iter().filter(|&&references| references == 0).count();
        let mut distinct = 0;
        for id in self.free.iter().take(usize::from(*self.free_len)) {
            if let Some(references) = self.references.get_mut(id.index()).filter(|references| **references == 0) {
                *references = COUNTED;
                distinct += 1;
            }
        }
        for references in self.references.iter_mut().filter(|references| **references == COUNTED) {
            *references = 0;
        }
        distinct == usize::from(*self.free_len) && distinct == unheld
    }

    /// All data except the pages that a memory fault may change.
    #[cfg(any(test, feature = "flips"))]
    pub(crate) fn words(&mut self) -> impl Iterator<Item = &mut u16> {
        let free = self.free.iter_mut().map(|id| &mut id.0);
        self.references.iter_mut().chain(free).chain(core::iter::once(&mut *self.free_len))
    }

    /// A page that a map holds.
    pub(crate) fn held(&mut self, index: usize) -> Option<&mut Page<F>> {
        let references = self.references.get(index).copied().unwrap_or(0);
        self.pages.get_mut(index).filter(|_| references > 0)
    }

    /// Sets the list of free pages to the pages without references.
    pub(crate) fn free_what_nobody_holds(&mut self) {
        *self.free_len = 0;
        for index in (0..self.pages.len()).rev() {
            if self.references.get(index) == Some(&0) {
                self.put_back(PageId(index as u16));
            }
        }
    }

    /// Hands over the reference counts as scratch with one element for each page, until [`recount_all`](Self::recount_all).
    pub(crate) fn lend_counts(&mut self) -> &'s mut [u16] {
        core::mem::take(&mut self.references)
    }

    /// Takes the counts back, and recomputes them from the page lists of all maps.
    pub(crate) fn recount_all<'i>(&mut self, counts: &'s mut [u16], held: impl Iterator<Item = &'i PageId>) {
        self.references = counts;
        self.references.fill(0);
        held.for_each(|&id| self.share(id));
    }

    /// The page that was the allocation `number` since [`clear`](Self::clear), if none was freed since.
    pub(crate) fn taken(&self, number: u32) -> Option<PageId> {
        let taken = (number as usize) < self.pages.len() - self.free();
        taken.then_some(PageId(number as u16))
    }

    /// Number of maps that hold this page.
    pub(crate) fn references(&self, id: PageId) -> u16 {
        self.references.get(id.index()).copied().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::PoolMemory;
    use crate::{Component, Static};
    use nalgebra::Vector2;
    use std::vec::Vec;

    #[test]
    fn pages_without_references_are_free_again() {
        let mut memory = PoolMemory::<Static<Vector2<f32>>, 3>::ZERO;
        let mut pool = memory.view();
        assert!(pool.take().is_none());
        pool.clear();
        let ids: Vec<_> = (0..3).map(|_| pool.take().unwrap().0).collect();
        assert!(pool.take().is_none());
        pool.share(ids[1]);
        pool.release(ids[1]);
        assert_eq!((pool.free(), pool.references(ids[1])), (0, 1));
        pool.release(ids[1]);
        assert_eq!(pool.free(), 1);
        // Releasing a page without references changes nothing.
        pool.release(ids[1]);
        assert_eq!(pool.free(), 1);
        assert_eq!(pool.take().unwrap().0, ids[1]);
    }

    #[test]
    fn a_page_has_the_bounding_box_of_its_components() {
        let mut memory = PoolMemory::<Static<Vector2<f32>>, 1>::ZERO;
        let mut pool = memory.view();
        pool.clear();
        let at = |x, y| Component { mean: Vector2::new(x, y), ..Component::ZERO };
        let (id, page) = pool.take().unwrap();
        page.fill([at(1.0, 5.0), at(-2.0, 7.0)].iter());
        let page = pool.get(id).unwrap();
        assert_eq!(page.components().len(), 2);
        assert_eq!((page.bounds().low, page.bounds().high), (Vector2::new(-2.0, 5.0), Vector2::new(1.0, 7.0)));
    }
}
