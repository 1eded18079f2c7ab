//! Candidates: samples of the vehicle's pose with their weights (5.7, 5.13).

use crate::ln_sum::ln_sum;
use crate::{Dim, Packed, Pose, Real, Symmetric};

/// A sample of the vehicle's pose. Between scans there is one a particle; from the first prediction after a scan to
/// the next scan there are M.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate<T, P> {
    /// x.
    pub pose: P,
    /// ln ζ.
    pub ln_weight: T,
}

impl<T: Real, P> Candidate<T, P> {
    /// All zero; a placeholder for unused memory.
    pub(crate) const fn zero<const K: usize>() -> Self
    where
        P: Pose<T, K>,
    {
        Self { pose: P::ZERO, ln_weight: T::ZERO }
    }
}

/// Mean and covariance of weighted candidates; weights sum to one.
pub(crate) fn moments<T: Real, P: Pose<T, K>, const K: usize>(candidates: &[Candidate<T, P>]) -> (P, Symmetric<T, K>)
where
    Dim<K>: Packed,
{
    let weighted = || candidates.iter().map(|candidate| (candidate.ln_weight.exp(), candidate.pose));
    let mean = P::mean(weighted());
    let mut covariance = Symmetric::ZERO;
    for (weight, pose) in weighted() {
        covariance.add_outer(weight, &pose.difference(&mean));
    }
    (mean, covariance)
}

/// Multiplies the weights by the likelihoods and scales them to a sum of one (5.23); returns the logarithm of what the
/// sum was. Where it is zero or not a number, the weights stay and the result is −∞.
pub(crate) fn reweigh<T: Real, P>(candidates: &mut [Candidate<T, P>], ln_likelihoods: &[T]) -> T {
    let products = candidates.iter().zip(ln_likelihoods).map(|(candidate, &ln_l)| candidate.ln_weight + ln_l);
    let total = ln_sum(products);
    if !total.is_finite() {
        return T::NEG_INFINITY;
    }
    for (candidate, &ln_likelihood) in candidates.iter_mut().zip(ln_likelihoods) {
        candidate.ln_weight += ln_likelihood - total;
    }
    total
}

/// N_eff = 1 / Σ ζ², for normalised weights.
pub(crate) fn effective_number<T: Real, P>(candidates: &[Candidate<T, P>]) -> T {
    let sum = candidates.iter().fold(T::ZERO, |sum, candidate| {
        let weight = candidate.ln_weight.exp();
        sum + weight * weight
    });
    T::ONE / sum
}
