//! Setting the pose from outside: reset with a covariance, relocation, and additional uncertainty.

use crate::filter::state::Memory;
use crate::numerics::range::{is_within_range, is_within_square};
use crate::numerics::vector::applied;
use crate::{CovarianceOf, Motion, Pose, Proposal, Real, ResetError, ScPhd, Symmetric, TangentOf, Vector};

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'_, M> {
    /// [`reset`](Self::reset) with a covariance of the pose, in the coordinates of [`Pose::difference`].
    ///
    /// The map of each particle is relative to the pose of that particle. Within about ten scans, resampling leaves particles with
    /// similar poses, and the initial uncertainty of the pose in the world is lost. Therefore give fixes before the first scan, or
    /// do not [gate](crate::PositionFix::gated) them. [`JointSlam`](crate::JointSlam) keeps the correlation of pose and map.
    ///
    /// # Errors
    /// As for `reset`, or the covariance is not finite or a variance is negative; the state is unchanged.
    pub fn reset_within(
        &mut self,
        pose: M::Pose,
        covariance: &CovarianceOf<M::Pose>,
        seed: u64,
    ) -> Result<(), ResetError> {
        ResetError::check_covariance(covariance)?;
        self.reset(pose, seed)?;
        self.scatter(covariance)
    }

    /// Sets the pose of every particle, with a covariance and equal weights, and keeps the maps: for a vehicle that was carried to
    /// another place in its map. The random stream continues.
    ///
    /// # Errors
    /// The pose or the covariance is out of range, or the filter has not been reset; the state is unchanged.
    pub fn relocate(&mut self, pose: M::Pose, covariance: &CovarianceOf<M::Pose>) -> Result<(), ResetError> {
        ResetError::check_pose(&pose)?;
        ResetError::check_covariance(covariance)?;
        let Memory { cursor, pose_covariances, candidates, .. } = &mut self.memory;
        if cursor.noise.is_none() {
            return Err(ResetError::NotStarted);
        }
        (cursor.children, cursor.predicted, cursor.weighed) = (1, false, 0);
        let ln_weight = -T::from_usize(cursor.particles).ln();
        for candidate in candidates.iter_mut().take(cursor.particles) {
            *candidate = crate::Candidate::new(pose, ln_weight);
        }
        pose_covariances.iter_mut().for_each(|pose_covariance| *pose_covariance = Symmetric::ZERO);
        self.scatter(covariance)
    }

    /// Adds a covariance to that of the pose, for a vehicle that has reason to doubt its pose: with the blind proposal each
    /// candidate is displaced by a random sample, with the informed proposal the covariances grow.
    ///
    /// # Errors
    /// The covariance is not finite or a variance is negative, or the filter has not been reset; the state is unchanged.
    pub fn scatter(&mut self, covariance: &CovarianceOf<M::Pose>) -> Result<(), ResetError> {
        ResetError::check_covariance(covariance)?;
        self.memory.clamp();
        let Memory { cursor, pose_covariances, candidates, .. } = &mut self.memory;
        let Some(mut noise) = cursor.noise.clone() else { return Err(ResetError::NotStarted) };
        cursor.watch.reset_sum();
        match self.config.proposal {
            Proposal::Blind => {
                let root = covariance.root();
                for candidate in candidates.iter_mut().take(cursor.candidates()) {
                    let by =
                        applied::<TangentOf<M::Pose>, TangentOf<M::Pose>>(&root, &Vector::with(|_| noise.normal()));
                    let moved = candidate.pose.displaced(&by);
                    if is_within_range(&moved.coordinates()) {
                        candidate.pose = moved;
                    }
                }
                cursor.noise = Some(noise);
            }
            Proposal::Informed(_) => {
                for pose_covariance in pose_covariances.iter_mut().take(cursor.particles) {
                    let grown = pose_covariance.plus(covariance);
                    if is_within_square(&grown) {
                        *pose_covariance = grown;
                    }
                }
                // The next scan samples from the covariances.
                cursor.predicted = true;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::*;
    use nalgebra::{Vector2, Vector3};
    use std::boxed::Box;

    type Memory<const N: usize> = State<PlanarPose<f64>, N, N, MapMemory<Static<Vector2<f64>>, N, 64, 16, 64>>;

    fn doubt() -> Symmetric<Vector3<f64>> {
        Symmetric::from_fn(|row, column| match (row, column) {
            (0, 0) => 0.25,
            (1, 1) => 0.16,
            (1, 0) => 0.1,
            (2, 2) => 0.01,
            _ => 0.0,
        })
    }

    fn motion() -> Unicycle<f64> {
        Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.1)).unwrap()
    }

    #[test]
    fn blind_particles_are_samples_of_the_given_covariance() {
        let mut state = Box::new(Memory::<4000>::new());
        let config = Config { particles: 4000, ..Config::default() };
        let mut slam = ScPhd::new(motion(), config, &mut *state).unwrap();
        assert_eq!(slam.scatter(&doubt()), Err(ResetError::NotStarted));
        slam.reset_within(PlanarPose::new(3.0, -1.0, 3.1), &doubt(), 2).unwrap();
        let PoseEstimate { mean, covariance } = slam.estimate_pose().unwrap();
        assert!(mean.difference(&PlanarPose::new(3.0, -1.0, 3.1)).norm() < 0.03, "{mean:?}");
        assert!((covariance.to_matrix() - doubt().to_matrix()).norm() < 0.02, "{covariance:?}");
        assert_eq!(slam.audit(), Ok(()));
    }

    #[test]
    fn an_informed_filter_keeps_the_covariance_and_a_relocated_vehicle_its_map() {
        let informed = Proposal::Informed(Informed { sampled_fraction: 0.0, ..Informed::default() });
        let mut state = Box::new(Memory::<2>::new());
        let config = Config { particles: 2, proposal: informed, ..Config::default() };
        let mut slam = ScPhd::new(motion(), config, &mut *state).unwrap();
        slam.reset_within(PlanarPose::ZERO, &doubt(), 2).unwrap();
        assert_eq!(slam.estimate_pose().unwrap().covariance, doubt());
        let landmark = Component {
            mean: Vector2::new(5.0, 2.0),
            covariance: Symmetric::from_diagonal([1e-4, 1e-4]),
            ..Component::ZERO
        };
        slam.load_map(&[landmark]).unwrap();
        slam.relocate(PlanarPose::new(8.0, 2.0, 3.0), &doubt()).unwrap();
        assert_eq!(slam.map(1).count(), 1);
        let window = RangeBearingWindow::full_circle(20.0, 0.9).unwrap();
        let sensing = Sensing::range_bearing([0.05, 0.01], window, 0.1).unwrap();
        let mut scratch = DetectorMemory::<Vector2<f64>, 8>::new();
        let mut lidar = Detector::new(sensing, Births::of_static(0.001)).unwrap().over(&mut scratch).unwrap();
        // From (8.3, 2) with heading π the landmark is 3.3 m straight ahead.
        slam.scan(&mut lidar, &[Vector2::new(3.3, 0.0)]).unwrap();
        let estimate = slam.estimate_pose().unwrap();
        let range = (estimate.mean.x_m - 5.0).hypot(estimate.mean.y_m - 2.0);
        assert!((range - 3.3).abs() < 0.02, "{estimate:?}");
        assert!(estimate.covariance.get(0, 0) < 0.5 * doubt().get(0, 0));
    }

    #[test]
    fn the_joint_map_relocates() {
        type Joint = JointState<PlanarPose<f64>, Vector2<f64>, 4, { joint_numbers(3, 2, 4) }, 8>;
        let mut state = Box::new(Joint::new());
        let mut slam = JointSlam::new(motion(), JointConfig::default(), &mut *state).unwrap();
        assert_eq!(slam.relocate(PlanarPose::ZERO, &doubt()), Err(ResetError::NotStarted));
        slam.reset_within(PlanarPose::ZERO, &doubt()).unwrap();
        slam.scatter(&doubt()).unwrap();
        assert_eq!(slam.estimate_pose().unwrap().covariance, doubt().scaled(2.0));
        slam.relocate(PlanarPose::new(1.0, 2.0, 0.0), &doubt()).unwrap();
        let estimate = slam.estimate_pose().unwrap();
        assert_eq!((estimate.mean, estimate.covariance), (PlanarPose::new(1.0, 2.0, 0.0), doubt()));
        let bad = Symmetric::from_diagonal([1.0, -1.0, 0.0]);
        for refused in [slam.scatter(&bad), slam.reset_within(PlanarPose::ZERO, &bad)] {
            assert_eq!(refused, Err(ResetError::Covariance));
        }
    }
}
