//! The single-cluster likelihood of a scan (4.52).

use crate::detection::scan::Scan;
use crate::detection::seen::Seen;
use crate::numerics::ln_sum::ln_product;
use crate::{LnSum, Real, Vector};

/// ln L of the scan, up to the clutter rate λ, from the expected detections of a candidate and the complete η_z. Not inlined,
/// because several callers share it and its code is large.
#[inline(never)]
pub(crate) fn ln_likelihood<T: Real, Z: Vector<Scalar = T>>(seen: &Seen<T>, scan: &Scan<'_, Z>, eta: &[LnSum<T>]) -> T {
    ln_product(scan.iter().zip(eta).map(|(_, eta)| eta)) - seen.expected_detections
}
