//! The particle likelihood: how well a candidate pose explains the scan (4.52).

use crate::map::{PageId, Pool};
use crate::scan::Scan;
use crate::view::View;
use crate::{Dim, FieldOfView, LnSum, Packed, Real, Sensor};

/// ln L of the scan from one pose over one predicted map, and how much of the map it saw.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weighed<T> {
    /// ln L.
    pub(crate) ln_likelihood: T,
    /// |V|, the number of components in view.
    pub(crate) in_view: usize,
}

/// ln L = −Σ_{j∈V} p_D,j w_j + Σ_z ln η_z with η_z = κ(z) + B w_b + Σ_{j∈V} p_D,j w_j N(z; ẑ_j, S_j) (4.52, 4.51, 5.19).
///
/// Reads the map and writes nothing but `eta`, its scratch, so that candidates can be weighed in any order or at once.
pub(crate) fn weigh<T, S, V, F, const N: usize, const D: usize, const Z: usize>(
    view: &View<'_, T, S, V, F>,
    pages: &[PageId],
    pool: &Pool<'_, T, N, D>,
    scan: &Scan<'_, T, Z>,
    eta: &mut [LnSum<T>],
) -> Weighed<T>
where
    T: Real,
    S: Sensor<T, D, Z, Frame = F>,
    V: FieldOfView<T, F, D, Z>,
    Dim<N>: Packed,
    Dim<D>: Packed,
    Dim<Z>: Packed,
{
    reset_eta(eta, scan);
    let bounds = view.bounds();
    let mut expected_detections = T::ZERO;
    let mut in_view = 0;
    for page in pages.iter().filter_map(|&id| pool.get(id)).filter(|page| page.bounds().meets(&bounds)) {
        for component in page.components() {
            let Some(expectation) = view.expect(component) else { continue };
            in_view += 1;
            expected_detections += expectation.ln_detected_weight.exp();
            view.matches(&expectation, scan, |found| {
                if let Some(eta) = eta.get_mut(found.index) {
                    eta.add(found.ln_term);
                }
            });
        }
    }
    let explained = eta.iter().take(scan.len()).fold(T::ZERO, |sum, eta| sum + eta.ln());
    Weighed { ln_likelihood: explained - expected_detections, in_view }
}

/// Sets every η_z to κ(z) + B w_b, what it is where no feature is near.
pub(crate) fn reset_eta<T: Real, const Z: usize>(eta: &mut [LnSum<T>], scan: &Scan<'_, T, Z>) {
    for (eta, measurement) in eta.iter_mut().zip(scan.iter()) {
        *eta = LnSum::of(measurement.ln_unexplained);
    }
}
