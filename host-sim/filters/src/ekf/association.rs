//! Data association of detections with landmarks.

/// Method of the data association.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Association {
    /// By the nearest landmark within a gate; a detection far from all landmarks is a new one.
    NearestNeighbour,
    /// By the log's label columns, with the covariance in invariant error coordinates: a bound for any association method, not an
    /// estimate.
    Known,
}

/// Gate: the value of χ² with two degrees of freedom that one detection in 365 exceeds by chance (three standard deviations in
/// one dimension).
pub(super) const GATE: f64 = 11.8;
/// Least squared distance of a detection from all landmarks at which it is a new one. Detections between the two are not used.
pub(super) const NEW: f64 = 30.0;
/// A landmark with fewer detections than this …
pub(super) const FEWEST_SIGHTS: u32 = 3;
/// … within this number of scans from its first one was clutter.
pub(super) const PROBATION_SCANS: usize = 40;
/// Number of scans between two removals of clutter.
pub(super) const CLEANING_SCANS: usize = 20;
