//! The components of its map that one candidate has in view.

use crate::detection::scan::Scan;
use crate::{LnSum, Real, Vector};

/// Detections that a candidate expects of its map; η_z is stored separately.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen<T> {
    /// Σ_{j∈V} p_D,j w_j.
    pub(crate) expected_detections: T,
    /// |V|.
    pub(crate) in_view: usize,
}

impl<T: Real> Seen<T> {
    pub(crate) const NOTHING: Self = Self { expected_detections: T::ZERO, in_view: 0 };

    /// No component in view, but Σ p_D w of the delayed births that the scan has missed.
    pub(crate) fn with_missed(missed: T) -> Self {
        Self { expected_detections: missed, ..Self::NOTHING }
    }

    /// Adds a component in view with this probability of detection and weight.
    #[inline(always)]
    pub(crate) fn add(&mut self, probability: T, weight: T) {
        self.in_view += 1;
        self.expected_detections += probability * weight;
    }
}

/// Sets every η_z to κ(z) + Σ w_b, its value without features.
pub(crate) fn reset_eta<T: Real, Z: Vector<Scalar = T>>(eta: &mut [LnSum<T>], scan: &Scan<'_, Z>) {
    for (eta, measurement) in eta.iter_mut().zip(scan.iter()) {
        *eta = LnSum::of(measurement.ln_unexplained);
    }
}

/// ln L of the scan from one pose with its predicted map, and the number of components in view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Weighed<T> {
    /// ln L.
    pub(crate) ln_likelihood: T,
    /// |V|, the number of components in view.
    pub(crate) in_view: usize,
}
