//! The update of the joint Gaussian: feature by feature, with all measurements that it has a share of.

use super::associate::Predicted;
use super::covariance::{Common, symmetric};
use super::state::{Explained, Memory};
use crate::numerics::vector::{applied, product};
use crate::report::watch::Recognised;
use crate::{Linear, Matrix, Pose, PositionOf, Real, Sensor, Symmetric, TangentOf, Vector, Zero};

/// A feature that has less than this share of all detections together says nothing of the pose.
pub(super) const LEAST_DETECTED: f64 = 0.02;

/// What the corrections of a scan did.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corrected<T> {
    /// Σ s νᵀ S⁻¹ ν, and Σ s.
    pub(super) squares: T,
    pub(super) shares: T,
    /// Σ p_D v over the features in view.
    pub(super) expected: T,
    /// Their shares of all measurements.
    pub(super) detected: T,
    /// What became of the known ones.
    pub(super) known: Recognised<T>,
    /// Corrections left out because rounding had spoilt the covariance of their innovation.
    pub(super) left_out: usize,
}

/// Takes in the scan, feature by feature in the order of their places, each linearised at what the ones before have left; then
/// whether each is there.
pub(super) fn correct<T, S, Z>(
    sensor: &S,
    memory: &mut Memory<'_, S::Pose, Z>,
    measurements: &[S::Measurement],
) -> Corrected<T>
where
    T: Real,
    S: Sensor<Pose: Pose<Scalar = T>>,
    Z: Vector<Scalar = T>,
{
    let mut corrected = Corrected {
        squares: T::ZERO,
        shares: T::ZERO,
        expected: T::ZERO,
        detected: T::ZERO,
        known: Recognised::NOTHING,
        left_out: 0,
    };
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
            let (before, is_known) = (slot.existence.in_sight, memory.known.watch.knows(slot.label));
            slot.existence = slot.existence.scanned(detection, detected);
            corrected.expected += detection * before;
            corrected.detected += detected;
            if is_known {
                corrected.known.expected += detection * before;
                corrected.known.detected += detected;
                corrected.known.given_up += detection * (before - slot.existence.in_sight);
            }
            slot.detections += detected;
        }
    }
    corrected
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

/// Moves pose and features by one feature's shares; whether it could.
fn move_by<T, S, Z>(
    sensor: &S,
    memory: &mut Memory<'_, S::Pose, Z>,
    place: usize,
    measurements: &[S::Measurement],
    corrected: &mut Corrected<T>,
) -> bool
where
    T: Real,
    S: Sensor<Pose: Pose<Scalar = T>>,
    Z: Vector<Scalar = T>,
{
    let Memory { known, slots, joint, common, explained, .. } = memory;
    let Some(slot) = slots.get(place) else { return false };
    let Some(predicted) = Predicted::of(sensor, &sensor.frame(&known.pose), &slot.mean) else { return false };
    let Predicted { measurement, by_pose, by_feature } = predicted;
    let features = known.len;
    let mut common = Common::over(common);
    joint.common::<S::Measurement, Z>(place, &by_pose, &by_feature, features, &mut common);
    let own = common.features.get(place).map_or(&[][..], |rows| rows.as_ref());
    let full = rows::<S::Measurement, TangentOf<S::Pose>, Z>(&by_pose, common.pose.as_ref())
        + rows::<S::Measurement, PositionOf<S::Pose>, Z>(&by_feature, own);
    let Some(factor) = symmetric::<S::Measurement>(&full).plus(sensor.noise()).factor() else { return false };

    let mut squares: Linear<S::Measurement, S::Measurement> = Zero::ZERO;
    let (mut mean, mut detected) = (S::Measurement::ZERO, T::ZERO);
    for (share, z) in shares(explained, place, measurements) {
        let innovation = sensor.innovation(z, &measurement);
        mean += innovation * share;
        squares = squares + outer(&innovation) * share;
        detected += share;
        corrected.squares += share * factor.mahalanobis(&innovation);
    }
    corrected.shares += detected;
    // P⁺ = P − β K S Kᵀ + K (Σ s ν νᵀ − ν̄ ν̄ᵀ) Kᵀ = P + (P Hᵀ) B (P Hᵀ)ᵀ.
    let (by, step) = steps::<S::Measurement>(&factor.inverse(), &squares, &mean, detected);
    if !(by.is_finite() && step.as_slice().iter().all(|x| x.is_finite())) {
        return false;
    }
    // Among as many coordinates as the widest measurement has; the others are zero.
    joint.add_product::<Z>(&common, &Matrix::with(|row, column| by.get(row, column)), features);
    let pose = common.pose;
    memory.shift(&pose, &Z::with(|z| step.at(z)));
    true
}

/// How the covariance steps, and how the state does: B and S⁻¹ ν̄.
fn steps<Y: Vector>(
    inverse: &Symmetric<Y>,
    squares: &Linear<Y, Y>,
    mean: &Y,
    detected: Y::Scalar,
) -> (Symmetric<Y>, Y) {
    let inverse = inverse.to_matrix();
    let of_mean = outer(mean);
    let spread = Matrix::with(|row, column| squares.at(row, column) - of_mean.at(row, column));
    let within = product::<Y, Y, Y>(&product::<Y, Y, Y>(&inverse, &spread), &inverse);
    let by = Matrix::with(|row, column| within.at(row, column) - inverse.at(row, column) * detected);
    (symmetric::<Y>(&by), applied::<Y, Y>(&inverse, mean))
}

/// v vᵀ.
pub(super) fn outer<Y: Vector>(v: &Y) -> Linear<Y, Y> {
    Matrix::with(|row, column| v.at(row) * v.at(column))
}

/// H times the rows of (P Hᵀ) of what it is by.
pub(super) fn rows<Y, N, Z>(h: &Linear<Y, N>, common: &[Z]) -> Linear<Y, Y>
where
    Y: Vector,
    N: Vector<Scalar = Y::Scalar>,
    Z: Vector<Scalar = Y::Scalar>,
{
    let rows = || common.iter().take(N::DIMENSION).enumerate();
    Matrix::with(|row, column| rows().fold(Zero::ZERO, |sum, (k, of)| sum + h.at(row, k) * of.at(column)))
}
