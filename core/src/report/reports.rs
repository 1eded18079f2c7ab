//! What a step did.

use crate::Health;

/// What a prediction did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct PredictReport {
    /// Candidates after the prediction: N·M.
    pub candidates: usize,
    /// Candidates whose pose left the range of the scalar; they stayed where they were.
    pub rejected: usize,
    /// Predictions refused since the last scan.
    pub refused: usize,
    /// Conditions.
    pub health: Health,
}

/// The most that a scan has taken of the capacities of the maps of one kind, at any moment: each must be at least that.
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

/// What a scan did. Counts over maps are sums over the maps of all distinct survivors; a map is one particle's of both kinds.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct ScanReport<T> {
    /// Measurements in the scan.
    pub measurements: usize,
    /// Measurements that could not give birth, because they have no inverse or one that is out of view.
    pub no_birth: usize,
    /// Predictions refused since the scan before.
    pub refused: usize,
    /// Candidates weighed.
    pub candidates: usize,
    /// Greatest number of components in view of a candidate.
    pub in_view: usize,
    /// ln Σ ζ L: the logarithm of the scan's likelihood given all before, up to a constant; −∞ where no candidate
    /// explains it.
    pub ln_evidence: T,
    /// `N_eff` of the candidates before any resampling.
    pub n_eff: T,
    /// Whether the particles were resampled.
    pub resampled: bool,
    /// Particles that go on.
    pub particles: usize,
    /// Distinct candidates among the survivors.
    pub survivors: usize,
    /// Maps written.
    pub maps_updated: usize,
    /// Components born and kept, before merging.
    pub births: usize,
    /// Components merged into another.
    pub merged: usize,
    /// Mass of the components dropped for their weight. Detections that are ruled out without being computed are not
    /// counted; each weighs less than `prune_weight`.
    pub pruned_mass: T,
    /// Maps that lacked room, for which pruning was tightened; and those of which the informed proposal could take the heaviest
    /// components alone.
    pub tightened: usize,
    /// Maps left as predicted for want of room.
    pub not_updated: usize,
    /// Components that found no room.
    pub lost: usize,
    /// Covariances repaired.
    pub repaired: usize,
    /// The most that the scan has taken of the capacities for static features.
    pub peak: Peak,
    /// The same for moving features.
    pub moving_peak: Peak,
    /// Pages of static features in use after the scan.
    pub pages_used: usize,
    /// Pages for static features in all.
    pub pages: usize,
    /// Pages of moving features in use after the scan.
    pub moving_pages_used: usize,
    /// Pages for moving features in all.
    pub moving_pages: usize,
    /// Detections to be expected of the features in view, static and moving, in the mean over the maps updated: Σ p_D w.
    pub expected_detections: T,
    /// Measurements that the features in view explain, likewise: Σ p_D w N(z; ẑ, S)/η_z. Far less than expected of a map that is well known,
    /// scan after scan, says that the vehicle is not where it is taken to be.
    pub detections: T,
    /// Mean of vᵀ S⁻¹ v over the detections, by weight, per dimension of the measurement; about 1 for a consistent
    /// filter; 0 where nothing was detected.
    pub innovation: T,
    /// Conditions.
    pub health: Health,
}
