//! Counts over the updates of one scan.

use crate::detection::seen::Weighed;
use crate::report::watch::Recognised;
use crate::{Peak, Real};

/// Known landmarks in view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Known<T> {
    /// Σ w before the scan.
    pub(crate) weight: T,
    /// Σ p_D w.
    pub(crate) expected: T,
    /// Σ w of the same, missed.
    pub(crate) missed: T,
    /// Σ w of the same, detected.
    pub(crate) detected: T,
}

impl<T: Real> Known<T> {
    const NOTHING: Self = Self { weight: T::ZERO, expected: T::ZERO, missed: T::ZERO, detected: T::ZERO };
}

/// What the updates of one scan did, over all maps of both kinds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tally<T> {
    /// Distinct survivors.
    pub(crate) survivors: usize,
    /// Particles whose maps of both kinds were written.
    pub(crate) updated: usize,
    /// Mass of the components dropped for their weight.
    pub(crate) pruned_mass: T,
    /// Components merged into another.
    pub(crate) merged: usize,
    /// Components born that outlived pruning, before merging.
    pub(crate) births: usize,
    /// Maps for which pruning had to be tightened, by any lack of room.
    pub(crate) tightened: usize,
    /// Components that found no room at all.
    pub(crate) lost: usize,
    /// Particles of whose maps one was left as predicted, because its confirmed components would not have fitted.
    pub(crate) kept: usize,
    /// Corrected covariances that had to be repaired.
    pub(crate) repaired: usize,
    /// Measurements that could not give birth: without an inverse, or with one out of view.
    pub(crate) no_birth: usize,
    /// Σ w d² and Σ w over the detections kept: the normalised innovation squared and its weight.
    pub(crate) innovation: (T, T),
    /// Σ p_D w over the components in view.
    pub(crate) expected_detections: T,
    /// The same over the known landmarks.
    pub(crate) known: Known<T>,
    /// The most that the maps of static and of moving features have taken of their capacities.
    pub(crate) peaks: [Peak; 2],
    /// What the last of the maps says of its pose, as [`weigh`](crate::detection::weigh::weigh) would have it, where that is asked for.
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

    /// Adds what the update of one survivor has counted. Sums over its components are its own first, so that survivors can be updated one
    /// after the other or at the same time, to the same bits.
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

    /// A known landmark in view: w and p_D w before the scan, and w of it missed.
    #[inline(always)]
    pub(crate) fn known(&mut self, weight: T, expected: T, missed: T) {
        self.known.weight += weight;
        self.known.expected += expected;
        self.known.missed += missed;
    }

    /// A detection kept: its weight, its squared Mahalanobis distance, and whether it is one of a known landmark.
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

    /// Detections expected and made, in the mean over the maps.
    pub(crate) fn mean_detections(&self) -> [T; 2] {
        let maps = T::from_usize(self.survivors.max(1));
        [self.expected_detections / maps, self.innovation.1 / maps]
    }

    /// What became of the known landmarks, in the mean over the maps.
    pub(crate) fn recognised(&self) -> Recognised<T> {
        let Known { weight, expected, missed, detected } = self.known;
        let detection = if weight > T::ZERO { expected / weight } else { T::ZERO };
        let given_up = detection * (weight - missed - detected);
        Recognised { expected, detected, given_up }.over(self.survivors)
    }

    /// Mean squared innovation per dimension of the measurement; 0 where nothing was detected.
    pub(crate) fn mean_innovation(&self, dimension: usize) -> T {
        let (sum, weight) = self.innovation;
        if weight > T::ZERO { sum / (weight * T::from_usize(dimension)) } else { T::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::Tally;

    /// Whichever of the survivors comes first.
    #[test]
    fn the_peak_is_the_most_of_any_survivor() {
        let with = |in_view: [usize; 2]| {
            let mut tally = Tally::<f32>::new();
            tally.peaks.iter_mut().zip(in_view).for_each(|(peak, in_view)| peak.in_view = in_view);
            tally
        };
        for order in [[[3, 0], [1, 5]], [[1, 5], [3, 0]]] {
            let mut sum = Tally::new();
            order.map(|in_view| sum.add(&with(in_view)));
            assert_eq!(sum.peaks.map(|peak| peak.in_view), [3, 5]);
        }
    }
}
