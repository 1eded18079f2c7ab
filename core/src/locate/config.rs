//! The tuning of a locator.

use crate::{ConfigError, Real};

/// Tuning of a [`Locator`](super::Locator): prior probabilities and acceptance thresholds.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LocatorConfig<T> {
    /// Prior probability that the vehicle is outside the area of the map.
    pub elsewhere: T,
    /// Probability that a feature of the map still exists and is visible.
    pub remains: T,
    /// Density of landmarks that are not in the map, inside the mapped area, relative to the density of all landmarks.
    pub new_share: T,
    /// Factor on the covariances of both maps. It accounts for the correlation of errors within a map, because the covariances are
    /// treated as independent.
    pub inflation: T,
    /// Gate of the association of landmarks: a squared Mahalanobis distance.
    pub gate: T,
    /// Minimum probability of a pose to be accepted.
    pub sure: T,
    /// Minimum number of landmarks associated with the map: two determine the pose, the others confirm it.
    pub least_matched: usize,
    /// Minimum fraction of the vehicle's landmarks that are associated with the map. With a smaller overlap, a match by chance is
    /// as probable.
    pub least_share: T,
    /// Maximum number of trial alignments (two landmarks with two of the map) per scan.
    pub trials: usize,
    /// Minimum number of pairs of landmarks that were compared with all pairs of the map before a pose is accepted, so that an
    /// alternative pose that explains the landmarks as well would have been found.
    pub searched: usize,
}

impl<T: Real> Default for LocatorConfig<T> {
    fn default() -> Self {
        let real = T::from_f64;
        Self {
            elsewhere: real(0.8),
            remains: real(0.8),
            new_share: real(0.3),
            inflation: real(2.0),
            gate: real(12.0),
            sure: real(0.99),
            least_matched: 5,
            least_share: real(0.6),
            trials: 200,
            searched: 4,
        }
    }
}

impl<T: Real> LocatorConfig<T> {
    /// Checks all fields, and returns the first that is out of range.
    ///
    /// # Errors
    /// Probabilities and fractions must be strictly between 0 and 1, `inflation` and `gate` finite and positive, counts positive.
    pub fn check(&self) -> Result<(), ConfigError> {
        let shares = [
            (self.elsewhere, "elsewhere"),
            (self.remains, "remains"),
            (self.new_share, "new_share"),
            (self.least_share, "least_share"),
            (self.sure, "sure"),
        ];
        if let Some((_, field)) = shares.into_iter().find(|&(share, _)| !(share > T::ZERO && share < T::ONE)) {
            return Err(ConfigError { field, range: "above 0 and below 1" });
        }
        let amounts = [(self.inflation, "inflation"), (self.gate, "gate")];
        if let Some((_, field)) = amounts.into_iter().find(|&(amount, _)| !(amount > T::ZERO && amount.is_finite())) {
            return Err(ConfigError { field, range: "finite and positive" });
        }
        let counts = [(self.least_matched, "least_matched"), (self.trials, "trials"), (self.searched, "searched")];
        match counts.into_iter().find(|&(count, _)| count == 0) {
            Some((_, field)) => Err(ConfigError { field, range: "positive" }),
            None => Ok(()),
        }
    }
}
