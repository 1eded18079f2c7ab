//! Second correction of a static landmark that may be a moving object instead.
//!
//! Pose and map are corrected with the association probabilities s of the static hypothesis. The position of the landmark itself is
//! conditional on that hypothesis, so that it is corrected with the greater weights s/e, e the probability of the hypothesis: the
//! remaining weights s (1/e − 1) are applied with a gain for this position only (Schmidt 1966).

use super::ambiguity::is_ambiguous;
use super::covariance::{Joint, first, symmetric};
use super::innovation_statistics::{InnovationStatistics, LEAST_DETECTED, innovation_statistics};
use super::pending::Pending;
use super::report::Tally;
use super::rows::RowExecutor;
use super::state::Memory;
use crate::numerics::range::is_within_range;
use crate::numerics::vector::applied;
use crate::{Linear, Matrix, Pose, Real, Sensor, Vector};

/// Corrects the position of a landmark, and nothing else, with `rest` times its association probabilities. Corrections of the
/// pose and of this landmark must be in the present error frame; with `reset` they are transformed to it.
#[expect(clippy::too_many_arguments, reason = "every parameter is a part of a correction")]
pub(super) fn correct_position<T: Real, S: Sensor<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>>(
    sensor: &S,
    memory: &mut Memory<'_, S::Pose, Z>,
    index: usize,
    measurements: &[S::Measurement],
    detected: T,
    (rest, reset): (T, bool),
    gate: T,
    rows: &impl RowExecutor<S::Pose, Z>,
) {
    let much = detected * rest >= T::from_f64(LEAST_DETECTED) && rest < T::INFINITY;
    if !much || is_ambiguous(sensor, memory.association_table, index, measurements) {
        return;
    }
    // Only this position may change, so that the error frame must be the present one.
    if reset {
        memory.reset_error_frame(rows);
    }
    // The innovations were counted with the first correction.
    let mut counted = Tally::NOTHING;
    let statistics =
        innovation_statistics(sensor, memory, index, measurements, (rest, false), gate, &mut counted, rows);
    let Some(InnovationStatistics { inverse, step, spread, detected, .. }) = statistics else { return };
    let spread = symmetric::<S::Measurement>(&spread);
    if !(spread.is_finite() && step.as_slice().iter().all(|x| x.is_finite())) {
        return;
    }
    let Memory { header, landmarks, joint, pending, .. } = memory;
    let Some((landmark, own)) = landmarks.get_mut(index).zip(pending.feature(index).copied()) else { return };
    // All are padded with zeros to the dimension of `Z`, the measurement with the most dimensions.
    let learnt = Matrix::with(|row, column| -inverse.at(row, column) * detected);
    let spread = Matrix::with(|row, column| spread.get(row, column));
    let step = Z::with(|z| step.at(z));
    let by = <S::Pose as Pose>::Position::with(|d| own.as_ref().get(d).map_or(T::ZERO, |row| row.dot(&step)));
    if !is_within_range(&(landmark.mean + by)) {
        return;
    }
    joint.correct_position_block::<Z>(index, pending, &learnt, &spread, header.len);
    landmark.mean += by;
    landmark.moved += by;
}

impl<T: Real, P: Pose<Scalar = T>> Joint<'_, P> {
    /// P_mm ← P_mm + (P Hᵀ)_m (L + V) (P Hᵀ)_mᵀ and P_m· ← P_m· + (P Hᵀ)_m L (P Hᵀ)_·ᵀ of one feature, for this number of features
    /// in all, with L = `learnt`, the decrease by the measurement, and V = `spread`, the uncertainty of the association.
    fn correct_position_block<Z: Vector<Scalar = T>>(
        &mut self,
        index: usize,
        common: &Pending<'_, P, Z>,
        learnt: &Linear<Z, Z>,
        spread: &Linear<Z, Z>,
        features: usize,
    ) {
        let rounding = T::ONE + T::EPSILON * T::from_f64(4.0);
        let (pose, Some(own)) = (common.pose(), common.feature(index)) else { return };
        for (row, of_row) in own.as_ref().iter().enumerate() {
            let (at, learnt) = (first::<P>(index) + row, applied::<Z, Z>(learnt, of_row));
            let of_features = common.features().take(features).flat_map(|rows| rows.as_ref());
            for (other, of_other) in pose.as_ref().iter().chain(of_features).enumerate() {
                if other < first::<P>(index) || other >= first::<P>(index + 1) {
                    self.set(at, other, self.get(at, other) + learnt.dot(of_other));
                }
            }
            let weighed = learnt + applied::<Z, Z>(spread, of_row);
            for (column, of_column) in own.as_ref().iter().enumerate().take(row + 1) {
                let statistics = self.get(at, first::<P>(index) + column) + weighed.dot(of_column);
                self.set(
                    at,
                    first::<P>(index) + column,
                    if row == column { statistics * rounding } else { statistics },
                );
            }
        }
    }
}
