//! The report of a scan with several hypotheses.

use super::super::report::JointReport;

/// Result of a scan of a [`MultiHypothesisSlam`](super::MultiHypothesisSlam).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct HypothesesReport<T> {
    /// The report of the likeliest hypothesis. Its `ln_evidence` is that of all hypotheses together.
    pub joint: JointReport<T>,
    /// Hypotheses after the scan.
    pub hypotheses: usize,
    /// Probability of the likeliest.
    pub share: T,
    /// Hypotheses that were joined with another one.
    pub joined: usize,
    /// Measurements with a likely child for which there was no room.
    pub saturated: usize,
}
