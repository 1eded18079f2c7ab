//! The innovation statistics of one landmark in a scan: the terms of its probabilistic data association update.

use super::ambiguity::is_ambiguous;
use super::associate::Predicted;
use super::associations::{AssociationRow, probabilities};
use super::covariance::{RowsOf, symmetric};
use super::pending::h_times;
use super::report::Tally;
use super::rows::{OneFeature, RowExecutor};
use super::state::Memory;
use crate::models::OwnNoise;
use crate::numerics::vector::{applied, product};
use crate::{Linear, Matrix, Pose, PositionOf, Real, Sensor, Symmetric, TangentOf, Vector, Zero};

/// Least Σ s with which a feature corrects the pose.
pub(super) const LEAST_DETECTED: f64 = 0.02;

/// A feature corrects nothing if the mean squared Mahalanobis distance of its measurements is above this multiple of
/// the gate. They were within the gate before the corrections by other features: these corrections or the association
/// must be wrong, and the linearisation for small errors no longer holds.
const GATES: f64 = 4.0;

/// Whether a landmark corrects the pose: Σ s = `detected` is large enough, and the association is not ambiguous.
pub(super) fn is_informative_for_pose<T: Real, S: Sensor<Pose: Pose<Scalar = T>>>(
    sensor: &S,
    table: &[AssociationRow<T>],
    index: usize,
    measurements: &[S::Measurement],
    detected: T,
) -> bool {
    detected >= T::from_f64(LEAST_DETECTED) && !is_ambiguous(sensor, table, index, measurements)
}

/// The terms of the update by one landmark.
pub(super) struct InnovationStatistics<P: Pose, Y: Vector, Z: Vector> {
    /// The rows of P Hᵀ of the pose. Those of the features are in the memory of the pending terms.
    pub(super) pose: RowsOf<TangentOf<P>, Z>,
    /// S⁻¹.
    pub(super) inverse: Linear<Y, Y>,
    /// S⁻¹ ν̄.
    pub(super) step: Y,
    /// S⁻¹ (Σ s ν νᵀ − ν̄ ν̄ᵀ) S⁻¹: the uncertainty of the association.
    pub(super) spread: Linear<Y, Y>,
    /// Σ s.
    pub(super) detected: Y::Scalar,
}

/// The terms of the update by one landmark, linearised at the present means, with its association probabilities
/// multiplied by `times`. With `pose_alone` the rows of the other features are not set. `None` if the landmark cannot be measured from here, if its measurements contradict the
/// corrections before, or if rounding errors have made the covariance of the innovation invalid.
#[expect(clippy::too_many_arguments, reason = "every parameter is a part of a correction")]
pub(super) fn innovation_statistics<T: Real, S: Sensor<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>>(
    sensor: &S,
    memory: &mut Memory<'_, S::Pose, Z>,
    index: usize,
    measurements: &[S::Measurement],
    (times, pose_alone): (T, bool),
    gate: T,
    tally: &mut Tally<T>,
    rows: &impl RowExecutor<S::Pose, Z>,
) -> Option<InnovationStatistics<S::Pose, S::Measurement, Z>> {
    memory.make_room(rows);
    let Memory { header, landmarks, joint, pending, association_table, .. } = memory;
    let landmarks = landmarks.get_mut(..header.len)?;
    let landmark = landmarks.get(index)?;
    let Predicted { measurement, by_pose, by_feature } =
        Predicted::of_corrected(sensor, &sensor.frame(&header.pose), header, landmark)?;
    if pose_alone {
        pending.measure::<S::Measurement>(joint, landmarks, index, &by_pose, &by_feature, &OneFeature(index));
    } else {
        pending.measure::<S::Measurement>(joint, landmarks, index, &by_pose, &by_feature, rows);
    }
    let (pose, own) = (pending.pose(), pending.feature(index).map_or(&[][..], |rows| rows.as_ref()));
    let full = h_times::<S::Measurement, TangentOf<S::Pose>, Z>(&by_pose, pose.as_ref())
        + h_times::<S::Measurement, PositionOf<S::Pose>, Z>(&by_feature, own);
    // Only the columns within the dimension of the measurement; the others are zero.
    let full = Matrix::with(|row, column| full.at(row, column));
    let noise = mean_noise(sensor, &measurement, probabilities(association_table, index, measurements));
    let Some(factor) = symmetric::<S::Measurement>(&full).plus(&noise).factor() else {
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
    Some(InnovationStatistics { pose, inverse, step, spread, detected })
}

/// The mean of R over the associated measurements, weighted with their association probabilities; R of the sensor if it
/// is the same for all.
fn mean_noise<'m, T: Real, S: Sensor<Pose: Pose<Scalar = T>, Measurement: 'm>>(
    sensor: &S,
    expected: &S::Measurement,
    associated: impl Iterator<Item = (T, &'m S::Measurement)>,
) -> Symmetric<S::Measurement> {
    let (mut mean, mut sum) = (*sensor.noise(), T::ZERO);
    for (probability, z) in associated {
        let Some(own) = OwnNoise::of(sensor, z, expected) else { return *sensor.noise() };
        sum += probability;
        let share = if sum > T::ZERO { probability / sum } else { T::ZERO };
        mean = Symmetric::from_fn(|row, column| {
            let so_far = mean.get(row, column);
            so_far + (own.covariance.get(row, column) - so_far) * share
        });
    }
    mean
}

/// v vᵀ.
fn outer<Y: Vector>(v: &Y) -> Linear<Y, Y> {
    Matrix::with(|row, column| v.at(row) * v.at(column))
}
