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
    /// Measurements with likely causes for which there was no room: more hypotheses would have gone on.
    pub saturated: usize,
}
