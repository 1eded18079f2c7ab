//! Consistency of pool and tables.

use crate::map::{Maps, Page, Pool};
use crate::{Feature, Flaw, Real, Vector};

impl<T: Real, F: Feature<Position: Vector<Scalar = T>>> Maps<'_, F> {
    /// Every page is held by as many maps as its count says, and is free if and only if none holds it; every component held is
    /// sound. Linear in maps and pages; the counts are changed on the way, and put back.
    pub(crate) fn audit(&mut self, particles: usize) -> Result<(), Flaw> {
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
        if !(lists_fit && accounted && pool.free_is_sound()) {
            return Err(Flaw::Pages);
        }
        if pool.held_mut().all(|page| page.is_sound()) { Ok(()) } else { Err(Flaw::Component) }
    }
}

impl<T: Real, F: Feature<Position: Vector<Scalar = T>>> Page<F> {
    /// Whether every component is finite and positive definite, lies in the box, and has the weight that its logarithm says.
    fn is_sound(&self) -> bool {
        self.weighted().all(|(component, weight)| {
            component.ln_weight.is_finite()
                && weight == component.ln_weight.exp()
                && component.mean.as_slice().iter().all(|coordinate| coordinate.is_finite())
                && component.covariance.factor().is_some()
                && self.bounds().holds(&component.position())
        })
    }
}
