//! The innovation statistics of one landmark in a scan: the terms of its probabilistic data association update.

use super::ambiguity::is_ambiguous;
use super::associate::Predicted;
use super::associations::{AssociationRow, probabilities};
use super::covariance::{Common, RowsOf, symmetric};
use super::report::Tally;
use super::state::Memory;
use crate::numerics::vector::{applied, product};
use crate::{Linear, Matrix, Pose, PositionOf, Real, Sensor, TangentOf, Vector, Zero};

/// A feature that has less than this share of all detections together says nothing of the pose.
pub(super) const LEAST_DETECTED: f64 = 0.02;

/// A feature whose measurements lie further than this many gates from where the features before it have left pose and map says nothing in
/// this scan: it was within the gate before them, so that one of both is wrong, and what is linear in small errors is no more.
const GATES: f64 = 4.0;

/// Whether the pose is corrected by a landmark with so much of all detections.
pub(super) fn is_informative_for_pose<T, S>(
    sensor: &S,
    table: &[AssociationRow<T>],
    index: usize,
    measurements: &[S::Measurement],
    detected: T,
) -> bool
where
    T: Real,
    S: Sensor<Pose: Pose<Scalar = T>>,
{
    detected >= T::from_f64(LEAST_DETECTED) && !is_ambiguous(sensor, table, index, measurements)
}

/// The terms of the update by one landmark.
pub(super) struct InnovationStatistics<P: Pose, Y: Vector, Z: Vector> {
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

/// What `times` a feature's shares tell, linearised at the means as they are; `None` where it cannot be measured from here, what was taken in before
/// contradicts it, or rounding has spoilt the covariance of its innovation.
pub(super) fn innovation_statistics<T, S, Z>(
    sensor: &S,
    memory: &mut Memory<'_, S::Pose, Z>,
    index: usize,
    measurements: &[S::Measurement],
    times: T,
    gate: T,
    tally: &mut Tally<T>,
) -> Option<InnovationStatistics<S::Pose, S::Measurement, Z>>
where
    T: Real,
    S: Sensor<Pose: Pose<Scalar = T>>,
    Z: Vector<Scalar = T>,
{
    let Memory { header, landmarks, joint, common, association_table, .. } = memory;
    let landmark = landmarks.get(index)?;
    let Predicted { measurement, by_pose, by_feature } =
        Predicted::of(sensor, &sensor.frame(&header.pose), &landmark.mean)?;
    let by_pose = header.in_invariant_error::<S::Measurement>(&by_pose, &by_feature, landmark);
    let mut common = Common::over(common);
    joint.common::<S::Measurement, Z>(index, &by_pose, &by_feature, header.len, &mut common);
    let own = common.features.get(index).map_or(&[][..], |rows| rows.as_ref());
    let full = rows::<S::Measurement, TangentOf<S::Pose>, Z>(&by_pose, common.pose.as_ref())
        + rows::<S::Measurement, PositionOf<S::Pose>, Z>(&by_feature, own);
    let Some(factor) = symmetric::<S::Measurement>(&full).plus(sensor.noise()).factor() else {
        tally.left_out += 1;
        return None;
    };

    let mut squares: Linear<S::Measurement, S::Measurement> = Zero::ZERO;
    let (mut mean, mut detected, mut distance) = (S::Measurement::ZERO, T::ZERO, T::ZERO);
    for (probability, z) in probabilities(association_table, index, measurements) {
        let (probability, innovation) = (probability * times, sensor.innovation(z, &measurement));
        mean += innovation * probability;
        squares = squares + outer(&innovation) * probability;
        detected += probability;
        distance += probability * factor.mahalanobis(&innovation);
    }
    tally.squares += distance;
    tally.probabilities += detected;
    if distance > T::from_f64(GATES) * gate * detected {
        return None;
    }
    let inverse = factor.inverse().to_matrix();
    let of_mean = outer(&mean);
    let open = Matrix::with(|row, column| squares.at(row, column) - of_mean.at(row, column));
    let sandwich = product::<S::Measurement, S::Measurement, S::Measurement>;
    let spread = sandwich(&sandwich(&inverse, &open), &inverse);
    let step = applied::<S::Measurement, S::Measurement>(&inverse, &mean);
    Some(InnovationStatistics { pose: common.pose, inverse, step, spread, detected })
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
