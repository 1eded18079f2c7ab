//! Counts over the updates of one scan.

use crate::detection::seen::Weighed;
use crate::report::watch::Recognised;
use crate::{Peak, Real};

/// Sums over known landmarks in view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Known<T> {
    /// Σ w before the scan.
    pub(crate) weight: T,
    /// Σ p_D w.
    pub(crate) expected: T,
    /// Σ w after a miss, of the same landmarks.
    pub(crate) missed: T,
    /// Σ w of their detections.
    pub(crate) detected: T,
}

impl<T: Real> Known<T> {
    const NOTHING: Self = Self { weight: T::ZERO, expected: T::ZERO, missed: T::ZERO, detected: T::ZERO };
}

/// Counts and sums over the map updates of a scan, for both kinds of maps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tally<T> {
    /// Number of distinct survivors.
    pub(crate) survivors: usize,
    /// Number of particles whose maps of both kinds were written.
    pub(crate) updated: usize,
    /// Mass of the components dropped for their weight.
    pub(crate) pruned_mass: T,
    /// Number of components merged into another.
    pub(crate) merged: usize,
    /// Number of births that were not pruned, before merging.
    pub(crate) births: usize,
    /// Number of maps for which the pruning threshold was raised because of a capacity.
    pub(crate) tightened: usize,
    /// Number of components for which there was no room.
    pub(crate) lost: usize,
    /// Number of particles with a map that was left as predicted, because its confirmed components would not have fitted.
    pub(crate) kept: usize,
    /// Number of corrected covariances that had to be repaired.
    pub(crate) repaired: usize,
    /// Number of measurements that could not give birth, because their inverse does not exist or is out of view.
    pub(crate) no_birth: usize,
    /// Σ w d² and Σ w over the detections kept: the normalised innovation squared and its weight.
    pub(crate) innovation: (T, T),
    /// Σ p_D w over the components in view.
    pub(crate) expected_detections: T,
    /// Sums over the known landmarks in view.
    pub(crate) known: Known<T>,
    /// The greatest use of the capacities, of the maps of static and of moving features.
    pub(crate) peaks: [Peak; 2],
    /// Likelihood and components in view of the last updated map, as [`weigh`](crate::detection::weigh::weigh) would give, if
    /// requested.
    pub(crate) last: Weighed<T>,
}

impl<T: Real> Tally<T> {
    pub(crate) fn new() -> Self {
        Self {
            survivors: 0,
            updated: 0,
            pruned_mass: T::ZERO,
            merged: 0,
            births: 0,
            tightened: 0,
            lost: 0,
            kept: 0,
            repaired: 0,
            no_birth: 0,
            innovation: (T::ZERO, T::ZERO),
            expected_detections: T::ZERO,
            known: Known::NOTHING,
            peaks: [Peak::default(); 2],
            last: Weighed { ln_likelihood: T::ZERO, in_view: 0 },
        }
    }

    /// Adds the counts of one survivor's update. Each survivor has sums of its own first, so that updates in sequence and in
    /// parallel give the same bits.
    pub(crate) fn add(&mut self, other: &Self) {
        self.pruned_mass += other.pruned_mass;
        self.tightened += other.tightened;
        self.lost += other.lost;
        self.merged += other.merged;
        self.births += other.births;
        self.repaired += other.repaired;
        self.no_birth += other.no_birth;
        self.innovation.0 += other.innovation.0;
        self.innovation.1 += other.innovation.1;
        self.expected_detections += other.expected_detections;
        self.known.weight += other.known.weight;
        self.known.expected += other.known.expected;
        self.known.missed += other.known.missed;
        self.known.detected += other.known.detected;
        for (peak, other) in self.peaks.iter_mut().zip(&other.peaks) {
            peak.in_view = peak.in_view.max(other.in_view);
        }
    }

    /// Adds a known landmark in view: w and p_D w before the scan, and w after a miss.
    #[inline(always)]
    pub(crate) fn known(&mut self, weight: T, expected: T, missed: T) {
        self.known.weight += weight;
        self.known.expected += expected;
        self.known.missed += missed;
    }

    /// Adds a detection that was kept: its weight, its squared Mahalanobis distance, and whether it is of a known landmark.
    #[inline(always)]
    pub(crate) fn detected(&mut self, weight: T, distance: T, is_known: bool) {
        self.innovation.0 += weight * distance;
        self.innovation.1 += weight;
        if is_known {
            self.known.detected += weight;
        }
    }

    /// Adds the counts of delayed births, which entered the maps before the update.
    pub(crate) fn add_delayed_births(&mut self, other: &Self) {
        self.lost += other.lost;
        self.repaired += other.repaired;
        self.no_birth += other.no_birth;
    }

    /// Expected and actual number of detections, mean over the maps.
    pub(crate) fn mean_detections(&self) -> [T; 2] {
        let maps = T::from_usize(self.survivors.max(1));
        [self.expected_detections / maps, self.innovation.1 / maps]
    }

    /// Expected and detected known landmarks, mean over the maps.
    pub(crate) fn recognised(&self) -> Recognised<T> {
        let Known { weight, expected, missed, detected } = self.known;
        let detection = if weight > T::ZERO { expected / weight } else { T::ZERO };
        let existence_loss = detection * (weight - missed - detected);
        Recognised { expected, detected, existence_loss }.over(self.survivors)
    }

    /// Mean squared innovation per dimension of the measurement; 0 without detections.
    pub(crate) fn mean_innovation(&self, dimension: usize) -> T {
        let (sum, weight) = self.innovation;
        if weight > T::ZERO { sum / (weight * T::from_usize(dimension)) } else { T::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::Tally;

    /// For any order of the survivors.
    #[test]
    fn the_peak_is_the_maximum_over_survivors() {
        let with = |in_view: [usize; 2]| {
            let mut tally = Tally::<f32>::new();
            tally.peaks.iter_mut().zip(in_view).for_each(|(peak, in_view)| peak.in_view = in_view);
            tally
        };
        for order in [[[3, 0], [1, 5]], [[1, 5], [3, 0]]] {
            let mut sum = Tally::new();
            order.iter().for_each(|&in_view| sum.add(&with(in_view)));
            assert_eq!(sum.peaks.map(|peak| peak.in_view), [3, 5]);
        }
    }
}
