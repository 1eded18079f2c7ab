//! The report of a scan, and the sums it is computed from.

use super::state::Header;
use crate::report::watch::Recognised;
use crate::{Health, Pose, Real, Symmetric};

/// Result of a scan of a [`JointSlam`](super::JointSlam) or [`MultiHypothesisSlam`](super::MultiHypothesisSlam), of which it
/// is that of the likeliest hypothesis; `ln_evidence` is of all together.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct JointReport<T> {
    /// Measurements in the scan.
    pub measurements: usize,
    /// Features in view before the scan, except weakly determined ones, which take no part in it.
    pub in_view: usize,
    /// Predictions that were refused since the last scan.
    pub refused: usize,
    /// New features.
    pub births: usize,
    /// Measurements that could not become a feature, because they have no inverse or one that is out of view.
    pub no_birth: usize,
    /// Features that were removed because their existence probability was too low.
    pub dropped: usize,
    /// Features that were merged with another one.
    pub merged: usize,
    /// New features for which there was no room, or features that they replaced.
    pub lost: usize,
    /// Corrections that were left out, and features that were removed, because a covariance was no longer positive definite.
    pub degenerate: usize,
    /// Features far from the vehicle that were moved to the archive.
    pub archived: usize,
    /// Features that were moved back from the archive.
    pub reactivated: usize,
    /// Features for which the archive had no room, or features that they replaced.
    pub evicted: usize,
    /// Moving-object tracks after the scan.
    pub movers: usize,
    /// Features after the scan, without those in the archive.
    pub features: usize,
    /// Hypotheses of data association after the scan.
    pub hypotheses: usize,
    /// Probability of the likeliest.
    pub share: T,
    /// Hypotheses that were joined with another one.
    pub joined: usize,
    /// Measurements with a likely cause for which there was no place.
    pub saturated: usize,
    /// ln of the likelihood of the scan given all previous inputs, up to a constant.
    pub ln_evidence: T,
    /// Expected number of detections of the features in view: Σ p_D v, with v the probability that a feature exists and is visible.
    pub expected_detections: T,
    /// Expected number of measurements that come from features in view: the sum of their association probabilities. If
    /// it is far below `expected_detections` in scan after scan in a well-known map, the estimated pose is wrong.
    pub detections: T,
    /// Normalised innovation squared per dimension of the measurement: the mean of νᵀ S⁻¹ ν, weighted with the
    /// association probabilities. About 1 in a consistent filter, 0 without detections.
    pub innovation: T,
    /// Warnings.
    pub health: Health,
}

/// Sums over the features in view.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tally<T> {
    /// Σ s νᵀ S⁻¹ ν; `probabilities` is Σ s.
    pub(super) squares: T,
    pub(super) probabilities: T,
    /// Corrections that were left out because a covariance or the result was invalid.
    pub(super) left_out: usize,
    /// Expected detections of weakly determined features, which took no part in the scan.
    pub(super) expected_of_weak: T,
    /// Sums over all features in view.
    all: Recognised<T>,
    /// Sums over those that the divergence monitor knows.
    known: Recognised<T>,
}

impl<T: Real> Tally<T> {
    pub(super) const NOTHING: Self = Self {
        squares: T::ZERO,
        probabilities: T::ZERO,
        left_out: 0,
        expected_of_weak: T::ZERO,
        all: Recognised::NOTHING,
        known: Recognised::NOTHING,
    };

    /// Counts a feature in view.
    pub(super) fn count(&mut self, is_known: bool, feature: Recognised<T>) {
        self.all.add(&feature);
        if is_known {
            self.known.add(&feature);
        }
    }

    /// The report of a scan with this number of measurements of this dimension; `stated` is the expected number of
    /// false measurements. The counts of new and removed features are zero, and are added by the caller. Sums since the
    /// last scan are set to zero.
    pub(super) fn report<P: Pose<Scalar = T>>(
        &self,
        header: &mut Header<P>,
        (measurements, stated): (usize, T),
        dimension: usize,
    ) -> JointReport<T> {
        header.watch.exclude_expected(self.expected_of_weak, measurements);
        let watched = header.watch.scanned(&self.known, (measurements, stated), header.waited_s, header.next_label);
        let refused = core::mem::take(&mut header.refused);
        header.waited_s = T::ZERO;
        header.motion_noise = Symmetric::ZERO;
        let numbers = self.probabilities * T::from_usize(dimension);
        let innovation = if numbers > T::ZERO { self.squares / numbers } else { T::ZERO };
        let health = Health::COVARIANCE_REPAIRED.when(self.left_out > 0)
            | Health::of_innovation(innovation, numbers)
            | Health::PREDICTION_REFUSED.when(refused > 0)
            | watched;
        JointReport {
            measurements,
            in_view: 0,
            refused,
            births: 0,
            no_birth: 0,
            dropped: 0,
            merged: 0,
            lost: 0,
            degenerate: self.left_out,
            archived: 0,
            reactivated: 0,
            evicted: 0,
            movers: 0,
            features: header.len,
            hypotheses: 1,
            share: T::ONE,
            joined: 0,
            saturated: 0,
            ln_evidence: T::ZERO,
            expected_detections: self.all.expected,
            detections: self.all.detected,
            innovation,
            health,
        }
    }
}
