//! Weighing: how well a candidate pose explains the scan (4.51, 4.52).

use crate::likelihood::{Likelihood, ln_likelihood};
use crate::map::{DynamicMaps, Maps, StaticMaps};
use crate::reduce::heavier;
use crate::scan::Scan;
use crate::view::View;
use crate::{Bounds, Component, Feature, LnSum, MeasurementModel, Place, Pose, PositionOf, Real, Vector};

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
pub(crate) struct Seen<D: Vector> {
    /// Σ_{j∈V} p_D,j w_j.
    pub(crate) expected_detections: D::Scalar,
    /// |V|.
    pub(crate) in_view: usize,
    /// The static component in view that comes first, heaviest first; looked for only where the likelihood needs it.
    pub(crate) heaviest: Option<Component<D>>,
}

impl<T: Real, D: Vector<Scalar = T>> Seen<D> {
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
pub(crate) fn weigh<T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>>>(
    view: &View<'_, X>,
    particle: usize,
    (still, moving): (&StaticMaps<'_, X::Pose>, &DynamicMaps<'_, X::Pose>),
    scan: &Scan<'_, X::Measurement>,
    likelihood: Likelihood,
    eta: &mut [LnSum<T>],
) -> Weighed<T> {
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
pub(crate) fn reset_eta<T: Real, Z: Vector<Scalar = T>>(eta: &mut [LnSum<T>], scan: &Scan<'_, Z>) {
    for (eta, measurement) in eta.iter_mut().zip(scan.iter()) {
        *eta = LnSum::of(measurement.ln_unexplained);
    }
}

/// The components of a particle's map within `bounds`.
pub(crate) fn within<'m, F: Feature>(
    maps: &'m Maps<'_, F>,
    particle: usize,
    bounds: &'m Bounds<F::Position>,
) -> impl Iterator<Item = &'m Component<F::State>> {
    let pages = maps.table.pages_near(particle, bounds).iter().filter_map(|&id| maps.pool.get(id));
    let components = pages.filter(|page| page.bounds().meets(bounds)).flat_map(|page| page.components());
    components.filter(|component| bounds.holds(&component.position()))
}

/// Shows `look` the same components, each with its weight.
#[inline(always)]
fn look_within<T: Real, F: Feature<Position: Place<Scalar = T>>>(
    maps: &Maps<'_, F>,
    particle: usize,
    bounds: &Bounds<F::Position>,
    mut look: impl FnMut(&Component<F::State>, T),
) {
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
fn look_at<T: Real, N: Vector<Scalar = T>, X: MeasurementModel<Pose: Pose<Scalar = T>>>(
    view: &View<'_, X>,
    component: &Component<N>,
    weight: T,
    scan: &Scan<'_, X::Measurement>,
    eta: &mut [LnSum<T>],
    seen: &mut Seen<PositionOf<X::Pose>>,
) -> bool {
    let Some(expectation) = view.expect(component) else { return false };
    seen.add(expectation.detection.probability, weight);
    view.matches(&expectation, scan, |found| {
        if let Some(eta) = eta.get_mut(found.index) {
            eta.add(found.ln_term);
        }
    });
    true
}
