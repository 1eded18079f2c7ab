//! The tuning of several hypotheses.

use super::MOST;
use crate::{ConfigError, Real};

/// Tuning of a [`MultiHypothesisSlam`](super::MultiHypothesisSlam).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HypothesesConfig<T> {
    /// Greatest number of hypotheses, up to 16; the memory may have room for fewer. With 1 the filter is a
    /// [`JointSlam`](crate::JointSlam).
    pub most: usize,
    /// Two hypotheses are joined if their poses are within this many standard deviations (Mahalanobis distance).
    pub joined_sigmas: T,
    /// A child is dropped if its weight, divided by that of the likeliest child, is below this.
    pub least_ratio: T,
    /// A hypothesis is dropped after a scan if its probability is below this.
    pub least_share: T,
}

impl<T: Real> Default for HypothesesConfig<T> {
    fn default() -> Self {
        let real = T::from_f64;
        Self { most: 8, joined_sigmas: real(0.25), least_ratio: real(1e-3), least_share: real(1e-4) }
    }
}

impl<T: Real> HypothesesConfig<T> {
    /// The field that is out of range, if any.
    ///
    /// # Errors
    /// `most` must be from 1 to 16, `joined_sigmas` finite and not negative, and the others between 0 and 1.
    pub fn check(&self) -> Result<(), ConfigError> {
        let Self { most, joined_sigmas, least_ratio, least_share } = *self;
        let is_share = |share: T| share >= T::ZERO && share <= T::ONE;
        let require = |holds, field, range| if holds { Ok(()) } else { Err(ConfigError { field, range }) };
        require((1..=MOST).contains(&most), "most", "from 1 to 16")?;
        require(joined_sigmas.is_amount(), "joined_sigmas", "finite and not negative")?;
        require(is_share(least_ratio), "least_ratio", "between 0 and 1")?;
        require(is_share(least_share), "least_share", "between 0 and 1")
    }
}
