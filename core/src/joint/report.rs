//! What a scan did, and what is summed for it.

use super::state::Header;
use crate::report::watch::Recognised;
use crate::{Health, Pose, Real, Symmetric};

/// What a scan of a [`JointSlam`](super::JointSlam) did.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct JointReport<T> {
    /// Measurements in the scan.
    pub measurements: usize,
    /// Features in view before the scan, but for those that are known much worse than what is at hand: they have no part in it.
    pub in_view: usize,
    /// Predictions refused since the scan before.
    pub refused: usize,
    /// Features born.
    pub births: usize,
    /// Measurements that could not give birth, because they have no inverse or one that is out of view.
    pub no_birth: usize,
    /// Features dropped because they are hardly there.
    pub dropped: usize,
    /// Features that turned out to be another one.
    pub merged: usize,
    /// Births, or features in whose place they went, for which there was no room.
    pub lost: usize,
    /// Corrections left out, and features dropped, because rounding had spoilt their covariances.
    pub spoilt: usize,
    /// Features that went into the archive, far from the vehicle.
    pub parked: usize,
    /// Features that came back out of it.
    pub recalled: usize,
    /// Features that the archive had no room for, or that went in their place.
    pub forgotten: usize,
    /// Features after the scan that may move.
    pub movers: usize,
    /// Features after the scan, without those in the archive.
    pub features: usize,
    /// ln of the likelihood of the scan given all before, up to a constant.
    pub ln_evidence: T,
    /// Detections to be expected of the features in view: Σ p_D v.
    pub expected_detections: T,
    /// Measurements that the features in view explain, by their shares. Far less than expected of a map that is well known, scan after
    /// scan, says that the vehicle is not where it is taken to be.
    pub detections: T,
    /// Mean of νᵀ S⁻¹ ν over the detections, by their shares, per dimension of the measurement; about 1 for a consistent filter;
    /// 0 where nothing was detected.
    pub innovation: T,
    /// Conditions.
    pub health: Health,
}

/// What is summed over the features in view.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tally<T> {
    /// Σ s νᵀ S⁻¹ ν, and Σ s.
    pub(super) squares: T,
    pub(super) probabilities: T,
    /// Corrections left out because rounding had spoilt the covariance of their innovation.
    pub(super) left_out: usize,
    /// Detections to be expected of features in view that had no part in the scan.
    pub(super) expected_of_weak: T,
    /// What became of all features in view.
    all: Recognised<T>,
    /// What became of those that the watch knows.
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

    /// Ends a scan of so many measurements of a dimension, of which the detector states so many to be false: the report without births and what goes, which the caller adds.
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
            spoilt: self.left_out,
            parked: 0,
            recalled: 0,
            forgotten: 0,
            movers: 0,
            features: header.len,
            ln_evidence: T::ZERO,
            expected_detections: self.all.expected,
            detections: self.all.detected,
            innovation,
            health,
        }
    }
}
