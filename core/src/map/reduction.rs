//! Which components of a mixture are merged.

use crate::Real;

/// Which components are merged into one of the same mass, mean and spread.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reduction<T> {
    /// Vo & Ma 2006, table II: the heaviest component takes in all within reach, and so on.
    Greedy {
        /// Squared Mahalanobis distance within which components are merged (table II: U).
        merge_distance: T,
    },
    /// Runnalls 2007: the heaviest component takes in one other after another, always the one whose merger costs least.
    Runnalls {
        /// Greatest cost: the bound on the Kullback–Leibler divergence, per mass of the lighter component. Two equal
        /// components a squared Mahalanobis distance d² apart cost ln(1 + d²/4), a much lighter one about d²/2.
        merge_cost: T,
    },
}

impl<T: Real> Reduction<T> {
    /// Whether the bound is finite and not negative.
    pub(crate) fn is_usable(&self) -> bool {
        let (Self::Greedy { merge_distance: bound } | Self::Runnalls { merge_cost: bound }) = *self;
        bound >= T::ZERO && bound.is_finite()
    }
}
