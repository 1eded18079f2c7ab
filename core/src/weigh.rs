//! Weighing: how well a candidate pose explains the scan (4.51, 4.52).

use crate::likelihood::{Likelihood, ln_likelihood};
use crate::map::Maps;
use crate::reduce::heavier;
use crate::scan::Scan;
use crate::view::View;
use crate::{Bounds, Component, Dim, FieldOfView, LnSum, Packed, Real, Sensor};

/// ln L of the scan from one pose over one predicted map, and how much of the map it saw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Weighed<T> {
    /// ln L.
    pub(crate) ln_likelihood: T,
    /// |V|, the number of components in view.
    pub(crate) in_view: usize,
}

/// What one candidate sees of its map, apart from η_z.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen<T: Real, const D: usize>
where
    Dim<D>: Packed,
{
    /// Σ_{j∈V} p_D,j w_j.
    pub(crate) expected_detections: T,
    /// |V|.
    pub(crate) in_view: usize,
    /// The static component in view that comes first, heaviest first; looked for only where the likelihood needs it.
    pub(crate) heaviest: Option<Component<T, D>>,
}

impl<T: Real, const D: usize> Seen<T, D>
where
    Dim<D>: Packed,
{
    pub(crate) const NOTHING: Self = Self { expected_detections: T::ZERO, in_view: 0, heaviest: None };

    /// One more component in view, that is detected with this probability and has this weight.
    #[inline(always)]
    pub(crate) fn add(&mut self, probability: T, weight: T) {
        self.in_view += 1;
        self.expected_detections += probability * weight;
    }
}

/// ln L and |V| of one candidate of `particle`, with η_z = κ(z) + Σ w_b + Σ_{j∈V} p_D,j w_j N(z; ẑ_j, S_j) (4.51, 5.19).
///
/// Reads the map and writes nothing but `eta`, its scratch, so that candidates can be weighed in any order or at once.
pub(crate) fn weigh<T, S, V, F, const D: usize, const E: usize, const Z: usize>(
    view: &View<'_, T, S, V, F>,
    particle: usize,
    (still, moving): (&Maps<'_, T, D, D>, &Maps<'_, T, E, D>),
    scan: &Scan<'_, T, Z>,
    likelihood: Likelihood,
    eta: &mut [LnSum<T>],
) -> Weighed<T>
where
    T: Real,
    S: Sensor<T, D, Z, Frame = F>,
    V: FieldOfView<T, F, D, Z>,
    Dim<D>: Packed,
    Dim<E>: Packed,
    Dim<Z>: Packed,
{
    reset_eta(eta, scan);
    let bounds = view.bounds();
    let mut seen = Seen::NOTHING;
    look_within(still, particle, &bounds, |component, weight| {
        let in_view = look_at(view, component, weight, scan, eta, &mut seen);
        if in_view && likelihood == Likelihood::SingleFeature {
            seen.heaviest = Some(seen.heaviest.filter(|held| heavier(held, component)).unwrap_or(*component));
        }
    });
    for (_, birth) in view.expected_births() {
        look_at(view, &birth, birth.ln_weight.exp(), scan, eta, &mut seen);
    }
    look_within(moving, particle, &bounds, |component, weight| {
        look_at(view, component, weight, scan, eta, &mut seen);
    });
    let ln_likelihood = ln_likelihood(likelihood, view, &seen, scan, eta);
    #[cfg(feature = "multi-feature")]
    let ln_likelihood = if likelihood == Likelihood::MultiFeature {
        ln_likelihood + crate::multi_feature::ln_beyond_empty(view, particle, still, scan, eta)
    } else {
        ln_likelihood
    };
    Weighed { ln_likelihood, in_view: seen.in_view }
}

/// Sets every η_z to κ(z) + Σ w_b, what it is where no feature is near.
pub(crate) fn reset_eta<T: Real, const Z: usize>(eta: &mut [LnSum<T>], scan: &Scan<'_, T, Z>) {
    for (eta, measurement) in eta.iter_mut().zip(scan.iter()) {
        *eta = LnSum::of(measurement.ln_unexplained);
    }
}

/// The components of a particle's map within `bounds`.
pub(crate) fn within<'m, T: Real, const N: usize, const D: usize>(
    maps: &'m Maps<'_, T, N, D>,
    particle: usize,
    bounds: &'m Bounds<T, D>,
) -> impl Iterator<Item = &'m Component<T, N>>
where
    Dim<N>: Packed,
{
    let pages = maps.table.pages_near(particle, bounds).iter().filter_map(|&id| maps.pool.get(id));
    let components = pages.filter(|page| page.bounds().meets(bounds)).flat_map(|page| page.components());
    components.filter(|component| bounds.holds(&component.position()))
}

/// Shows `look` the same components, each with its weight.
#[inline(always)]
fn look_within<T: Real, const N: usize, const D: usize>(
    maps: &Maps<'_, T, N, D>,
    particle: usize,
    bounds: &Bounds<T, D>,
    mut look: impl FnMut(&Component<T, N>, T),
) where
    Dim<N>: Packed,
{
    for &id in maps.table.pages_near(particle, bounds) {
        let Some(page) = maps.pool.get(id).filter(|page| page.bounds().meets(bounds)) else { continue };
        let within = bounds.covers(page.bounds());
        for (component, weight) in page.weighted() {
            if within || bounds.holds(&component.position()) {
                look(component, weight);
            }
        }
    }
}

/// Adds the terms of a component of that weight to η_z and to what is seen; `false` where it is out of view.
#[inline(never)]
fn look_at<T, S, V, F, const N: usize, const D: usize, const Z: usize>(
    view: &View<'_, T, S, V, F>,
    component: &Component<T, N>,
    weight: T,
    scan: &Scan<'_, T, Z>,
    eta: &mut [LnSum<T>],
    seen: &mut Seen<T, D>,
) -> bool
where
    T: Real,
    S: Sensor<T, D, Z, Frame = F>,
    V: FieldOfView<T, F, D, Z>,
    Dim<N>: Packed,
    Dim<D>: Packed,
    Dim<Z>: Packed,
{
    let Some(expectation) = view.expect(component) else { return false };
    seen.add(expectation.detection.probability, weight);
    view.matches(&expectation, scan, |found| {
        if let Some(eta) = eta.get_mut(found.index) {
            eta.add(found.ln_term);
        }
    });
    true
}
