//! Weighting: the likelihood of the scan given a candidate pose (4.51, 4.52).

use crate::detection::explain::ln_likelihood;
use crate::detection::maps::{DynamicMaps, StaticMaps};
use crate::detection::scan::Scan;
use crate::detection::seen::{Seen, Weighed, reset_eta};
use crate::detection::view::View;
use crate::map::for_each_within;
use crate::{Component, LnSum, MeasurementModel, Pose, Real, Vector};

/// ln L and |V| of one candidate of `particle`, with η_z = κ(z) + Σ w_b + Σ_{j∈V} p_D,j w_j N(z; ẑ_j, S_j) (4.51, 5.19).
///
/// Reads the maps and writes only `eta`, so that candidates can be weighted in any order or in parallel.
pub(crate) fn weigh<T: Real, X: MeasurementModel<Pose: Pose<Scalar = T>>>(
    view: &View<'_, X>,
    particle: usize,
    (static_maps, moving_maps): (&StaticMaps<'_, X::Pose>, &DynamicMaps<'_, X::Pose>),
    scan: &Scan<'_, X::Measurement>,
    eta: &mut [LnSum<T>],
) -> Weighed<T> {
    reset_eta(eta, scan);
    let bounds = view.bounds();
    let mut seen = Seen::with_missed(view.missed);
    for_each_within(static_maps, particle, &bounds, |component, weight| {
        add_component(view, component, weight, scan, eta, &mut seen);
    });
    for (_, birth) in view.expected_births() {
        add_component(view, &birth, birth.ln_weight.exp(), scan, eta, &mut seen);
    }
    for_each_within(moving_maps, particle, &bounds, |component, weight| {
        add_component(view, component, weight, scan, eta, &mut seen);
    });
    Weighed { ln_likelihood: ln_likelihood(&seen, scan, eta), in_view: seen.in_view }
}

/// Adds a component with this weight to η_z and to the expected detections, unless it is out of view.
#[inline(never)]
fn add_component<T: Real, N: Vector<Scalar = T>, X: MeasurementModel<Pose: Pose<Scalar = T>>>(
    view: &View<'_, X>,
    component: &Component<N>,
    weight: T,
    scan: &Scan<'_, X::Measurement>,
    eta: &mut [LnSum<T>],
    seen: &mut Seen<T>,
) {
    let Some(expectation) = view.expect(component) else { return };
    seen.add(expectation.detection.probability, weight);
    view.matches(&expectation, scan, |found| {
        if let Some(eta) = eta.get_mut(found.index) {
            eta.add(found.ln_term);
        }
    });
}
