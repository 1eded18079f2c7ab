//! Correction of the joint Gaussian: one feature after the other, each with all measurements that are associated with it.

use super::associations::detected;
use super::covariance::{RowsOf, symmetric};
use super::existence::MovingHypothesis;
use super::innovation_statistics::{InnovationStatistics, innovation_statistics, is_informative_for_pose};
use super::movers::Movers;
use super::position_update::correct_position;
use super::report::Tally;
use super::rows::RowExecutor;
use super::state::Memory;
use super::track::moving_hypothesis;
use crate::report::watch::Recognised;
use crate::{Linear, Matrix, Pose, Real, Sensor, TangentOf, Vector};

/// Corrects pose and map with a scan: one feature after the other in the order of their indices, each linearised at the mean that
/// the corrections before it have left. The existence probabilities of a feature are updated after its correction.
pub(super) fn correct<T: Real, S: Sensor<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<S::Pose>>(
    sensor: &S,
    memory: &mut Memory<'_, S::Pose, Z>,
    movers: &V,
    measurements: &[S::Measurement],
    gate: T,
    rows: &impl RowExecutor<S::Pose, Z>,
) -> Tally<T> {
    let mut tally = Tally::NOTHING;
    for index in 0..memory.header.len {
        let Some(detection) = memory.landmarks.get(index).map(|landmark| landmark.detection) else { break };
        let moving = moving_hypothesis::<T, S::Pose, V, _>(movers, index, memory.association_table, measurements);
        if !(detection + moving.expected > T::ZERO) {
            continue;
        }
        let detected = detected(memory.association_table, index, measurements);
        let tells = is_informative_for_pose(sensor, memory.association_table, index, measurements, detected);
        if tells {
            move_by(sensor, memory, index, measurements, gate, &mut tally, rows);
        }
        let position_factor = update_existence(memory, index, detected, &moving, &mut tally);
        if let Some(times) = position_factor.filter(|_| movers.are_tracked()) {
            correct_position(sensor, memory, index, measurements, detected, (times, true), gate, rows);
        }
    }
    tally
}

/// Updates the existence probability of one landmark with `detected`, the sum of its association probabilities. If it may be a
/// moving object instead, returns the factor on these probabilities for the additional correction of its position alone.
#[inline]
pub(super) fn update_existence<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>>(
    memory: &mut Memory<'_, P, Z>,
    index: usize,
    detected: T,
    moving: &MovingHypothesis<T>,
    tally: &mut Tally<T>,
) -> Option<T> {
    let Memory { header, landmarks, .. } = memory;
    let landmark = landmarks.get_mut(index)?;
    let (detection, before) = (landmark.detection, landmark.existence.visible);
    landmark.existence = landmark.existence.scanned(detection, detected, moving);
    let existence_loss = detection * (before - landmark.existence.visible);
    landmark.detections += detected;
    let seen = Recognised { expected: detection * before, detected, existence_loss };
    tally.count(header.watch.knows(landmark.label, header.next_label), seen);
    let there = landmark.existence.total();
    (moving.expected > T::ZERO && there > T::ZERO).then(|| T::ONE / there - T::ONE)
}

/// Corrects pose and map with the measurements that are associated with one feature, if the result is valid.
pub(super) fn move_by<T: Real, S: Sensor<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>>(
    sensor: &S,
    memory: &mut Memory<'_, S::Pose, Z>,
    index: usize,
    measurements: &[S::Measurement],
    gate: T,
    tally: &mut Tally<T>,
    rows: &impl RowExecutor<S::Pose, Z>,
) {
    let Some(PoseCorrection { pose, step, by }) =
        correction(sensor, memory, index, measurements, false, gate, tally, rows)
    else {
        return;
    };
    memory.inject_correction(&pose, &step, rows);
    memory.pending.push(&by);
}

/// A correction of pose and map that is valid.
pub(super) struct PoseCorrection<P: Pose, Z: Vector> {
    /// The rows of P Hᵀ of the pose. Those of the features are those of the next pending term.
    pub(super) pose: RowsOf<TangentOf<P>, Z>,
    /// S⁻¹ ν̄.
    pub(super) step: Z,
    /// B of P⁺ = P + (P Hᵀ) B (P Hᵀ)ᵀ.
    pub(super) by: Linear<Z, Z>,
}

/// The correction with the measurements that are associated with one feature; `None` without one, or if its result would be
/// invalid. With `pose_alone` the rows of the other features are not set. Both `step` and `by` are padded with zeros to the dimension
/// of `Z`, the measurement with the most dimensions.
#[expect(clippy::too_many_arguments, reason = "every parameter is a part of a correction")]
pub(super) fn correction<T: Real, S: Sensor<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>>(
    sensor: &S,
    memory: &mut Memory<'_, S::Pose, Z>,
    index: usize,
    measurements: &[S::Measurement],
    pose_alone: bool,
    gate: T,
    tally: &mut Tally<T>,
    rows: &impl RowExecutor<S::Pose, Z>,
) -> Option<PoseCorrection<S::Pose, Z>> {
    let statistics =
        innovation_statistics(sensor, memory, index, measurements, (T::ONE, pose_alone), gate, tally, rows)?;
    let InnovationStatistics { pose, inverse, step, spread, detected } = statistics;
    // P⁺ = P − β K S Kᵀ + K (Σ s ν νᵀ − ν̄ ν̄ᵀ) Kᵀ = P + (P Hᵀ) B (P Hᵀ)ᵀ.
    let by = Matrix::with(|row, column| spread.at(row, column) - inverse.at(row, column) * detected);
    let by = symmetric::<S::Measurement>(&by);
    if !(by.is_finite() && step.as_slice().iter().all(|x| x.is_finite())) {
        tally.left_out += 1;
        return None;
    }
    let Memory { header, joint, pending, .. } = memory;
    let by = Matrix::with(|row, column| by.get(row, column));
    let step = Z::with(|z| step.at(z));
    if !(pending.may_push(joint, &by) && header.may_move::<Z>(&pose, &step)) {
        tally.left_out += 1;
        return None;
    }
    Some(PoseCorrection { pose, step, by })
}
