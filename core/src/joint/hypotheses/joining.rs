//! Children with practically the same pose are joined before they are copied and corrected.

use super::super::archive::NoArchive;
use super::super::associate::is_beyond;
use super::super::correct::correction;
use super::super::covariance::row_start;
use super::super::filter::JointSlam;
use super::super::movers::Movers;
use super::super::report::Tally;
use super::super::walk::Estimate;
use super::MOST;
use super::causes::Cause;
use super::children::{Child, Children};
use super::filter::MultiHypothesisSlam;
use crate::models::OnVehicle;
use crate::{CovarianceOf, MeasurementModel, Motion, Pose, PoseEstimate, Real, Serial, Symmetric, TangentOf, Vector};

impl<T: Real, P: Pose<Scalar = T>> Estimate<'_, P> {
    pub(super) fn pose_covariance(&self) -> CovarianceOf<P> {
        Symmetric::from_fn(|row, column| self.numbers.get(row_start(row) + column).copied().unwrap_or(T::ZERO))
    }
}

impl<'s, T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>, const OTHERS: usize>
    MultiHypothesisSlam<'s, M, Z, V, OTHERS>
{
    /// Joins every child whose pose after its correction would be practically that of a likelier one. Returns their number.
    pub(super) fn join<X: MeasurementModel<Pose = M::Pose>>(
        &mut self,
        models: &OnVehicle<'_, X>,
        measurement: &[X::Measurement],
        children: &mut Children<T>,
    ) -> usize {
        let mut joined = 0;
        // Without a cause no pose changes.
        if children.all().len() == 1 || children.all().iter().all(|(child, _)| child.cause == Cause::NEW) {
            return joined;
        }
        let mut kept: [Option<PoseEstimate<M::Pose>>; MOST] = [None; MOST];
        for number in 0..children.all().len() {
            let Some(&(Child { place, cause, .. }, _)) = children.all().get(number) else { break };
            let pose = self.with(place, |slam| slam.pose_after(cause, models, measurement));
            let are_alike = |other: &PoseEstimate<_>| are_alike(other, &pose, self.config.joined_sigmas);
            match kept.iter().position(|other| other.as_ref().is_some_and(are_alike)) {
                Some(other) => {
                    children.join(number, other);
                    joined += 1;
                }
                None => {
                    if let Some(slot) = kept.get_mut(number) {
                        *slot = Some(pose);
                    }
                }
            }
        }
        joined
    }
}

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>>
    JointSlam<'_, M, Z, NoArchive, V>
{
    /// Pose and covariance after [`correct_by`](Self::correct_by), at a fraction of its cost. The state is unchanged.
    pub(super) fn pose_after<X: MeasurementModel<Pose = M::Pose>>(
        &mut self,
        cause: Cause<T>,
        models: &OnVehicle<'_, X>,
        measurement: &[X::Measurement],
    ) -> PoseEstimate<M::Pose> {
        let Self { config, memory, .. } = self;
        if !cause.corrects() {
            return memory.pose_after(None);
        }
        cause.associate(memory);
        let (index, mut tally) = (usize::from(cause.landmark), Tally::NOTHING);
        let correction =
            correction(models.sensor(), memory, index, measurement, true, config.gate, &mut tally, &Serial);
        memory.pose_after(correction.as_ref())
    }
}

/// Whether the pose of `other` is within `sigmas` standard deviations of that of `one`. If the covariance is not positive
/// definite, for example zero, the poses are compared coordinate by coordinate.
fn are_alike<T: Real, P: Pose<Scalar = T>>(one: &PoseEstimate<P>, other: &PoseEstimate<P>, sigmas: T) -> bool {
    let apart = other.mean.difference(&one.mean);
    let covariance = &one.covariance;
    let squared = sigmas * sigmas;
    // One coordinate alone tells most poses apart.
    if (0..TangentOf::<P>::DIMENSION).any(|k| is_beyond(apart.at(k), covariance.get(k, k).at_least(T::ZERO), squared)) {
        return false;
    }
    match covariance.factor() {
        Some(factor) => factor.mahalanobis(&apart) <= squared,
        None => (0..TangentOf::<P>::DIMENSION)
            .all(|k| apart.at(k) * apart.at(k) <= squared * covariance.get(k, k).at_least(T::ZERO)),
    }
}
