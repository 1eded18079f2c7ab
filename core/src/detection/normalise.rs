//! Division of the weights of detections and births by η_z.

use crate::detection::scan::Scan;
use crate::{LnSum, Real, Vector};

/// The normaliser of every measurement of a scan, ( κ(z) + Σ w_b ) / η_z, by which features reduce the weights of detections and
/// births. While η_z was summed up, these weights were relative to the numerator.
#[derive(Debug)]
pub(crate) struct Normalisers<'m, T> {
    /// Sums of one term each, in the memory of η_z.
    each: &'m [LnSum<T>],
}

impl<'m, T: Real> Normalisers<'m, T> {
    /// The normalisers for complete η_z, in the same memory.
    pub(crate) fn of<Z: Vector<Scalar = T>>(eta: &'m mut [LnSum<T>], scan: &Scan<'_, Z>) -> Self {
        for (slot, measurement) in eta.iter_mut().zip(scan.iter()) {
            *slot = LnSum::of(measurement.ln_reference() - slot.ln());
        }
        Self { each: eta }
    }

    /// ln of a measurement's normaliser; −∞ for an index out of range.
    pub(crate) fn ln(&self, measurement: usize) -> T {
        self.each.get(measurement).map_or(T::NEG_INFINITY, LnSum::ln)
    }

    /// ln of every normaliser, in the order of the scan.
    pub(crate) fn each_ln(&self) -> impl Iterator<Item = T> {
        self.each.iter().map(LnSum::ln)
    }
}
