//! The tuning of a locator.

use crate::{ConfigError, Real};

/// What a [`Locator`](super::Locator) expects of places and maps.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LocatorConfig<T> {
    /// The probability, before anything is seen, that the vehicle is somewhere that the map does not have.
    pub elsewhere: T,
    /// The probability that a feature of the map is still there, and can be seen.
    pub remains: T,
    /// Landmarks that the map does not have, in a place that it has: how dense, as a share of how dense landmarks are.
    pub new_share: T,
    /// What covariances of either map are multiplied by: errors within a map are not independent, and these are taken for it.
    pub inflation: T,
    /// A squared Mahalanobis distance: a landmark farther off is another one.
    pub gate: T,
    /// The vehicle is found where the probability is at least this.
    pub sure: T,
    /// Landmarks that must be those of the map, at least: two tell a place, and the others that it is one.
    pub least_matched: usize,
    /// The share of the landmarks that were found that must be the map's: what overlaps less is as likely chance.
    pub least_share: T,
    /// Pairs of landmarks that are laid over others in one scan, at most.
    pub trials: usize,
    /// Pairs of landmarks that must have been laid over all others before the vehicle is found: that something else explains as much
    /// would have been seen.
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
    /// The field that is out of range, if any.
    ///
    /// # Errors
    /// Probabilities and shares must be between 0 and 1 and neither, `inflation` and `gate` finite and positive, counts
    /// positive.
    pub fn check(&self) -> Result<(), ConfigError> {
        let shares = [
            (self.elsewhere, "elsewhere"),
            (self.remains, "remains"),
            (self.new_share, "new_share"),
            (self.least_share, "least_share"),
            (self.sure, "sure"),
        ];
        if let Some((_, field)) = shares.into_iter().find(|&(share, _)| !(share > T::ZERO && share < T::ONE)) {
            return Err(ConfigError { field, range: "between 0 and 1, and neither" });
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
