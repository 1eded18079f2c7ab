//! The part of a map near the vehicle.

use super::{MapTable, Maps, Pool};
use crate::{Bounds, Component, Feature, Place, Real};

/// The components of a particle's map within `bounds`. Takes table and pool, so that the workspace can be borrowed elsewhere.
pub(crate) fn on_pages_within<'m, F: Feature>(
    (table, pool): (&'m MapTable<'_, F::Position>, &'m Pool<'_, F>),
    particle: usize,
    bounds: &'m Bounds<F::Position>,
) -> impl Iterator<Item = &'m Component<F::State>> {
    let pages = table.pages_near(particle, bounds).iter().filter_map(|&id| pool.get(id));
    let components = pages.filter(|page| page.bounds().meets(bounds)).flat_map(|page| page.components());
    components.filter(|component| bounds.holds(&component.position()))
}

/// Calls `visit` for the components of a particle's map within `bounds`, with their weights.
#[inline(always)]
pub(crate) fn for_each_within<T: Real, F: Feature<Position: Place<Scalar = T>>>(
    maps: &Maps<'_, F>,
    particle: usize,
    bounds: &Bounds<F::Position>,
    mut visit: impl FnMut(&Component<F::State>, T),
) {
    for &id in maps.table.pages_near(particle, bounds) {
        let Some(page) = maps.pool.get(id).filter(|page| page.bounds().meets(bounds)) else { continue };
        let within = bounds.covers(page.bounds());
        for (component, weight) in page.weighted() {
            if within || bounds.holds(&component.position()) {
                visit(component, weight);
            }
        }
    }
}
