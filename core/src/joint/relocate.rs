//! Poses that are set from outside, as of the mixture.

use super::archive::Archive;
use super::filter::JointSlam;
use super::movers::Movers;
use super::state::Memory;
use crate::numerics::range::is_within_square;
use crate::{Matrix, Motion, Pose, Real, ResetError, Symmetric, TangentOf, Vector, Zero};

impl<T, M, Z, A, V> JointSlam<'_, M, Z, A, V>
where
    T: Real,
    M: Motion<Pose: Pose<Scalar = T>>,
    Z: Vector<Scalar = T>,
    A: Archive<M::Pose>,
    V: Movers<M::Pose>,
{
    /// [`reset`](Self::reset) to a pose that is known to a covariance.
    ///
    /// # Errors
    /// As for `reset`, or the covariance is not finite or a variance negative; the state is as it was.
    pub fn reset_within(
        &mut self,
        pose: M::Pose,
        covariance: &Symmetric<TangentOf<M::Pose>>,
    ) -> Result<(), ResetError> {
        ResetError::check_covariance(covariance)?;
        self.reset(pose)?;
        self.scatter(covariance)
    }

    /// Puts the vehicle to this pose, known to a covariance and independent of the map, which stays as it is: for a vehicle that was
    /// carried to another place of what it knows. What moves is forgotten: it was near the place where the vehicle is no longer.
    ///
    /// # Errors
    /// The pose or the covariance is out of range, or the filter has not been reset; the state is as it was.
    pub fn relocate(&mut self, pose: M::Pose, covariance: &Symmetric<TangentOf<M::Pose>>) -> Result<(), ResetError> {
        ResetError::check_pose(&pose)?;
        ResetError::check_covariance(covariance)?;
        self.memory.clamp();
        let Memory { header, joint, .. } = &mut self.memory;
        if !header.started {
            return Err(ResetError::NotStarted);
        }
        (header.pose, header.remainder) = (pose, [T::ZERO; 2]);
        header.watch.calm();
        joint.propagate(&Zero::ZERO, &covariance.to_matrix(), header.len);
        if let Some(mut tracks) = self.movers.tracks() {
            tracks.clear();
        }
        Ok(())
    }

    /// Makes the pose uncertain by a further covariance, for a vehicle that has reason to doubt it.
    ///
    /// # Errors
    /// The covariance is not finite or a variance negative, or the filter has not been reset; the state is as it was.
    pub fn scatter(&mut self, covariance: &Symmetric<TangentOf<M::Pose>>) -> Result<(), ResetError> {
        ResetError::check_covariance(covariance)?;
        self.memory.clamp();
        let Memory { header, joint, .. } = &mut self.memory;
        if !header.started {
            return Err(ResetError::NotStarted);
        }
        header.watch.calm();
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
