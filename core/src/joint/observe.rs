//! Fixes of the pose: with a joint map everything learns of them.

use super::archive::Archive;
use super::covariance::Common;
use super::filter::JointSlam;
use super::map_management::drop_degenerate;
use super::movers::Movers;
use super::state::Memory;
use crate::filter::observe::FixInnovation;
use crate::{Fix, FixReport, Linear, Matrix, Motion, ObserveError, Pose, PoseEstimate, Real, Vector};

impl<T, M, Z, A, V> JointSlam<'_, M, Z, A, V>
where
    T: Real,
    M: Motion<Pose: Pose<Scalar = T>>,
    Z: Vector<Scalar = T>,
    A: Archive<M::Pose>,
    V: Movers<M::Pose>,
{
    /// Takes in a measurement of the pose itself, of at most as many dimensions as the state's `Z`, between any two steps: the Kalman
    /// update of pose and features. One that would take the pose out of range is left out.
    ///
    /// # Errors
    /// The measurement is not finite, its noise not positive definite, or the filter has not been reset; the state is as it was.
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
        let Memory { header, joint, common, .. } = &mut self.memory;
        let mut common = Common::over(common);
        joint.common_with_pose::<F::Measurement, Z>(&fix_innovation.by_pose, header.len, &mut common);
        let pose = common.pose;
        let step = Z::with(|z| fix_innovation.weighed.at(z));
        let by: Linear<F::Measurement, F::Measurement> =
            Matrix::with(|row, column| -fix_innovation.information.at(row, column));
        // Among as many coordinates as the widest measurement has; the others are zero.
        let by = Matrix::with(|row, column| by.at(row, column));
        if !(joint.may_add::<Z>(&pose, &by) && header.may_move::<Z>(&pose, &step)) {
            return Ok(FixReport::left_out(fix_innovation.distance, T::ONE));
        }
        joint.add_product::<Z>(&common, &by, header.len);
        self.memory.inject_correction(&pose, &step);
        self.memory.reset_error_frame();
        // A feature may have been taken farther than the pose.
        drop_degenerate(&mut self.memory);
        let FixInnovation { distance, ln_likelihood, .. } = fix_innovation;
        Ok(FixReport { accepted: true, distance, ln_evidence: ln_likelihood, n_eff: T::ONE })
    }
}
