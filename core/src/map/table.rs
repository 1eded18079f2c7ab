//! For every particle, the list of the pages of its map.
//!
//! A list is stored in a row, and an update rewrites it in place: pages out of view stay where they are, at no cost. The first
//! pages of a row are outside a box around the field of view at the time when they were last sorted; an update whose field of view
//! is inside that box skips all of them at once.

use super::{PageId, Pool};
use crate::{Bounds, Feature, Real, Vector};

/// Margin of the box `vicinity` around the view on every side, as a share of the view's extent. While the vehicle moves within
/// the margin, pages need not be sorted again, and the pages that are checked one by one meet a box of one and a half times the
/// view's extent.
pub(super) const MARGIN: f64 = 0.25;

/// The data of a row except its pages.
#[derive(Debug, Clone, Copy)]
pub struct Row<D> {
    /// Number of pages in the row.
    pub(super) len: u16,
    /// Number of pages at its beginning that do not meet `vicinity`.
    pub(super) far: u16,
    /// The box around the view for which the pages were last sorted.
    pub(super) vicinity: Bounds<D>,
}

impl<T: Real, D: Vector<Scalar = T>> Row<D> {
    /// All zero; a placeholder for unused memory.
    const ZERO: Self = Self { len: 0, far: 0, vicinity: Bounds::ZERO };
    /// A row without pages.
    pub(super) const EMPTY: Self = Self { len: 0, far: 0, vicinity: Bounds::EMPTY };
}

/// Memory of the page lists of PARTICLES maps, each of up to `MAP_PAGES` pages.
#[derive(Debug)]
pub struct MapTableMemory<D: Vector, const PARTICLES: usize, const MAP_PAGES: usize> {
    ids: [[PageId; MAP_PAGES]; PARTICLES],
    rows: [Row<D>; PARTICLES],
    row_of: [u16; PARTICLES],
    next_row_of: [u16; PARTICLES],
    free: [u16; PARTICLES],
    replaced: [PageId; MAP_PAGES],
}

impl<T: Real, D: Vector<Scalar = T>, const PARTICLES: usize, const MAP_PAGES: usize>
    MapTableMemory<D, PARTICLES, MAP_PAGES>
{
    /// All zero: every map is empty.
    pub(crate) const ZERO: Self = Self {
        ids: [[PageId::ZERO; MAP_PAGES]; PARTICLES],
        rows: [Row::ZERO; PARTICLES],
        row_of: [0; PARTICLES],
        next_row_of: [0; PARTICLES],
        free: [0; PARTICLES],
        replaced: [PageId::ZERO; MAP_PAGES],
    };

    /// The table in this memory.
    pub(crate) fn view(&mut self) -> MapTable<'_, D> {
        MapTable {
            ids: self.ids.as_flattened_mut(),
            rows: &mut self.rows,
            row_of: &mut self.row_of,
            next_row_of: &mut self.next_row_of,
            free: &mut self.free,
            free_len: 0,
            replaced: &mut self.replaced,
            replaced_len: 0,
            map_pages: MAP_PAGES,
        }
    }
}

/// Page lists of any capacity.
#[derive(Debug)]
pub struct MapTable<'s, D: Vector> {
    ids: &'s mut [PageId],
    rows: &'s mut [Row<D>],
    /// For every map, its row.
    row_of: &'s mut [u16],
    /// During an update, the rows of the updated maps.
    next_row_of: &'s mut [u16],
    /// During an update, the unused rows: the first `free_len` elements.
    free: &'s mut [u16],
    free_len: usize,
    /// During the update of a map, the pages that will be replaced.
    replaced: &'s mut [PageId],
    replaced_len: usize,
    map_pages: usize,
}

/// The rows of a table: their pages, their other data, the row of every map, and the capacity of a row.
pub(super) type Rows<'s, D> = (&'s mut [PageId], &'s mut [Row<D>], &'s mut [u16], usize);

impl<'s, D: Vector> MapTable<'s, D> {
    /// Hands over the rows until they are given back.
    pub(super) fn lend(&mut self) -> Rows<'s, D> {
        use core::mem::take;
        (take(&mut self.ids), take(&mut self.rows), take(&mut self.row_of), self.map_pages)
    }

    /// Takes the rows back.
    pub(super) fn give_back(&mut self, ids: &'s mut [PageId], rows: &'s mut [Row<D>], row_of: &'s mut [u16]) {
        (self.ids, self.rows, self.row_of) = (ids, rows, row_of);
    }
}

impl<T: Real, D: Vector<Scalar = T>> MapTable<'_, D> {
    /// A table without maps.
    pub(crate) fn none() -> Self {
        Self {
            ids: &mut [],
            rows: &mut [],
            row_of: &mut [],
            next_row_of: &mut [],
            free: &mut [],
            free_len: 0,
            replaced: &mut [],
            replaced_len: 0,
            map_pages: 0,
        }
    }

    /// Capacity of a map, pages.
    pub(crate) fn map_pages(&self) -> usize {
        self.map_pages
    }

    /// Empties every list, without releasing the pages.
    pub(crate) fn clear(&mut self) {
        self.rows.fill(Row::EMPTY);
        self.row_of.iter_mut().enumerate().for_each(|(map, row)| *row = map as u16);
    }

    /// Whether each of the first `maps` maps has a row of its own with a valid length. Also true for a table without maps.
    pub(crate) fn has_rows_for(&mut self, maps: usize) -> bool {
        if self.rows.is_empty() {
            return true;
        }
        // Between scans `next_row_of` is not in use; here it holds the rows that were found so far.
        self.next_row_of.fill(u16::MAX);
        let map_pages = self.map_pages;
        self.row_of.len() >= maps
            && self.row_of.iter().take(maps).all(|&row| {
                let Some(slot) = self.next_row_of.get_mut(usize::from(row)) else { return false };
                let met = core::mem::replace(slot, row) != u16::MAX;
                let head = self.rows.get(usize::from(row));
                !met && head.is_some_and(|head| head.far <= head.len && usize::from(head.len) <= map_pages)
            })
    }

    /// Whether this is a table without maps.
    pub(crate) fn is_none(&self) -> bool {
        self.rows.is_empty()
    }

    /// Number of pages at the beginning of a map that are outside a box, and that box.
    pub(crate) fn far(&self, map: usize) -> (usize, Bounds<D>) {
        self.rows.get(self.row(map)).map_or((0, Bounds::EMPTY), |row| (usize::from(row.far), row.vicinity))
    }

    /// Sets the number of pages at the beginning of a map that are outside a box, limited to the length of the map.
    pub(crate) fn set_far(&mut self, map: usize, far: usize, vicinity: Bounds<D>) {
        let row = self.row(map);
        if let Some(row) = self.rows.get_mut(row) {
            (row.far, row.vicinity) = (far.min(usize::from(row.len)) as u16, vicinity);
        }
    }

    /// All data that a memory fault may change, except the boxes.
    #[cfg(any(test, feature = "flips"))]
    pub(crate) fn words(&mut self) -> impl Iterator<Item = &mut u16> {
        let heads = self.rows.iter_mut().flat_map(|row| [&mut row.len, &mut row.far]);
        self.row_of.iter_mut().chain(heads).chain(self.ids.iter_mut().map(PageId::number))
    }

    /// The coordinates of the boxes.
    #[cfg(any(test, feature = "flips"))]
    pub(crate) fn corners(&mut self) -> impl Iterator<Item = &mut T> {
        let corners = self.rows.iter_mut().flat_map(|row| [&mut row.vicinity.low, &mut row.vicinity.high]);
        corners.flat_map(Vector::as_mut_slice)
    }

    /// Repairs the lists: gives each of the first `maps` maps a row of its own, and removes duplicates and invalid pages (index
    /// `pages` or above).
    pub(crate) fn mend(&mut self, maps: usize, pages: usize) {
        // As in `has_rows_for`, the rows that were found so far.
        self.next_row_of.fill(u16::MAX);
        for row in self.row_of.iter_mut().take(maps) {
            match self.next_row_of.get_mut(usize::from(*row)) {
                Some(met) if *met == u16::MAX => *met = *row,
                _ => *row = u16::MAX,
            }
        }
        let mut unmet = 0;
        for row in self.row_of.iter_mut().take(maps).filter(|row| **row == u16::MAX) {
            while self.next_row_of.get(unmet).is_some_and(|&met| met != u16::MAX) {
                unmet += 1;
            }
            *row = unmet as u16;
            if let Some(head) = self.rows.get_mut(unmet) {
                *head = Row::EMPTY;
            }
            unmet += 1;
        }
        for map in 0..maps {
            let row = self.row(map);
            let start = self.start(row);
            let Some(head) = self.rows.get_mut(row) else { continue };
            let len = usize::from(head.len).min(self.map_pages);
            let mut kept = 0;
            for place in 0..len {
                let Some(&id) = self.ids.get(start + place) else { break };
                let before = self.ids.get(start..start + kept).unwrap_or(&[]);
                if id.index() < pages && !before.contains(&id) {
                    if let Some(slot) = self.ids.get_mut(start + kept) {
                        *slot = id;
                    }
                    kept += 1;
                }
            }
            if kept < usize::from(head.len) || head.far > head.len {
                // The pages outside the box are not known any more.
                *head = Row { len: kept as u16, ..Row::EMPTY };
            }
        }
    }

    /// The pages of a map.
    #[inline]
    pub(crate) fn pages(&self, map: usize) -> &[PageId] {
        self.pages_of(self.row(map), 0)
    }

    /// The pages of a map, except those known to be outside `bounds`.
    #[inline]
    pub(crate) fn pages_near(&self, map: usize, bounds: &Bounds<D>) -> &[PageId] {
        let row = self.row(map);
        let near = self.rows.get(row).filter(|row| row.vicinity.covers(bounds));
        self.pages_of(row, near.map_or(0, |row| usize::from(row.far)))
    }

    /// Adds a page to a map, which takes over the reference; `false` if the list is full.
    pub(crate) fn push(&mut self, map: usize, id: PageId) -> bool {
        self.append(self.row(map), id)
    }

    /// Empties a map and releases its pages.
    pub(crate) fn release<F: Feature<Position = D>>(&mut self, map: usize, pool: &mut Pool<'_, F>) {
        self.pages(map).iter().for_each(|&id| pool.release(id));
        let row = self.row(map);
        if let Some(row) = self.rows.get_mut(row) {
            *row = Row::EMPTY;
        }
    }

    /// Makes map `to` share the pages of map `from`. The previous pages of `to` are not released.
    pub(crate) fn share<F: Feature<Position = D>>(&mut self, from: usize, to: usize, pool: &mut Pool<'_, F>) {
        self.copy(self.row(from), self.row(to), pool);
    }

    /// Replaces the last page of a map. The map takes over the reference to the new page, and does not release the old one.
    pub(crate) fn replace_last(&mut self, map: usize, id: PageId) {
        let row = self.row(map);
        let last = self.rows.get(row).and_then(|row| usize::from(row.len).checked_sub(1));
        let start = self.start(row);
        if let Some(slot) = last.and_then(|last| self.ids.get_mut(start.saturating_add(last))) {
            *slot = id;
        }
    }

    fn row(&self, map: usize) -> usize {
        self.row_of.get(map).copied().map_or(usize::MAX, usize::from)
    }

    #[inline]
    fn pages_of(&self, row: usize, first: usize) -> &[PageId] {
        let len = self.rows.get(row).map_or(0, |row| usize::from(row.len));
        let start = self.start(row);
        self.ids.get(start.saturating_add(first)..start.saturating_add(len)).unwrap_or(&[])
    }

    /// Index of the first page of a row; beyond the end for an invalid row.
    fn start(&self, row: usize) -> usize {
        row.saturating_mul(self.map_pages)
    }

    fn append(&mut self, row: usize, id: PageId) -> bool {
        let start = self.start(row);
        let Some(head) = self.rows.get_mut(row) else { return false };
        let place = usize::from(head.len);
        if place >= self.map_pages {
            return false;
        }
        let Some(slot) = self.ids.get_mut(start.saturating_add(place)) else { return false };
        *slot = id;
        head.len += 1;
        true
    }

    fn copy<F: Feature<Position = D>>(&mut self, from: usize, to: usize, pool: &mut Pool<'_, F>) {
        let Some(&head) = self.rows.get(from) else { return };
        let (from_start, to_start) = (self.start(from), self.start(to));
        // The standard library's copy has a panic that the compiler does not remove.
        for place in 0..usize::from(head.len) {
            let Some(&id) = self.ids.get(from_start.saturating_add(place)) else { break };
            pool.share(id);
            if let Some(slot) = self.ids.get_mut(to_start.saturating_add(place)) {
                *slot = id;
            }
        }
        if let Some(slot) = self.rows.get_mut(to) {
            *slot = head;
        }
    }
}

/// The update of a scan, map by map: [`begin`](Self::begin), [`let_go`](Self::let_go) of the maps without a survivor,
/// [`inherit`](Self::inherit) the others in ascending order, [`finish`](Self::finish).
impl<T: Real, D: Vector<Scalar = T>> MapTable<'_, D> {
    /// Finds the unused rows among the first `parents` ones: the updated maps need no more rows.
    pub(crate) fn begin(&mut self, parents: usize) {
        // The rows of updated maps are not known yet; here `next_row_of` holds the rows in use.
        let all_taken = self.next_row_of.get_mut(..parents).unwrap_or(&mut []);
        all_taken.fill(u16::MAX);
        for &row in self.row_of.iter().take(parents) {
            if let Some(taken) = all_taken.get_mut(usize::from(row)) {
                *taken = row;
            }
        }
        self.free_len = 0;
        let not_taken = all_taken.iter().enumerate().filter(|&(row, &taken)| usize::from(taken) != row);
        for ((row, _), slot) in not_taken.zip(self.free.iter_mut()) {
            *slot = row as u16;
            self.free_len += 1;
        }
    }

    /// Frees the row of a map without a survivor.
    pub(crate) fn let_go<F: Feature<Position = D>>(&mut self, parent: usize, pool: &mut Pool<'_, F>) {
        self.release(parent, pool);
        let row = self.row(parent);
        if let Some(slot) = self.free.get_mut(self.free_len) {
            *slot = row as u16;
            self.free_len += 1;
        }
    }

    /// Makes the map of `parent` that of `particle` after the update: in the same row for its last child, otherwise in a free row
    /// with one more reference to every page. A free row exists, because every parent has a child, and every row is that of a
    /// parent or a particle, or free.
    pub(crate) fn inherit<F: Feature<Position = D>>(
        &mut self,
        parent: usize,
        particle: usize,
        last_child: bool,
        pool: &mut Pool<'_, F>,
    ) {
        let row = if last_child { self.row(parent) } else { self.copied(self.row(parent), pool) };
        if let Some(slot) = self.next_row_of.get_mut(particle) {
            *slot = row as u16;
        }
    }

    /// Makes the updated map of `from` that of `to` too, in another row.
    pub(crate) fn share_updated<F: Feature<Position = D>>(&mut self, from: usize, to: usize, pool: &mut Pool<'_, F>) {
        let row = self.copied(self.next_row(from), pool);
        if let Some(slot) = self.next_row_of.get_mut(to) {
            *slot = row as u16;
        }
    }

    /// Makes the updated maps the current ones.
    pub(crate) fn finish(&mut self, particles: usize) {
        for (row, &next) in self.row_of.iter_mut().zip(self.next_row_of.iter()).take(particles) {
            *row = next;
        }
    }

    /// If the view has left the box for which the pages of an updated map were sorted, sorts the pages outside a new box to the
    /// front.
    pub(crate) fn sort_out<F: Feature<Position = D>>(&mut self, particle: usize, view: &Bounds<D>, pool: &Pool<'_, F>) {
        let row = self.next_row(particle);
        if self.rows.get(row).is_none_or(|row| row.vicinity.covers(view)) {
            return;
        }
        let vicinity = view.grown(T::from_f64(MARGIN));
        self.retain(row, 0, |id| pool.get(id).is_some_and(|page| !page.bounds().meets(&vicinity)));
        if let Some(head) = self.rows.get_mut(row) {
            *head = Row { far: head.len, vicinity, ..*head };
        }
        self.restore_replaced(particle);
    }

    /// Keeps the pages of an updated map that are known to be out of view or satisfy `keep`, and moves the others, which the update
    /// replaces, to `replaced`.
    pub(crate) fn retain_near(&mut self, particle: usize, keep: impl FnMut(PageId) -> bool) {
        let row = self.next_row(particle);
        let far = self.rows.get(row).map_or(0, |row| usize::from(row.far));
        self.retain(row, far, keep);
    }

    /// The pages that an update of a map from `view` checks, in order: those that [`sort_out`](Self::sort_out), for static
    /// features, leaves to [`retain_near`](Self::retain_near). Changes nothing.
    pub(crate) fn pages_to_update<F: Feature<Position = D>>(
        &self,
        map: usize,
        view: &Bounds<D>,
        pool: &Pool<'_, F>,
    ) -> impl Iterator<Item = PageId> {
        let row = self.row(map);
        let (far, vicinity) = self.far(map);
        let sorted_anew = (!F::MOVES && !vicinity.covers(view)).then(|| view.grown(T::from_f64(MARGIN)));
        let first = if sorted_anew.is_some() { 0 } else { far };
        self.pages_of(row, first).iter().copied().filter(move |&id| {
            let Some(vicinity) = &sorted_anew else { return true };
            pool.get(id).is_none_or(|page| page.bounds().meets(vicinity))
        })
    }

    /// Number of pages for which an updated map has room, not counting the replaced pages.
    pub(crate) fn room(&self, particle: usize) -> usize {
        self.map_pages.saturating_sub(self.pages_of(self.next_row(particle), 0).len())
    }

    /// Adds a page to an updated map.
    pub(crate) fn push_updated(&mut self, particle: usize, id: PageId) -> bool {
        self.append(self.next_row(particle), id)
    }

    /// Releases the replaced pages.
    pub(crate) fn release_replaced<F: Feature<Position = D>>(&mut self, pool: &mut Pool<'_, F>) {
        self.replaced.iter().take(self.replaced_len).for_each(|&id| pool.release(id));
        self.replaced_len = 0;
    }

    /// Returns the replaced pages to the map that they came from.
    pub(crate) fn restore_replaced(&mut self, particle: usize) {
        let row = self.next_row(particle);
        for place in 0..self.replaced_len {
            let Some(&id) = self.replaced.get(place) else { break };
            self.append(row, id);
        }
        self.replaced_len = 0;
    }

    fn next_row(&self, particle: usize) -> usize {
        self.next_row_of.get(particle).copied().map_or(usize::MAX, usize::from)
    }

    /// Copies a row to a free one. Returns its index.
    fn copied<F: Feature<Position = D>>(&mut self, row: usize, pool: &mut Pool<'_, F>) -> usize {
        self.free_len = self.free_len.saturating_sub(1);
        let copy = self.free.get(self.free_len).copied().map_or(usize::MAX, usize::from);
        self.copy(row, copy, pool);
        copy
    }

    /// Keeps the pages of a row, from index `first` on, that satisfy `keep`, and moves the others to `replaced`, in order.
    fn retain(&mut self, row: usize, first: usize, mut keep: impl FnMut(PageId) -> bool) {
        let start = self.start(row);
        let Some(head) = self.rows.get_mut(row) else { return };
        let mut kept = first;
        self.replaced_len = 0;
        for place in first..usize::from(head.len) {
            let Some(&id) = self.ids.get(start + place) else { break };
            if keep(id) {
                if let Some(slot) = self.ids.get_mut(start + kept) {
                    *slot = id;
                }
                kept += 1;
            } else if let Some(slot) = self.replaced.get_mut(self.replaced_len) {
                *slot = id;
                self.replaced_len += 1;
            }
        }
        head.len = kept as u16;
    }
}

#[cfg(test)]
mod tests {
    use super::MapTableMemory;
    use crate::map::PoolMemory;
    use crate::{Bounds, Component, Static};
    use nalgebra::Vector2;
    use std::vec::Vec;

    #[test]
    fn copies_share_pages_until_released() {
        let mut pool_memory = PoolMemory::<Static<Vector2<f32>>, 4>::ZERO;
        let mut pool = pool_memory.view();
        pool.clear();
        let mut table_memory = MapTableMemory::<Vector2<f32>, 3, 2>::ZERO;
        let mut table = table_memory.view();
        table.clear();
        let (first, second) = (pool.take().unwrap().0, pool.take().unwrap().0);
        assert!(table.push(0, first) && table.push(0, second) && !table.push(0, first));
        table.share(0, 2, &mut pool);
        assert_eq!(table.pages(2), [first, second]);
        assert_eq!((pool.free(), pool.references(first)), (2, 2));
        table.release(0, &mut pool);
        assert_eq!((table.pages(0).len(), pool.references(second), pool.free()), (0, 1, 2));
        table.release(2, &mut pool);
        assert_eq!(pool.free(), 4);
    }

    #[test]
    fn maps_without_a_survivor_make_room_for_copies_of_others() {
        let mut pool_memory = PoolMemory::<Static<Vector2<f32>>, 3>::ZERO;
        let mut pool = pool_memory.view();
        pool.clear();
        let mut table_memory = MapTableMemory::<Vector2<f32>, 3, 2>::ZERO;
        let mut table = table_memory.view();
        table.clear();
        table.begin(3);
        let ids: Vec<_> = (0..3).map(|map| (map, pool.take().unwrap().0)).collect();
        assert!(ids.iter().all(|&(map, id)| table.push(map, id)));
        let [first, second, third] = [0, 1, 2].map(|map: usize| ids[map].1);
        // The second survives twice, once with a page of its own, and the third once: 1, 1, 2.
        table.let_go(0, &mut pool);
        assert_eq!((pool.free(), pool.references(first)), (1, 0));
        table.inherit(1, 0, false, &mut pool);
        table.inherit(1, 1, true, &mut pool);
        let (own, _) = pool.take().unwrap();
        assert!(table.push_updated(1, own));
        table.inherit(2, 2, true, &mut pool);
        table.finish(3);
        assert_eq!([0, 1, 2].map(|map| table.pages(map).to_vec()), [&[second][..], &[second, own], &[third]]);
        assert_eq!([second, own, third].map(|id| pool.references(id)), [2, 1, 1]);
    }

    #[test]
    fn pages_outside_the_vicinity_are_skipped_until_the_view_moves_there() {
        let mut pool_memory = PoolMemory::<Static<Vector2<f32>>, 4>::ZERO;
        let mut pool = pool_memory.view();
        pool.clear();
        let mut table_memory = MapTableMemory::<Vector2<f32>, 1, 4>::ZERO;
        let mut table = table_memory.view();
        table.clear();
        let ids: Vec<_> = [0.0, 40.0, 1.0, 50.0]
            .map(|x| {
                let (id, page) = pool.take().unwrap();
                page.fill([Component { mean: Vector2::new(x, 0.0), ..Component::ZERO }].iter());
                id
            })
            .into_iter()
            .collect();
        assert!(ids.iter().all(|&id| table.push(0, id)));
        let view = |x| Bounds::around(&Vector2::new(x, 0.0), 10.0);
        assert_eq!(table.pages_near(0, &view(0.0)), ids, "nothing is known yet");
        let mut sort_out = |x| {
            table.inherit(0, 0, true, &mut pool);
            table.sort_out(0, &view(x), &pool);
            table.finish(1);
            [0.0, 4.0, 45.0].map(|x| table.pages_near(0, &view(x)).len())
        };
        // The margin is a quarter of 20 m on every side: a view at 4 m is within it, one at 45 m is not.
        assert_eq!(sort_out(0.0), [2, 2, 4]);
        assert_eq!(sort_out(4.0), [2, 2, 4]);
        assert_eq!(sort_out(45.0), [4, 4, 2]);
        assert_eq!(table.pages(0), [ids[0], ids[2], ids[1], ids[3]]);
        // Replaced pages can be released or returned.
        table.inherit(0, 0, true, &mut pool);
        table.retain_near(0, |id| id == ids[3]);
        assert_eq!(table.room(0), 1);
        table.restore_replaced(0);
        table.retain_near(0, |id| id == ids[3]);
        table.release_replaced(&mut pool);
        table.finish(1);
        assert_eq!(table.pages(0), [ids[0], ids[2], ids[3]]);
        assert_eq!((pool.free(), pool.references(ids[1])), (1, 0));
    }
}
