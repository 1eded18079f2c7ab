//! Fixes of the pose: with a joint map everything learns of them.

use super::covariance::Common;
use super::filter::JointSlam;
use super::state::Memory;
use crate::observe::Explained;
use crate::{Dim, Fix, FixReport, Motion, ObserveError, Packed, PoseEstimate, Real};
use nalgebra::{SMatrix, SVector};

impl<T, M, const K: usize, const D: usize, const Z: usize> JointSlam<'_, T, M, K, D, Z>
where
    T: Real,
    M: Motion<T, K>,
    Dim<K>: Packed,
    Dim<D>: Packed,
    Dim<Z>: Packed,
{
    /// Takes in a measurement of the pose itself, of Y dimensions, at most as many as the state's Z, between any two steps: the Kalman
    /// update of pose and features.
    ///
    /// # Errors
    /// The measurement is not finite, its noise not positive definite, or the filter has not been reset; the state is as it was.
    pub fn observe<F, const Y: usize>(
        &mut self,
        fix: &F,
        measured: &SVector<T, Y>,
    ) -> Result<FixReport<T>, ObserveError>
    where
        F: Fix<T, K, Y, Pose = M::Pose>,
        Dim<Y>: Packed,
    {
        const { assert!(Y <= Z, "the state has no room for measurements of this dimension") };
        let Some(PoseEstimate { mean, covariance }) = self.estimate_pose() else {
            return Err(ObserveError::NotStarted);
        };
        ObserveError::check(fix, measured)?;
        let explained = match Explained::within_gate(fix, measured, &mean, &covariance) {
            Ok(explained) => explained,
            Err(distance) => return Ok(FixReport::left_out(distance, T::ONE)),
        };
        let Memory { known, joint, common, .. } = &mut self.memory;
        let mut common = Common { pose: [SVector::zeros(); K], features: common };
        joint.common_with_pose(&explained.by_pose, known.len, &mut common);
        let by = -explained.information;
        joint.add_product(&common, &widened(&by), known.len);
        let pose = common.pose;
        self.memory.shift(&pose, &widened(&explained.weighed));
        self.memory.follow();
        let Explained { distance, ln_likelihood, .. } = explained;
        Ok(FixReport { accepted: true, distance, ln_evidence: ln_likelihood, n_eff: T::ONE })
    }
}

/// The same among as many coordinates as the widest measurement has; the others are zero.
pub(super) fn widened<T: Real, const R: usize, const C: usize, const ROWS: usize, const COLUMNS: usize>(
    narrow: &SMatrix<T, R, C>,
) -> SMatrix<T, ROWS, COLUMNS> {
    SMatrix::from_fn(|row, column| narrow.get((row, column)).copied().unwrap_or(T::ZERO))
}
