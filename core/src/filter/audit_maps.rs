//! Consistency of pool and tables.

use crate::map::{Maps, Page, Pool};
use crate::{Component, Feature, Flaw, Real, Vector};

impl<T: Real, F: Feature<Position: Vector<Scalar = T>>> Maps<'_, F> {
    /// Checks that the reference count of every page is the number of maps that hold it, that a page is free if and only if no
    /// map holds it, and that every held component is valid. The cost is linear in maps and pages. The counts are changed during
    /// the check and then restored.
    pub(crate) fn audit(&mut self, particles: usize) -> Result<(), Flaw> {
        if !self.lists_are_sound(particles) {
            return Err(Flaw::Pages);
        }
        if self.pool.held_mut().all(|page| page.is_sound()) { Ok(()) } else { Err(Flaw::Component) }
    }

    /// Repairs page lists and reference counts if they are invalid. Returns whether they were. Invalid pages are removed from the
    /// lists.
    pub(crate) fn mend_lists(&mut self, particles: usize) -> bool {
        if self.lists_are_sound(particles) {
            return false;
        }
        let Self { table, pool, .. } = self;
        table.mend(particles, pool.capacity());
        let counts = pool.lend_counts();
        pool.recount_all(counts, (0..particles).flat_map(|map| table.pages(map)));
        pool.free_what_nobody_holds();
        true
    }

    fn lists_are_sound(&mut self, particles: usize) -> bool {
        let Self { table, pool, .. } = self;
        let lists_fit = table.has_rows_for(particles);
        let count = |pool: &mut Pool<'_, F>, change: fn(u16) -> u16| {
            for map in 0..particles {
                table.pages(map).iter().for_each(|&id| pool.recount(id, change));
            }
        };
        count(pool, |references| references.wrapping_sub(1));
        let accounted = pool.is_accounted_for();
        count(pool, |references| references.wrapping_add(1));
        lists_fit && accounted && pool.free_is_sound()
    }
}

impl<T: Real, F: Feature<Position: Vector<Scalar = T>>> Pool<'_, F> {
    /// Removes invalid components from a page that a map holds, and recomputes its weights and bounding box. Returns whether this
    /// was necessary.
    pub(crate) fn mend_page(&mut self, index: usize) -> bool {
        let Some(page) = self.held(index).filter(|page| !page.is_sound()) else { return false };
        page.change(|component| is_sound(component).then_some(*component));
        true
    }
}

/// Whether a component is finite and its covariance positive definite.
fn is_sound<T: Real, N: Vector<Scalar = T>>(component: &Component<N>) -> bool {
    component.ln_weight.is_finite()
        && component.mean.as_slice().iter().all(|coordinate| coordinate.is_finite())
        && component.covariance.factor().is_some()
}

impl<T: Real, F: Feature<Position: Vector<Scalar = T>>> Page<F> {
    /// Whether every component is finite and positive definite, lies in the bounding box, and has a stored weight that agrees
    /// with its logarithm.
    fn is_sound(&self) -> bool {
        self.weighted().all(|(component, weight)| {
            is_sound(component) && weight == component.ln_weight.exp() && self.bounds().holds(&component.position())
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::map::{MapMemory, Maps};
    use crate::{Component, MapStorage, Static, Symmetric};
    use nalgebra::Vector2;
    use std::collections::{BTreeSet, VecDeque};
    use std::vec::Vec;

    type Position = Vector2<f32>;
    type Small = MapMemory<Static<Position>, 3, 4, 2, 8>;

    /// An operation on three maps of up to two pages each, in a pool of four pages.
    #[derive(Debug, Clone, Copy, PartialEq)]
    enum Operation {
        /// Adds a page.
        Grow(usize),
        /// The second map becomes a copy of the first; the pages that it had are released.
        Share(usize, usize),
        /// Releases all pages of a map.
        Release(usize),
        /// Rewrites a map to new pages.
        Write(usize),
    }

    fn all() -> Vec<Operation> {
        let maps = || 0..3;
        let pairs = maps().flat_map(|one| maps().filter(move |&other| other != one).map(move |other| (one, other)));
        let alone = [Operation::Grow as fn(usize) -> Operation, Operation::Release, Operation::Write];
        let alone = alone.into_iter().flat_map(|of| maps().map(of));
        alone.chain(pairs.map(|(from, to)| Operation::Share(from, to))).collect()
    }

    fn grow(maps: &mut Maps<'_, Static<Position>>, map: usize) {
        if maps.table.pages(map).len() == maps.table.map_pages() {
            return;
        }
        let Some((id, page)) = maps.pool.take() else { return };
        let component = Component { covariance: Symmetric::from_diagonal([1.0; 2]), ..Component::ZERO };
        page.fill(core::iter::once(&component));
        assert!(maps.table.push(map, id));
    }

    fn perform(maps: &mut Maps<'_, Static<Position>>, operation: Operation) {
        match operation {
            Operation::Grow(map) => grow(maps, map),
            Operation::Share(from, to) => {
                maps.table.release(to, &mut maps.pool);
                maps.table.share(from, to, &mut maps.pool);
            }
            Operation::Release(map) => maps.table.release(map, &mut maps.pool),
            Operation::Write(map) => {
                let pages = maps.table.pages(map).len();
                maps.table.release(map, &mut maps.pool);
                (0..pages).for_each(|_| grow(maps, map));
            }
        }
    }

    /// Explores all reachable states (page lists and free pages): after every operation, every page is accounted for.
    #[test]
    fn of_a_small_pool_every_state_is_sound() {
        let state = |maps: &Maps<'_, Static<Position>>| -> Vec<Vec<usize>> {
            (0..3).map(|map| maps.table.pages(map).iter().map(|id| id.index()).collect()).collect()
        };
        let mut met: BTreeSet<(Vec<Vec<usize>>, usize)> = BTreeSet::new();
        // Breadth first.
        let mut ways: VecDeque<Vec<Operation>> = VecDeque::from([Vec::new()]);
        let mut performed = 0_usize;
        while let Some(way) = ways.pop_front() {
            for operation in all() {
                let mut memory = Small::ZERO;
                let mut maps = memory.maps();
                maps.clear();
                way.iter().for_each(|&before| perform(&mut maps, before));
                perform(&mut maps, operation);
                performed += 1;
                assert_eq!(maps.audit(3), Ok(()), "{way:?} {operation:?}");
                let used: BTreeSet<usize> = state(&maps).concat().into_iter().collect();
                assert_eq!(maps.pool.free(), 4 - used.len(), "{way:?} {operation:?}");
                if met.insert((state(&maps), maps.pool.free())) {
                    ways.push_back([&way[..], &[operation]].concat());
                }
            }
        }
        assert!(met.len() > 100 && performed > 1000, "{} states, {performed} operations", met.len());
    }
}
