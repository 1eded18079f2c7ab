//! The association table of a scan: for each measurement, the landmarks that may have caused it, with their probabilities.

use crate::Real;

/// One entry: a landmark that may have caused a measurement.
#[derive(Debug, Clone, Copy)]
pub(super) struct Association<T> {
    /// The feature's place.
    pub(super) feature: u16,
    /// ln( p_D v N(z; ẑ, S) / (1 − p_D v) ).
    pub(super) ln_likelihood: T,
    /// a: the same over what nothing but clutter and births explain.
    pub(super) odds: T,
    /// ν: the message from the measurement to the landmark.
    pub(super) nu: T,
    /// Σ a ν of the landmark's associations with other measurements.
    pub(super) cavity_sum: T,
    /// s: the probability that the feature caused the measurement.
    pub(super) share: T,
}

/// Associations of one measurement, at most: the likeliest. More than these four never matter.
pub(super) const ASSOCIATIONS: usize = 4;

/// A row of the association table: one measurement.
#[derive(Debug, Clone, Copy)]
pub(super) struct AssociationRow<T> {
    /// ln λ = ln( κ + w_b ).
    pub(super) ln_unexplained: T,
    /// The probability that no feature caused it.
    pub(super) unexplained: T,
    /// The likeliest features; the weakest of them first, once there are as many as there is room for.
    associations: [Association<T>; ASSOCIATIONS],
    /// How many there are.
    len: usize,
}

impl<T: Real> Association<T> {
    pub(super) fn new(feature: u16, ln_likelihood: T) -> Self {
        Self { feature, ln_likelihood, ..Self::ZERO }
    }

    const ZERO: Self =
        Self { feature: 0, ln_likelihood: T::ZERO, odds: T::ZERO, nu: T::ZERO, cavity_sum: T::ZERO, share: T::ZERO };
}

impl<T: Real> AssociationRow<T> {
    pub(super) const ZERO: Self =
        Self { ln_unexplained: T::ZERO, unexplained: T::ZERO, associations: [Association::ZERO; ASSOCIATIONS], len: 0 };

    /// Starts a scan: nothing but clutter and births explain it yet.
    pub(super) fn start(&mut self, ln_unexplained: T) {
        (self.ln_unexplained, self.len) = (ln_unexplained, 0);
    }

    /// All but the associations, to be damaged.
    #[cfg(any(test, feature = "flips"))]
    pub(super) fn parts(&mut self) -> ([&mut T; 2], &mut usize) {
        ([&mut self.ln_unexplained, &mut self.unexplained], &mut self.len)
    }

    pub(super) fn associations(&self) -> &[Association<T>] {
        self.associations.get(..self.len).unwrap_or(&[])
    }

    pub(super) fn associations_mut(&mut self) -> &mut [Association<T>] {
        self.associations.get_mut(..self.len).unwrap_or(&mut [])
    }

    /// Adds an association, in place of the least likely where the row is full.
    pub(super) fn associate(&mut self, association: Association<T>) {
        if let Some(slot) = self.associations.get_mut(self.len) {
            *slot = association;
            self.len += 1;
        } else if let Some(weakest) = self.associations.first_mut()
            && weakest.ln_likelihood < association.ln_likelihood
        {
            *weakest = association;
        }
        if self.len == ASSOCIATIONS {
            self.weakest_first();
        }
    }

    /// Removes the associations of some landmarks.
    pub(super) fn retract(&mut self, of: impl Fn(u16) -> bool) {
        let mut kept = 0;
        for place in 0..self.len {
            let Some(association) =
                self.associations.get(place).copied().filter(|association| !of(association.feature))
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
        for (place, association) in self.associations.iter().enumerate() {
            if association.ln_likelihood < weakest.1 {
                weakest = (place, association.ln_likelihood);
            }
        }
        self.associations.swap(0, weakest.0);
    }
}

/// The measurements that a feature has a share of, and the share s.
pub(super) fn shares<'m, T: Real, Y>(
    explained: &'m [AssociationRow<T>],
    place: usize,
    measurements: &'m [Y],
) -> impl Iterator<Item = (T, &'m Y)> + 'm {
    explained.iter().zip(measurements).filter_map(move |(explained, z)| {
        let association =
            explained.associations().iter().find(|association| usize::from(association.feature) == place)?;
        Some((association.share, z))
    })
}

/// Σ s of one feature.
pub(super) fn detected<T: Real, Y>(explained: &[AssociationRow<T>], place: usize, measurements: &[Y]) -> T {
    shares(explained, place, measurements).fold(T::ZERO, |sum, (share, _)| sum + share)
}
