//! The association table of a scan: for each measurement, the landmarks that may have caused it, with their probabilities.

use crate::Real;

/// One entry: a landmark or a moving-object track that may have caused a measurement.
#[derive(Debug, Clone, Copy)]
pub(super) struct Association<T> {
    /// Index of the landmark, or that of a moving-object track with the bit [`MOVES`](super::movers::MOVES).
    pub(super) feature: u16,
    /// a: the odds p_D v N(z; ẑ, S) / ((1 − p_D v) λ), before [`marginals`](super::data_association::marginals) the logarithm
    /// of a λ. If the same object has a moving-object track of probability w, the denominator is (1 − p_D v − p_D w) λ.
    pub(super) odds: T,
    /// ν: the message from the measurement to the landmark.
    pub(super) nu: T,
    /// s: the probability that the feature caused the measurement; until it is known, the cavity sum Σ a ν of the landmark's
    /// associations with other measurements.
    pub(super) probability: T,
}

/// Maximum number of associations of a measurement: the likeliest ones. More than four hardly change the result.
pub(super) const ASSOCIATIONS: usize = 4;

/// A row of the association table: one measurement.
#[derive(Debug, Clone, Copy)]
pub(super) struct AssociationRow<T> {
    /// ln λ: the intensity of clutter and births, λ = κ + w_b, plus w_m with moving-object tracks.
    pub(super) ln_lambda: T,
    /// u: the probability that no landmark caused the measurement.
    pub(super) no_feature_probability: T,
    /// The likeliest associations. If the row is full, the least likely one is the first.
    associations: [Association<T>; ASSOCIATIONS],
    /// Number of associations.
    len: usize,
}

impl<T: Real> Association<T> {
    pub(super) fn new(feature: u16, ln_likelihood: T) -> Self {
        Self { feature, odds: ln_likelihood, ..Self::ZERO }
    }

    const ZERO: Self = Self { feature: 0, odds: T::ZERO, nu: T::ZERO, probability: T::ZERO };
}

impl<T: Real> AssociationRow<T> {
    pub(super) const ZERO: Self = Self {
        ln_lambda: T::ZERO,
        no_feature_probability: T::ZERO,
        associations: [Association::ZERO; ASSOCIATIONS],
        len: 0,
    };

    /// Starts a scan, without associations.
    pub(super) fn start(&mut self, ln_lambda: T) {
        (self.ln_lambda, self.len) = (ln_lambda, 0);
    }

    /// Removes the associations: no landmark caused the measurement.
    pub(super) fn clear(&mut self) {
        (self.no_feature_probability, self.len) = (T::ONE, 0);
    }

    /// All data except the associations, for fault injection.
    #[cfg(any(test, feature = "flips"))]
    pub(super) fn parts(&mut self) -> ([&mut T; 2], &mut usize) {
        ([&mut self.ln_lambda, &mut self.no_feature_probability], &mut self.len)
    }

    pub(super) fn associations(&self) -> &[Association<T>] {
        self.associations.get(..self.len).unwrap_or(&[])
    }

    pub(super) fn associations_mut(&mut self) -> &mut [Association<T>] {
        self.associations.get_mut(..self.len).unwrap_or(&mut [])
    }

    /// Adds an association. In a full row it replaces the least likely one, if that is less likely.
    pub(super) fn associate(&mut self, association: Association<T>) {
        if let Some(slot) = self.associations.get_mut(self.len) {
            *slot = association;
            self.len += 1;
        } else if let Some(weakest) = self.associations.first_mut()
            && weakest.odds < association.odds
        {
            *weakest = association;
        }
        if self.len == ASSOCIATIONS {
            self.weakest_first();
        }
    }

    /// Adds an association of known probability to a row with fewer than four, as the cause of the measurement.
    pub(super) fn add_certain(&mut self, feature: u16, probability: T) {
        self.no_feature_probability = T::ZERO;
        self.associate(Association { probability, ..Association::new(feature, T::ZERO) });
    }

    /// Removes the associations of the landmarks for which `of` is true.
    pub(super) fn retract(&mut self, of: impl Fn(u16) -> bool) {
        let mut kept = 0;
        for index in 0..self.len {
            let Some(association) =
                self.associations.get(index).copied().filter(|association| !of(association.feature))
            else {
                continue;
            };
            if let Some(slot) = self.associations.get_mut(kept) {
                *slot = association;
            }
            kept += 1;
        }
        self.len = kept;
    }

    fn weakest_first(&mut self) {
        let mut weakest = (0, T::INFINITY);
        for (index, association) in self.associations.iter().enumerate() {
            if association.odds < weakest.1 {
                weakest = (index, association.odds);
            }
        }
        self.associations.swap(0, weakest.0);
    }
}

/// The measurements that are associated with a landmark, each with the probability s.
pub(super) fn probabilities<'m, T: Real, Y>(
    table: &'m [AssociationRow<T>],
    index: usize,
    measurements: &'m [Y],
) -> impl Iterator<Item = (T, &'m Y)> + 'm {
    table.iter().zip(measurements).filter_map(move |(row, z)| {
        let association = row.associations().iter().find(|association| usize::from(association.feature) == index)?;
        Some((association.probability, z))
    })
}

/// Σ s of one landmark: the probability that it was detected.
pub(super) fn detected<T: Real, Y>(table: &[AssociationRow<T>], index: usize, measurements: &[Y]) -> T {
    probabilities(table, index, measurements).fold(T::ZERO, |sum, (probability, _)| sum + probability)
}
