//! Candidates: samples of the vehicle's pose with their weights (5.7, 5.13).

use crate::numerics::ln_sum::ln_sum;
use crate::{Pose, Real, Symmetric, Zero};

/// A sample of the vehicle's pose. Between scans there is one per particle; from the first prediction after a scan to the next scan
/// there are M per particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate<P: Pose> {
    /// x.
    pub pose: P,
    /// ln ζ.
    pub ln_weight: P::Scalar,
    /// Rounding errors of x and y in the last [short](crate::particles::short) step, m.
    pub(crate) remainder: [P::Scalar; 2],
}

impl<P: Pose> Candidate<P> {
    /// All zero; a placeholder for unused memory.
    pub(crate) const ZERO: Self = Self { pose: P::ZERO, ln_weight: P::Scalar::ZERO, remainder: [P::Scalar::ZERO; 2] };

    /// A candidate with this pose and weight.
    pub(crate) fn new(pose: P, ln_weight: P::Scalar) -> Self {
        Self { pose, ln_weight, ..Self::ZERO }
    }
}

/// Σ ζ, which is one except for rounding errors.
pub(crate) fn total_weight<T: Real, P: Pose<Scalar = T>>(candidates: &[Candidate<P>]) -> T {
    candidates.iter().fold(T::ZERO, |sum, candidate| sum + candidate.ln_weight.exp())
}

/// Mean and covariance of candidates whose weights sum to `total`.
pub(crate) fn moments<T: Real, P: Pose<Scalar = T>>(
    candidates: &[Candidate<P>],
    total: T,
) -> (P, Symmetric<P::Tangent>) {
    let weighted = || candidates.iter().map(|candidate| (candidate.ln_weight.exp() / total, candidate.pose));
    let mean = P::mean(weighted());
    let mut covariance = Symmetric::ZERO;
    for (weight, pose) in weighted() {
        covariance.add_outer(weight, &pose.difference(&mean));
    }
    (mean, covariance)
}

/// Number of candidates in a partial sum: weights are summed in parts, and then the parts, so that several threads compute the same
/// bits.
pub const PART: usize = 64;

/// Multiplies the weights by the likelihoods and normalises them (5.23). Returns the logarithm of their sum before that. If the
/// sum is zero or not finite, the weights are unchanged and the result is −∞.
pub(crate) fn reweigh<T: Real, P: Pose<Scalar = T>>(candidates: &mut [Candidate<P>], ln_likelihoods: &[T]) -> T {
    let of_parts = candidates.chunks(PART).zip(ln_likelihoods.chunks(PART));
    let total = ln_sum(of_parts.map(|(part, ln_likelihoods)| ln_products(part, ln_likelihoods)));
    if !total.is_finite() {
        return T::NEG_INFINITY;
    }
    let of_parts = candidates.chunks_mut(PART).zip(ln_likelihoods.chunks(PART));
    let rest = ln_rest(of_parts.map(|(part, ln_likelihoods)| multiply(part, ln_likelihoods, total)));
    if let Some(rest) = rest {
        candidates.iter_mut().for_each(|candidate| candidate.ln_weight -= rest);
    }
    total
}

/// ln Σ ζ L over some candidates.
pub(crate) fn ln_products<T: Real, P: Pose<Scalar = T>>(candidates: &[Candidate<P>], ln_likelihoods: &[T]) -> T {
    ln_sum(candidates.iter().zip(ln_likelihoods).map(|(candidate, &ln_l)| candidate.ln_weight + ln_l))
}

/// Multiplies the weights of some candidates by the likelihoods, and divides them by the total over all. Returns ln Σ ζ of these
/// candidates.
pub(crate) fn multiply<T: Real, P: Pose<Scalar = T>>(
    candidates: &mut [Candidate<P>],
    ln_likelihoods: &[T],
    ln_total: T,
) -> T {
    for (candidate, &ln_likelihood) in candidates.iter_mut().zip(ln_likelihoods) {
        candidate.ln_weight += ln_likelihood - ln_total;
    }
    ln_sum(candidates.iter().map(|candidate| candidate.ln_weight))
}

/// ln of the remaining normalisation constant of all weights, from ln Σ ζ of every part, if it exceeds the tolerance. `ln_total`
/// far from zero has a coarse resolution, and its rounding error is in all weights.
pub(crate) fn ln_rest<T: Real>(of_parts: impl Iterator<Item = T>) -> Option<T> {
    let rest = ln_sum(of_parts);
    (rest.abs() > T::EPSILON * T::from_f64(TOLERATED_ROUNDINGS)).then_some(rest)
}

/// Tolerance of ln Σ ζ = 0, in units of the last place of one: 9.5e-6 in single precision, the error of an ln Σ ζ L up to 256.
const TOLERATED_ROUNDINGS: f64 = 80.0;

/// N_eff = 1 / Σ ζ², for normalised weights.
pub(crate) fn effective_number<T: Real, P: Pose<Scalar = T>>(candidates: &[Candidate<P>]) -> T {
    T::ONE / candidates.chunks(PART).fold(T::ZERO, |sum, part| sum + squares(part))
}

/// Σ ζ² of some candidates.
fn squares<T: Real, P: Pose<Scalar = T>>(candidates: &[Candidate<P>]) -> T {
    candidates.iter().fold(T::ZERO, |sum, candidate| {
        let weight = candidate.ln_weight.exp();
        sum + weight * weight
    })
}

/// Sums over the weights of a part of the candidates.
#[derive(Debug, Clone, Copy)]
pub struct PartSums<T> {
    /// Σ ζ².
    pub squares: T,
    /// Σ ζ.
    pub weight: T,
    /// Index of the last candidate with a weight above 0.
    pub last: Option<usize>,
}

/// Divides the weights of some candidates by the normalisation constant, and writes their cumulative sums.
pub(crate) fn sum_up<T: Real, P: Pose<Scalar = T>>(
    candidates: &mut [Candidate<P>],
    rest: T,
    cumulated: &mut [T],
) -> PartSums<T> {
    let mut sums = PartSums { squares: T::ZERO, weight: T::ZERO, last: None };
    for (place, (candidate, cumulated)) in candidates.iter_mut().zip(cumulated).enumerate() {
        candidate.ln_weight -= rest;
        let weight = candidate.ln_weight.exp();
        sums.squares += weight * weight;
        if weight > T::ZERO {
            sums.weight += weight;
            sums.last = Some(place);
        }
        *cumulated = sums.weight;
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::{Candidate, reweigh, total_weight};
    use crate::{PlanarPose, Pose};
    use std::vec::Vec;

    #[test]
    fn weights_sum_to_one_for_any_likelihood() {
        for ln_likelihood in [-3.0_f32, -150.0, -1500.3, -40_000.7, 1e6] {
            let mut candidates: Vec<Candidate<PlanarPose<f32>>> =
                (0..16).map(|_| Candidate::new(PlanarPose::ZERO, -(16.0_f32.ln()))).collect();
            let ln_likelihoods: Vec<f32> = (0..16).map(|k| ln_likelihood * (1.0 + 1e-5 * k as f32)).collect();
            assert!(reweigh(&mut candidates, &ln_likelihoods).is_finite());
            let total = total_weight(&candidates);
            assert!((total - 1.0).abs() < 1e-5, "ln L {ln_likelihood}: {total}");
        }
    }
}
