//! The single-cluster likelihood of a scan (4.52).

use crate::detection::scan::Scan;
use crate::detection::seen::Seen;
use crate::numerics::ln_sum::ln_product;
use crate::{LnSum, Real, Vector};

/// ln L of the scan, up to the clutter rate λ, from what the candidate saw and the complete η_z. Once for all who ask: it is not small.
#[inline(never)]
pub(crate) fn ln_likelihood<T: Real, Z: Vector<Scalar = T>>(seen: &Seen<T>, scan: &Scan<'_, Z>, eta: &[LnSum<T>]) -> T {
    ln_product(scan.iter().zip(eta).map(|(_, eta)| eta)) - seen.expected_detections
}
