//! The update of the joint Gaussian: feature by feature, with all measurements that it has a share of.

use super::associate::Predicted;
use super::covariance::{Common, symmetric};
use super::observe::widened;
use super::state::{Explained, Memory};
use crate::{Dim, Locating, Packed, Pose, Real, Symmetric};
use nalgebra::{SMatrix, SVector};

/// A feature that has less than this share of all detections together says nothing of the pose.
const LEAST_DETECTED: f64 = 0.02;

/// What the corrections of a scan did.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corrected<T> {
    /// Σ s νᵀ S⁻¹ ν, and Σ s.
    pub(super) squares: T,
    pub(super) shares: T,
    /// Corrections left out because rounding had spoilt the covariance of their innovation.
    pub(super) left_out: usize,
}

/// Takes in the scan, feature by feature in the order of their places, each linearised at what the ones before have left; then
/// whether each is there.
pub(super) fn correct<T, P, S, const K: usize, const D: usize, const Z: usize, const Y: usize>(
    sensor: &S,
    memory: &mut Memory<'_, T, P, K, D, Z>,
    measurements: &[SVector<T, Y>],
) -> Corrected<T>
where
    T: Real,
    P: Pose<T, K>,
    S: Locating<T, K, D, Y, Pose = P>,
    Dim<K>: Packed,
    Dim<D>: Packed,
    Dim<Y>: Packed,
{
    let mut corrected = Corrected { squares: T::ZERO, shares: T::ZERO, left_out: 0 };
    for place in 0..memory.known.len {
        let Some(detection) = memory.slots.get(place).map(|slot| slot.detection) else { break };
        if !(detection > T::ZERO) {
            continue;
        }
        let detected = shares(memory.explained, place, measurements).fold(T::ZERO, |sum, (share, _)| sum + share);
        if detected >= T::from_f64(LEAST_DETECTED) && !move_by(sensor, memory, place, measurements, &mut corrected) {
            corrected.left_out += 1;
        }
        if let Some(slot) = memory.slots.get_mut(place) {
            slot.existence = slot.existence.scanned(detection, detected);
            slot.detections += detected;
        }
    }
    corrected
}

/// The measurements that a feature has a share of, and the share s.
fn shares<'m, T: Real, const Z: usize>(
    explained: &'m [Explained<T>],
    place: usize,
    measurements: &'m [SVector<T, Z>],
) -> impl Iterator<Item = (T, &'m SVector<T, Z>)> + 'm {
    explained.iter().zip(measurements).filter_map(move |(explained, z)| {
        let claim = explained.claims().iter().find(|claim| usize::from(claim.feature) == place)?;
        Some((claim.share, z))
    })
}

/// Moves pose and features by one feature's shares; whether it could.
fn move_by<T, P, S, const K: usize, const D: usize, const Z: usize, const Y: usize>(
    sensor: &S,
    memory: &mut Memory<'_, T, P, K, D, Z>,
    place: usize,
    measurements: &[SVector<T, Y>],
    corrected: &mut Corrected<T>,
) -> bool
where
    T: Real,
    P: Pose<T, K>,
    S: Locating<T, K, D, Y, Pose = P>,
    Dim<K>: Packed,
    Dim<D>: Packed,
    Dim<Y>: Packed,
{
    let Memory { known, slots, joint, common, explained, .. } = memory;
    let Some(slot) = slots.get(place) else { return false };
    let Some(predicted) = Predicted::of(sensor, &sensor.frame(&known.pose), &slot.mean) else { return false };
    let Predicted { measurement, by_pose, by_feature } = predicted;
    let features = known.len;
    let mut common = Common { pose: [SVector::zeros(); K], features: common };
    joint.common(place, &by_pose, &by_feature, features, &mut common);
    let own = common.features.get(D * place..D * (place + 1)).unwrap_or(&[]);
    let full = rows::<T, K, Y, Z>(&by_pose, &common.pose) + rows(&by_feature, own);
    let Some(factor) = symmetric(&full).plus(sensor.noise()).factor() else { return false };

    let (mut mean, mut squares, mut detected) = (SVector::<T, Y>::zeros(), SMatrix::<T, Y, Y>::zeros(), T::ZERO);
    for (share, z) in shares(explained, place, measurements) {
        let innovation = sensor.innovation(z, &measurement);
        mean += innovation * share;
        squares += innovation * innovation.transpose() * share;
        detected += share;
        corrected.squares += share * factor.mahalanobis(&innovation);
    }
    corrected.shares += detected;
    // P⁺ = P − β K S Kᵀ + K (Σ s ν νᵀ − ν̄ ν̄ᵀ) Kᵀ = P + (P Hᵀ) B (P Hᵀ)ᵀ.
    let inverse: Symmetric<T, Y> = factor.inverse();
    let inverse = inverse.to_matrix();
    let spread = squares - mean * mean.transpose();
    let by = symmetric(&(inverse * spread * inverse - inverse * detected)).to_matrix();
    let step = inverse * mean;
    if !(by.iter().all(|x| x.is_finite()) && step.iter().all(|x| x.is_finite())) {
        return false;
    }
    joint.add_product(&common, &widened(&by), features);
    let pose = common.pose;
    memory.shift(&pose, &widened(&step));
    true
}

/// H times the rows of (P Hᵀ) of what it is by.
fn rows<T: Real, const N: usize, const Y: usize, const Z: usize>(
    h: &SMatrix<T, Y, N>,
    common: &[SVector<T, Z>],
) -> SMatrix<T, Y, Y> {
    let mut product = SMatrix::<T, Y, Y>::zeros();
    for (column, row) in h.column_iter().zip(common) {
        product += column * row.fixed_rows::<Y>(0).transpose();
    }
    product
}
