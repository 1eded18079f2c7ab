//! Fixes, measurements of the pose itself: with a joint map they correct the features too.

use super::archive::Archive;
use super::filter::JointSlam;
use super::map_management::drop_degenerate;
use super::movers::Movers;
use super::state::Memory;
use crate::filter::observe::FixInnovation;
use crate::numerics::vector::applied;
use crate::{
    Fix, FixReport, Linear, Matrix, Motion, ObserveError, Pose, PoseEstimate, Real, Serial, TangentOf, Vector,
};

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, A: Archive<M::Pose>, V: Movers<M::Pose>>
    JointSlam<'_, M, Z, A, V>
{
    /// Corrects pose and features with a measurement of the pose itself (Kalman update), between any two steps. It may have at most
    /// as many dimensions as the state's `Z`. A correction that would move the pose out of range is left out.
    ///
    /// # Errors
    /// The measurement is not finite, its noise is not positive definite, or the filter has not been reset; the state is unchanged.
    pub fn observe<F: Fix<Pose = M::Pose>>(
        &mut self,
        fix: &F,
        measured: &F::Measurement,
    ) -> Result<FixReport<T>, ObserveError> {
        const {
            assert!(
                F::Measurement::DIMENSION <= Z::DIMENSION,
                "the state has no room for measurements of this dimension"
            )
        };
        let Some(PoseEstimate { mean, covariance }) = self.estimate_pose() else {
            return Err(ObserveError::NotStarted);
        };
        ObserveError::check(fix, measured)?;
        let fix_innovation = match FixInnovation::within_gate(fix, measured, &mean, &covariance) {
            Ok(fix_innovation) => fix_innovation,
            Err(distance) => return Ok(FixReport::left_out(distance, T::ONE)),
        };
        self.memory.clamp();
        let Memory { header, joint, pending, .. } = &mut self.memory;
        pending.fill(header.len, |coordinate| {
            let with_pose = joint.run::<TangentOf<M::Pose>>(coordinate, 0);
            let of_measurement = applied::<F::Measurement, TangentOf<M::Pose>>(&fix_innovation.by_pose, &with_pose);
            Z::with(|z| of_measurement.at(z))
        });
        let pose = pending.pose();
        let step = Z::with(|z| fix_innovation.weighed.at(z));
        let by: Linear<F::Measurement, F::Measurement> =
            Matrix::with(|row, column| -fix_innovation.information.at(row, column));
        // The matrix is padded with zeros to the dimension of `Z`, the measurement with the most dimensions.
        let by = Matrix::with(|row, column| by.at(row, column));
        if !(pending.may_push(joint, &by) && header.may_move::<Z>(&pose, &step)) {
            return Ok(FixReport::left_out(fix_innovation.distance, T::ONE));
        }
        self.memory.inject_correction(&pose, &step, &Serial);
        self.memory.pending.push(&by);
        self.memory.reset_error_frame(&Serial);
        // The correction may have moved a feature out of range.
        drop_degenerate(&mut self.memory);
        let FixInnovation { distance, ln_likelihood, .. } = fix_innovation;
        Ok(FixReport { accepted: true, distance, ln_evidence: ln_likelihood, n_eff: T::ONE })
    }
}
