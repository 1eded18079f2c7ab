//! Which landmark a detection is of.

/// How detections are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Association {
    /// By the nearest landmark within a gate; what is far from all is a new one.
    NearestNeighbour,
    /// By the log's label columns, with the covariance in invariant error coordinates: a bound on what any association can reach,
    /// never an estimate of it.
    Known,
}

/// χ² of two degrees of freedom that one detection in 365 exceeds by chance (three standard deviations in one dimension).
pub(super) const GATE: f64 = 11.8;
/// Squared distance to every landmark above which a detection is of a new one. What lies between is left out.
pub(super) const NEW: f64 = 30.0;
/// A landmark that was seen fewer times than this …
pub(super) const FEWEST_SIGHTS: u32 = 3;
/// … within so many scans of its first was clutter.
pub(super) const PROBATION_SCANS: usize = 40;
/// Scans between two looks for clutter.
pub(super) const CLEANING_SCANS: usize = 20;
