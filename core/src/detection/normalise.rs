//! Division of the weights of detections and births by η_z.

use crate::detection::scan::Scan;
use crate::{LnSum, Real, Vector};

/// For every measurement of a scan its normaliser, ( κ(z) + Σ w_b ) / η_z: by how much features lower the weight of whatever explains
/// it. Weights were taken relative to the numerator while η_z was summed up.
#[derive(Debug)]
pub(crate) struct Normalisers<'m, T> {
    /// Sums of one term each, in the memory of the η_z.
    each: &'m [LnSum<T>],
}

impl<'m, T: Real> Normalisers<'m, T> {
    /// Of complete η_z, whose memory they take over.
    pub(crate) fn of<Z: Vector<Scalar = T>>(eta: &'m mut [LnSum<T>], scan: &Scan<'_, Z>) -> Self {
        for (slot, measurement) in eta.iter_mut().zip(scan.iter()) {
            *slot = LnSum::of(measurement.ln_reference() - slot.ln());
        }
        Self { each: eta }
    }

    /// ln of a measurement's; of none, that of weight zero.
    pub(crate) fn ln(&self, measurement: usize) -> T {
        self.each.get(measurement).map_or(T::NEG_INFINITY, LnSum::ln)
    }

    /// ln of each, in the order of the scan.
    pub(crate) fn each_ln(&self) -> impl Iterator<Item = T> {
        self.each.iter().map(LnSum::ln)
    }
}
