//! Consistency of pool and tables.

use crate::map::{Maps, Page, Pool};
use crate::{Component, Feature, Flaw, Real, Vector};

impl<T: Real, F: Feature<Position: Vector<Scalar = T>>> Maps<'_, F> {
    /// Every page is held by as many maps as its count says, and is free if and only if none holds it; every component held is
    /// sound. Linear in maps and pages; the counts are changed on the way, and put back.
    pub(crate) fn audit(&mut self, particles: usize) -> Result<(), Flaw> {
        if !self.lists_are_sound(particles) {
            return Err(Flaw::Pages);
        }
        if self.pool.held_mut().all(|page| page.is_sound()) { Ok(()) } else { Err(Flaw::Component) }
    }

    /// Puts lists and counts right where they are not sound: whether they were not. Pages that a list cannot have are left out of it.
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
    /// Drops what is not sound from a page that some map holds, and works out its weights and its box again; whether there was need to.
    pub(crate) fn mend_page(&mut self, index: usize) -> bool {
        let Some(page) = self.held(index).filter(|page| !page.is_sound()) else { return false };
        page.change(|component| is_sound(component).then_some(*component));
        true
    }
}

/// Whether a component may be one.
fn is_sound<T: Real, N: Vector<Scalar = T>>(component: &Component<N>) -> bool {
    component.ln_weight.is_finite()
        && component.mean.as_slice().iter().all(|coordinate| coordinate.is_finite())
        && component.covariance.factor().is_some()
}

impl<T: Real, F: Feature<Position: Vector<Scalar = T>>> Page<F> {
    /// Whether every component is finite and positive definite, lies in the box, and has the weight that its logarithm says.
    fn is_sound(&self) -> bool {
        self.weighted().all(|(component, weight)| {
            is_sound(component) && weight == component.ln_weight.exp() && self.bounds().holds(&component.position())
        })
    }
}
