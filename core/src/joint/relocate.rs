//! Setting the pose from outside: reset, relocation and additional uncertainty.

use super::archive::Archive;
use super::filter::JointSlam;
use super::movers::Movers;
use super::state::Memory;
use crate::numerics::range::is_within_square;
use crate::{CovarianceOf, Matrix, Motion, Pose, Real, ResetError, Symmetric, TangentOf, Vector, Zero};

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, A: Archive<M::Pose>, V: Movers<M::Pose>>
    JointSlam<'_, M, Z, A, V>
{
    /// [`reset`](Self::reset) with a covariance of the pose.
    ///
    /// # Errors
    /// As for `reset`, or the covariance is not finite or a variance is negative; the state is unchanged.
    pub fn reset_within(&mut self, pose: M::Pose, covariance: &CovarianceOf<M::Pose>) -> Result<(), ResetError> {
        ResetError::check_covariance(covariance)?;
        self.reset(pose)?;
        self.scatter(covariance)
    }

    /// Sets the pose and its covariance, independent of the map, which is unchanged: for a vehicle that was carried to
    /// another place in its map. Tracks of moving objects are removed, because they were near the previous pose.
    ///
    /// # Errors
    /// The pose or the covariance is out of range, or the filter has not been reset; the state is unchanged.
    pub fn relocate(&mut self, pose: M::Pose, covariance: &CovarianceOf<M::Pose>) -> Result<(), ResetError> {
        ResetError::check_pose(&pose)?;
        ResetError::check_covariance(covariance)?;
        self.memory.clamp();
        let Memory { header, joint, .. } = &mut self.memory;
        if !header.started {
            return Err(ResetError::NotStarted);
        }
        (header.pose, header.remainder) = (pose, [T::ZERO; 2]);
        header.watch.reset_sum();
        joint.propagate(&Zero::ZERO, &covariance.to_matrix(), header.len);
        if let Some(mut tracks) = self.movers.tracks() {
            tracks.clear();
        }
        Ok(())
    }

    /// Adds a covariance to that of the pose, if the pose is less certain than the filter assumes.
    ///
    /// # Errors
    /// The covariance is not finite or a variance is negative, or the filter has not been reset; the state is unchanged.
    pub fn scatter(&mut self, covariance: &CovarianceOf<M::Pose>) -> Result<(), ResetError> {
        ResetError::check_covariance(covariance)?;
        self.memory.clamp();
        let Memory { header, joint, .. } = &mut self.memory;
        if !header.started {
            return Err(ResetError::NotStarted);
        }
        header.watch.reset_sum();
        let grown = Symmetric::<TangentOf<M::Pose>>::from_fn(|row, column| {
            joint.get(row, column) + covariance.get(row, column)
        });
        if is_within_square(&grown) {
            let identity = Matrix::with(|row, column| if row == column { T::ONE } else { T::ZERO });
            joint.propagate(&identity, &grown.to_matrix(), header.len);
            if let Some(mut tracks) = self.movers.tracks() {
                tracks.carried(&identity, covariance);
            }
        }
        Ok(())
    }
}
