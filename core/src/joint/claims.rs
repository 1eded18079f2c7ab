//! Which features may have caused each measurement, and their shares of it.

use crate::Real;

/// A feature's claim on a measurement.
#[derive(Debug, Clone, Copy)]
pub(super) struct Claim<T> {
    /// The feature's place.
    pub(super) feature: u16,
    /// ln( p_D v N(z; ẑ, S) / (1 − p_D v) ).
    pub(super) ln_likelihood: T,
    /// a: the same over what nothing but clutter and births explain.
    pub(super) odds: T,
    /// ν: what the measurement answers.
    pub(super) answer: T,
    /// Σ a ν of the feature's other claims.
    pub(super) others: T,
    /// s: the probability that the feature caused the measurement.
    pub(super) share: T,
}

/// Features that share a measurement, at most: the likeliest, and more than these four never matter.
pub(super) const CLAIMS: usize = 4;

/// What explains one measurement.
#[derive(Debug, Clone, Copy)]
pub(super) struct Explained<T> {
    /// ln λ = ln( κ + w_b ).
    pub(super) ln_unexplained: T,
    /// The probability that no feature caused it.
    pub(super) unexplained: T,
    /// The likeliest features; the weakest of them first, once there are as many as there is room for.
    claims: [Claim<T>; CLAIMS],
    /// How many there are.
    len: usize,
}

impl<T: Real> Claim<T> {
    pub(super) fn new(feature: u16, ln_likelihood: T) -> Self {
        Self { feature, ln_likelihood, ..Self::ZERO }
    }

    const ZERO: Self =
        Self { feature: 0, ln_likelihood: T::ZERO, odds: T::ZERO, answer: T::ZERO, others: T::ZERO, share: T::ZERO };
}

impl<T: Real> Explained<T> {
    pub(super) const ZERO: Self =
        Self { ln_unexplained: T::ZERO, unexplained: T::ZERO, claims: [Claim::ZERO; CLAIMS], len: 0 };

    /// Starts a scan: nothing but clutter and births explain it yet.
    pub(super) fn start(&mut self, ln_unexplained: T) {
        (self.ln_unexplained, self.len) = (ln_unexplained, 0);
    }

    /// All but the claims, to be damaged.
    #[cfg(any(test, feature = "flips"))]
    pub(super) fn parts(&mut self) -> ([&mut T; 2], &mut usize) {
        ([&mut self.ln_unexplained, &mut self.unexplained], &mut self.len)
    }

    pub(super) fn claims(&self) -> &[Claim<T>] {
        self.claims.get(..self.len).unwrap_or(&[])
    }

    pub(super) fn claims_mut(&mut self) -> &mut [Claim<T>] {
        self.claims.get_mut(..self.len).unwrap_or(&mut [])
    }

    /// Takes in a feature's claim, in place of the weakest where there are enough.
    pub(super) fn claim(&mut self, claim: Claim<T>) {
        if let Some(slot) = self.claims.get_mut(self.len) {
            *slot = claim;
            self.len += 1;
        } else if let Some(weakest) = self.claims.first_mut()
            && weakest.ln_likelihood < claim.ln_likelihood
        {
            *weakest = claim;
        }
        if self.len == CLAIMS {
            self.weakest_first();
        }
    }

    /// Takes the claims of some features back.
    pub(super) fn take_back(&mut self, of: impl Fn(u16) -> bool) {
        let mut kept = 0;
        for place in 0..self.len {
            let Some(claim) = self.claims.get(place).copied().filter(|claim| !of(claim.feature)) else { continue };
            if let Some(slot) = self.claims.get_mut(kept) {
                *slot = claim;
            }
            kept += 1;
        }
        self.len = kept;
    }

    fn weakest_first(&mut self) {
        let mut weakest = (0, T::INFINITY);
        for (place, claim) in self.claims.iter().enumerate() {
            if claim.ln_likelihood < weakest.1 {
                weakest = (place, claim.ln_likelihood);
            }
        }
        self.claims.swap(0, weakest.0);
    }
}

/// The measurements that a feature has a share of, and the share s.
pub(super) fn shares<'m, T: Real, Y>(
    explained: &'m [Explained<T>],
    place: usize,
    measurements: &'m [Y],
) -> impl Iterator<Item = (T, &'m Y)> + 'm {
    explained.iter().zip(measurements).filter_map(move |(explained, z)| {
        let claim = explained.claims().iter().find(|claim| usize::from(claim.feature) == place)?;
        Some((claim.share, z))
    })
}

/// Σ s of one feature.
pub(super) fn detected<T: Real, Y>(explained: &[Explained<T>], place: usize, measurements: &[Y]) -> T {
    shares(explained, place, measurements).fold(T::ZERO, |sum, (share, _)| sum + share)
}
