//! Weighing: how well a candidate pose explains the scan (4.51, 4.52).

use crate::detection::explain::ln_likelihood;
use crate::detection::maps::{DynamicMaps, StaticMaps};
use crate::detection::scan::Scan;
use crate::detection::seen::{Seen, Weighed, reset_eta};
use crate::detection::view::View;
use crate::map::look_within;
use crate::map::reduce::heavier;
use crate::{Component, Likelihood, LnSum, MeasurementModel, Pose, PositionOf, Real, Vector};

/// ln L and |V| of one candidate of `particle`, with η_z = κ(z) + Σ w_b + Σ_{j∈V} p_D,j w_j N(z; ẑ_j, S_j) (4.51, 5.19).
///
/// Reads the map and writes nothing but `eta`, its scratch, so that candidates can be weighed in any order or at once.
pub(crate) fn weigh<T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>>>(
    view: &View<'_, X>,
    particle: usize,
    (static_maps, moving_maps): (&StaticMaps<'_, X::Pose>, &DynamicMaps<'_, X::Pose>),
    scan: &Scan<'_, X::Measurement>,
    likelihood: Likelihood,
    eta: &mut [LnSum<T>],
) -> Weighed<T> {
    reset_eta(eta, scan);
    let bounds = view.bounds();
    let mut seen = Seen::beside(view.missed);
    look_within(static_maps, particle, &bounds, |component, weight| {
        let in_view = look_at(view, component, weight, scan, eta, &mut seen);
        if in_view && likelihood == Likelihood::SingleFeature {
            seen.heaviest = Some(seen.heaviest.filter(|held| heavier(held, component)).unwrap_or(*component));
        }
    });
    for (_, birth) in view.expected_births() {
        look_at(view, &birth, birth.ln_weight.exp(), scan, eta, &mut seen);
    }
    look_within(moving_maps, particle, &bounds, |component, weight| {
        look_at(view, component, weight, scan, eta, &mut seen);
    });
    let ln_likelihood = ln_likelihood(likelihood, view, &seen, scan, eta);
    #[cfg(feature = "multi-feature")]
    let ln_likelihood = if likelihood == Likelihood::MultiFeature {
        ln_likelihood + crate::detection::multi_feature::ln_beyond_empty(view, particle, static_maps, scan, eta)
    } else {
        ln_likelihood
    };
    Weighed { ln_likelihood, in_view: seen.in_view }
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
