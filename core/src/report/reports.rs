//! Reports of the steps.

use crate::Health;

/// Result of a prediction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct PredictReport {
    /// Candidates after the prediction: N·M.
    pub candidates: usize,
    /// Candidates whose predicted pose was out of the range of the scalar; they were not moved.
    pub rejected: usize,
    /// Predictions that were refused since the last scan.
    pub refused: usize,
    /// Warnings.
    pub health: Health,
}

/// Greatest use of the map capacities of one kind during a scan: each capacity must be at least this.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Peak {
    /// Pages of the pool.
    pub pages: usize,
    /// Pages of one map.
    pub map_pages: usize,
    /// Components of one map in an update, before reduction (`VIEW`, `in_view`).
    pub in_view: usize,
}

/// Result of a scan of a [`ScPhd`](crate::ScPhd). Counts over maps are sums over all distinct survivors, whose static and moving
/// maps count as one map.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct ScanReport<T> {
    /// Measurements in the scan.
    pub measurements: usize,
    /// Measurements that could not become a component, because they have no inverse or one that is out of view.
    pub no_birth: usize,
    /// Predictions that were refused since the last scan.
    pub refused: usize,
    /// Candidates that were weighted.
    pub candidates: usize,
    /// Greatest number of components in view of any candidate.
    pub in_view: usize,
    /// ln Σ ζ L: ln of the likelihood of the scan given all previous inputs, up to a constant; −∞ if no candidate explains the
    /// scan.
    pub ln_evidence: T,
    /// `N_eff` of the candidates before resampling.
    pub n_eff: T,
    /// Whether the particles were resampled.
    pub resampled: bool,
    /// Particles after the scan.
    pub particles: usize,
    /// Distinct selected candidates.
    pub survivors: usize,
    /// Maps that were updated.
    pub maps_updated: usize,
    /// New components, before merging.
    pub births: usize,
    /// Components that were merged into another one.
    pub merged: usize,
    /// Sum of the weights of pruned components, without detection terms that were excluded before they were computed; each of those
    /// weighs less than `prune_weight`.
    pub pruned_mass: T,
    /// Maps whose pruning threshold was raised because of too little memory, and maps of which the informed proposal could use only
    /// the heaviest components.
    pub tightened: usize,
    /// Maps that remain as predicted because of too little memory.
    pub not_updated: usize,
    /// Components that were discarded because of too little memory.
    pub lost: usize,
    /// Covariances that were repaired.
    pub repaired: usize,
    /// Greatest use of the capacities for static features.
    pub peak: Peak,
    /// Greatest use of the capacities for moving features.
    pub moving_peak: Peak,
    /// Pages of static features in use after the scan.
    pub pages_used: usize,
    /// Total number of pages for static features.
    pub pages: usize,
    /// Pages of moving features in use after the scan.
    pub moving_pages_used: usize,
    /// Total number of pages for moving features.
    pub moving_pages: usize,
    /// Expected number of detections of the features in view, static and moving, as the mean over the updated maps: Σ p_D w.
    pub expected_detections: T,
    /// Expected number of measurements that come from features in view, as the mean over the updated maps: Σ p_D w N(z; ẑ, S)/η_z.
    /// If it is far below `expected_detections` in scan after scan in a well-known map, the estimated pose is wrong.
    pub detections: T,
    /// Normalised innovation squared per dimension of the measurement: the mean of vᵀ S⁻¹ v, weighted with the detection terms.
    /// About 1 in a consistent filter, 0 without detections.
    pub innovation: T,
    /// Warnings.
    pub health: Health,
}
