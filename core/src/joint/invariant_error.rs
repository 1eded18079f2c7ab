//! The invariant error state, in which the covariance is stored.
//!
//! A small rotation δθ of vehicle and map together about the origin moves a position p by δθ × p, and no measurement
//! can observe it. The covariance must keep this unobservable direction, independent of the linearisation point: an
//! error e of a position that corrections have moved by Δ is therefore expressed as ξ = e − δθ × Δ, with δθ the error
//! of the heading. Without this, every update gains information on the heading that was not measured (Huang, Mourikis &
//! Roumeliotis 2010); with it the errors are those of the invariant filter (Barrau & Bonnabel 2015). Within a scan Δ is
//! stored with every position, and derivatives and corrections are transformed; at its end
//! [`reset_error_frame`](Memory::reset_error_frame) transforms the covariance to that of the actual errors, with Δ = 0.

use super::correct::PoseCorrection;
use super::covariance::{RowsOf, row_start};
use super::landmark::Landmark;
use super::rows::{RowExecutor, lever, turned};
use super::state::{Header, Memory};
use crate::numerics::range::is_within_range;
use crate::{Linear, Matrix, Pose, PoseEstimate, PositionOf, Real, Serial, Symmetric, TangentOf, Vector, Zero};

impl<T: Real, P: Pose<Scalar = T>> Header<P> {
    /// ∂h/∂ξ with respect to the pose, from Hx = ∂h/∂x and Hm = ∂h/∂m: the column of the heading becomes Hx,θ + Hx (ê ×
    /// Δx) + Hm (ê × Δm), the others are unchanged.
    pub(super) fn in_invariant_error<Y: Vector<Scalar = T>>(
        &self,
        by_pose: &Linear<Y, TangentOf<P>>,
        by_feature: &Linear<Y, PositionOf<P>>,
        landmark: &Landmark<PositionOf<P>>,
    ) -> Linear<Y, TangentOf<P>> {
        let Some(heading) = P::HEADING else { return *by_pose };
        let (of_pose, of_feature) = (lever(&self.moved), lever(landmark.moved.as_slice()));
        Matrix::with(|row, column| {
            let own = by_pose.at(row, column);
            if column != heading {
                return own;
            }
            let with_pose = of_pose.iter().enumerate().fold(own, |sum, (k, &by)| sum + by_pose.at(row, k) * by);
            of_feature.iter().enumerate().fold(with_pose, |sum, (k, &by)| sum + by_feature.at(row, k) * by)
        })
    }

    /// The pose after the correction by its rows of P Hᵀ times `step`.
    pub(super) fn moved_by<Z: Vector<Scalar = T>>(&self, pose: &RowsOf<P::Tangent, Z>, step: &Z) -> P {
        self.pose.displaced(&self.step_of(pose, step, turn_of::<P, Z>(pose, step)))
    }

    /// Whether that pose is finite and in range.
    pub(super) fn may_move<Z: Vector<Scalar = T>>(&self, pose: &RowsOf<P::Tangent, Z>, step: &Z) -> bool {
        let moved = self.moved_by(pose, step);
        moved.is_finite() && is_within_range(&moved.coordinates())
    }

    fn step_of<Z: Vector<Scalar = T>>(&self, pose: &RowsOf<P::Tangent, Z>, step: &Z, turn: T) -> P::Tangent {
        turned(P::Tangent::with(|k| pose.as_ref().get(k).map_or(T::ZERO, |row| row.dot(step))), turn, &self.moved)
    }
}

impl<T: Real, P: Pose<Scalar = T>, Z: Vector<Scalar = T>> Memory<'_, P, Z> {
    /// Corrects pose and features by their rows of P Hᵀ times `step`. The rows of the features are those of the next pending term.
    pub(super) fn inject_correction(&mut self, pose: &RowsOf<P::Tangent, Z>, step: &Z, rows: &impl RowExecutor<P, Z>) {
        let turn = turn_of::<P, Z>(pose, step);
        let Self { header, landmarks, joint, pending, .. } = self;
        let by = header.step_of(pose, step, turn);
        header.pose = header.pose.displaced(&by);
        header.moved.iter_mut().zip(by.as_slice()).for_each(|(moved, &by)| *moved += by);
        pending.inject(joint, landmarks.get_mut(..header.len).unwrap_or(&mut []), (step, turn), rows);
    }

    /// The pose and its covariance after a correction, if there is one, and [`reset_error_frame`](Self::reset_error_frame).
    /// Nothing may be pending, and nothing is changed.
    pub(super) fn pose_after(&mut self, correction: Option<&PoseCorrection<P, Z>>) -> PoseEstimate<P> {
        let Self { header, joint, pending, .. } = self;
        let moves = correction.map_or(Zero::ZERO, |PoseCorrection { pose, step, .. }| {
            header.step_of(pose, step, turn_of::<P, Z>(pose, step))
        });
        let mut numbers = <P::Tangent as Vector>::Lower::ZERO;
        numbers.as_mut().iter_mut().zip(joint.used(0)).for_each(|(to, &from)| *to = from);
        if let Some(PoseCorrection { by, .. }) = correction {
            pending.push(by);
        }
        let mut moved = header.moved;
        moved.iter_mut().zip(moves.as_slice()).for_each(|(moved, &by)| *moved += by);
        if let Some(heading) = P::HEADING.filter(|_| !unmoved(&moved)) {
            pending.push_turn(joint, &mut [], heading, &levers_of::<P>(&moved), &Serial);
        }
        if pending.count > 0 {
            pending.add_to_all(numbers.as_mut(), 0);
        }
        pending.count = 0;
        let of = |row, column| numbers.as_ref().get(row_start(row) + column).copied().unwrap_or(T::ZERO);
        PoseEstimate { mean: header.pose.displaced(&moves), covariance: Symmetric::from_fn(of) }
    }

    /// Whether corrections have moved the pose or this landmark since the covariance was last transformed.
    pub(super) fn is_moved(&self, index: usize) -> bool {
        let landmark = self.landmarks.get(index);
        !(unmoved(&self.header.moved) && landmark.is_none_or(|landmark| unmoved(landmark.moved.as_slice())))
    }

    /// Applies the pending terms to the covariance if there is no room for another one.
    pub(super) fn make_room(&mut self, rows: &impl RowExecutor<P, Z>) {
        if self.pending.is_full() {
            self.joint.apply(&mut self.pending, self.header.len, rows);
        }
    }

    /// Applies the pending terms and, if corrections have moved pose or features, transforms the covariance to that of
    /// the actual errors, with Δ = 0.
    pub(super) fn reset_error_frame(&mut self, rows: &impl RowExecutor<P, Z>) {
        self.make_room(rows);
        let Self { header, landmarks, joint, pending, .. } = self;
        let all = || landmarks.iter().take(header.len);
        let Some(heading) = P::HEADING
            .filter(|_| !(unmoved(&header.moved) && all().all(|landmark| unmoved(landmark.moved.as_slice()))))
        else {
            joint.apply(pending, header.len, rows);
            return;
        };
        let of_pose = levers_of::<P>(&header.moved);
        let landmarks = landmarks.get_mut(..header.len).unwrap_or(&mut []);
        pending.push_turn(joint, landmarks, heading, &of_pose, rows);
        joint.apply(pending, header.len, rows);
        header.moved = [T::ZERO; 2];
    }
}

/// The levers of a pose, whose position corrections have moved: 0 of its other coordinates.
fn levers_of<P: Pose>(moved: &[P::Scalar]) -> P::Tangent {
    let levers = lever(moved);
    P::Tangent::with(|k| levers.get(k).copied().unwrap_or(P::Scalar::ZERO))
}

fn unmoved<T: Real>(moved: &[T]) -> bool {
    moved.iter().all(|&by| by == T::ZERO)
}

/// δθ of a correction.
fn turn_of<P: Pose, Z: Vector<Scalar = P::Scalar>>(pose: &RowsOf<P::Tangent, Z>, step: &Z) -> P::Scalar {
    let row = P::HEADING.and_then(|heading| pose.as_ref().get(heading));
    row.map_or(P::Scalar::ZERO, |row| row.dot(step))
}

#[cfg(test)]
mod tests {
    use super::super::associate::Predicted;
    use super::super::landmark::Landmark;
    use super::super::state::JointState;
    use super::lever;
    use crate::*;
    use nalgebra::Vector2;

    #[test]
    fn a_common_rotation_of_vehicle_and_map_changes_no_measurement() {
        // Positions before the scan, and their displacement by corrections since then.
        let (at, by) = ([3.0, -2.0], [0.4, 0.7]);
        let (feature_at, feature_by) = ([40.0, 15.0], [-1.1, 0.3]);
        let mut state = JointState::<PlanarPose<f64>, Vector2<f64>, 1, { joint_numbers(3, 2, 1) }, 1>::new();
        let memory = state.memory();
        memory.header.pose = PlanarPose::new(at[0] + by[0], at[1] + by[1], 0.6);
        memory.header.moved = by;
        let mean = Vector2::from(feature_at) + Vector2::from(feature_by);
        let landmark = Landmark { mean, moved: Vector2::from(feature_by), ..Landmark::ZERO };
        let sensor = RangeBearing::new(0.1, 0.01).unwrap();
        let frame = sensor.frame(&memory.header.pose);
        let Predicted { by_pose, by_feature, .. } = Predicted::of(&sensor, &frame, &landmark.mean).unwrap();
        let counted = memory.header.in_invariant_error::<Vector2<f64>>(&by_pose, &by_feature, &landmark);
        // In the invariant error, a common rotation is δθ and δθ × p, with the positions p before the scan.
        let (turn, feature_turn) = (lever(&at), lever(&feature_at));
        for row in 0..2 {
            let change = |by_pose: &Linear<Vector2<f64>, TangentOf<PlanarPose<f64>>>| {
                let of_feature: f64 = (0..2).map(|k| by_feature[(row, k)] * feature_turn[k]).sum();
                (0..2).map(|k| by_pose[(row, k)] * turn[k]).sum::<f64>() + by_pose[(row, 2)] + of_feature
            };
            assert!(change(&counted).abs() < 1e-12, "{row}: {}", change(&counted));
            assert!(change(&by_pose).abs() > 1e-3, "{row}: {}", change(&by_pose));
        }
    }
}
