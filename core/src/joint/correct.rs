//! The update of the joint Gaussian: feature by feature, with all measurements that it has a share of.

use super::ambiguity::is_ambiguous;
use super::associate::Predicted;
use super::claims::{Explained, detected, shares};
use super::covariance::{Common, RowsOf, symmetric};
use super::movers::Movers;
use super::place::settle_place;
use super::report::Tally;
use super::state::Memory;
use super::track::beside;
use crate::numerics::vector::{applied, product};
use crate::report::watch::Recognised;
use crate::{Linear, Matrix, Pose, PositionOf, Real, Sensor, TangentOf, Vector, Zero};

/// A feature that has less than this share of all detections together says nothing of the pose.
pub(super) const LEAST_DETECTED: f64 = 0.02;

/// Takes in the scan, feature by feature in the order of their places, each linearised at what the ones before have left; then
/// whether each is there.
pub(super) fn correct<T, S, Z, V>(
    sensor: &S,
    memory: &mut Memory<'_, S::Pose, Z>,
    movers: &V,
    measurements: &[S::Measurement],
) -> Tally<T>
where
    T: Real,
    S: Sensor<Pose: Pose<Scalar = T>>,
    Z: Vector<Scalar = T>,
    V: Movers<S::Pose>,
{
    let mut tally = Tally::NOTHING;
    for place in 0..memory.known.len {
        let Some(detection) = memory.slots.get(place).map(|slot| slot.detection) else { break };
        let beside = beside::<T, S::Pose, V, _>(movers, place, memory.explained, measurements);
        if !(detection + beside.expected > T::ZERO) {
            continue;
        }
        let detected = detected(memory.explained, place, measurements);
        let tells = says_of_the_pose(sensor, memory.explained, place, measurements, detected);
        if tells && !move_by(sensor, memory, place, measurements, &mut tally) {
            tally.left_out += 1;
        }
        if let Some(slot) = memory.slots.get_mut(place) {
            let before = slot.existence.in_sight;
            slot.existence = slot.existence.scanned(detection, detected, &beside);
            let given_up = detection * (before - slot.existence.in_sight);
            slot.detections += detected;
            let seen = Recognised { expected: detection * before, detected, given_up };
            tally.count(memory.known.watch.knows(slot.label), seen);
            let there = slot.existence.total();
            if beside.expected > T::ZERO && there > T::ZERO {
                settle_place(sensor, memory, place, measurements, detected, T::ONE / there - T::ONE);
            }
        }
    }
    tally
}

/// Whether anything is to be learnt from a feature with so much of all detections.
pub(super) fn says_of_the_pose<T, S>(
    sensor: &S,
    explained: &[Explained<T>],
    place: usize,
    measurements: &[S::Measurement],
    detected: T,
) -> bool
where
    T: Real,
    S: Sensor<Pose: Pose<Scalar = T>>,
{
    detected >= T::from_f64(LEAST_DETECTED) && !is_ambiguous(sensor, explained, place, measurements)
}

/// What one feature's shares of a scan tell.
pub(super) struct Told<P: Pose, Y: Vector, Z: Vector> {
    /// The rows of P Hᵀ that are the pose's; the features' are in the memory.
    pub(super) pose: RowsOf<TangentOf<P>, Z>,
    /// S⁻¹.
    pub(super) inverse: Linear<Y, Y>,
    /// S⁻¹ ν̄.
    pub(super) step: Y,
    /// S⁻¹ (Σ s ν νᵀ − ν̄ ν̄ᵀ) S⁻¹: what not knowing the cause leaves open.
    pub(super) spread: Linear<Y, Y>,
    /// Σ s.
    pub(super) detected: Y::Scalar,
}

/// What `times` a feature's shares tell, linearised at the means as they are; `None` where it cannot be measured from here or rounding
/// has spoilt the covariance of its innovation.
pub(super) fn tell<T, S, Z>(
    sensor: &S,
    memory: &mut Memory<'_, S::Pose, Z>,
    place: usize,
    measurements: &[S::Measurement],
    times: T,
    tally: &mut Tally<T>,
) -> Option<Told<S::Pose, S::Measurement, Z>>
where
    T: Real,
    S: Sensor<Pose: Pose<Scalar = T>>,
    Z: Vector<Scalar = T>,
{
    let Memory { known, slots, joint, common, explained, .. } = memory;
    let slot = slots.get(place)?;
    let Predicted { measurement, by_pose, by_feature } = Predicted::of(sensor, &sensor.frame(&known.pose), &slot.mean)?;
    let by_pose = known.as_counted::<S::Measurement>(&by_pose, &by_feature, slot);
    let mut common = Common::over(common);
    joint.common::<S::Measurement, Z>(place, &by_pose, &by_feature, known.len, &mut common);
    let own = common.features.get(place).map_or(&[][..], |rows| rows.as_ref());
    let full = rows::<S::Measurement, TangentOf<S::Pose>, Z>(&by_pose, common.pose.as_ref())
        + rows::<S::Measurement, PositionOf<S::Pose>, Z>(&by_feature, own);
    let factor = symmetric::<S::Measurement>(&full).plus(sensor.noise()).factor()?;

    let mut squares: Linear<S::Measurement, S::Measurement> = Zero::ZERO;
    let (mut mean, mut detected) = (S::Measurement::ZERO, T::ZERO);
    for (share, z) in shares(explained, place, measurements) {
        let (share, innovation) = (share * times, sensor.innovation(z, &measurement));
        mean += innovation * share;
        squares = squares + outer(&innovation) * share;
        detected += share;
        tally.squares += share * factor.mahalanobis(&innovation);
    }
    tally.shares += detected;
    let inverse = factor.inverse().to_matrix();
    let of_mean = outer(&mean);
    let open = Matrix::with(|row, column| squares.at(row, column) - of_mean.at(row, column));
    let sandwich = product::<S::Measurement, S::Measurement, S::Measurement>;
    let spread = sandwich(&sandwich(&inverse, &open), &inverse);
    let step = applied::<S::Measurement, S::Measurement>(&inverse, &mean);
    Some(Told { pose: common.pose, inverse, step, spread, detected })
}

/// Moves pose and features by one feature's shares; whether it could.
fn move_by<T, S, Z>(
    sensor: &S,
    memory: &mut Memory<'_, S::Pose, Z>,
    place: usize,
    measurements: &[S::Measurement],
    tally: &mut Tally<T>,
) -> bool
where
    T: Real,
    S: Sensor<Pose: Pose<Scalar = T>>,
    Z: Vector<Scalar = T>,
{
    let Some(told) = tell(sensor, memory, place, measurements, T::ONE, tally) else { return false };
    let Told { pose, inverse, step, spread, detected } = told;
    // P⁺ = P − β K S Kᵀ + K (Σ s ν νᵀ − ν̄ ν̄ᵀ) Kᵀ = P + (P Hᵀ) B (P Hᵀ)ᵀ.
    let by = Matrix::with(|row, column| spread.at(row, column) - inverse.at(row, column) * detected);
    let by = symmetric::<S::Measurement>(&by);
    if !(by.is_finite() && step.as_slice().iter().all(|x| x.is_finite())) {
        return false;
    }
    let Memory { known, joint, common, .. } = memory;
    // Among as many coordinates as the widest measurement has; the others are zero.
    let by = Matrix::with(|row, column| by.get(row, column));
    let step = Z::with(|z| step.at(z));
    if !(joint.may_add::<Z>(&pose, &by) && known.may_move::<Z>(&pose, &step)) {
        return false;
    }
    joint.add_product::<Z>(&Common { pose, features: common }, &by, known.len);
    memory.shift(&pose, &step);
    true
}

/// v vᵀ.
fn outer<Y: Vector>(v: &Y) -> Linear<Y, Y> {
    Matrix::with(|row, column| v.at(row) * v.at(column))
}

/// H times the rows of (P Hᵀ) of what it is by.
fn rows<Y, N, Z>(h: &Linear<Y, N>, common: &[Z]) -> Linear<Y, Y>
where
    Y: Vector,
    N: Vector<Scalar = Y::Scalar>,
    Z: Vector<Scalar = Y::Scalar>,
{
    let rows = || common.iter().take(N::DIMENSION).enumerate();
    Matrix::with(|row, column| rows().fold(Zero::ZERO, |sum, (k, of)| sum + h.at(row, k) * of.at(column)))
}
