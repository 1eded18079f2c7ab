//! Fixes: measurements of the pose itself, between any two steps.

use crate::filter::state::Memory;
use crate::numerics::range::{is_within_range, is_within_square};
use crate::numerics::vector::{applied, product};
use crate::particles::candidate::{effective_number, reweigh};
use crate::{
    CovarianceOf, Fix, Linear, Matrix, Motion, ObserveError, Pose, PoseEstimate, Real, ScPhd, ScalarOf, Symmetric,
    TangentOf, Vector,
};

/// Result of a fix.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct FixReport<T> {
    /// Whether the fix was used: it was within its gate, and could be predicted from the pose of the vehicle.
    pub accepted: bool,
    /// Squared Mahalanobis distance of the innovation, νᵀ S⁻¹ ν.
    pub distance: T,
    /// ln of the likelihood of the fix given all previous inputs; 0 if it was not used.
    pub ln_evidence: T,
    /// Effective number of candidates after the fix.
    pub n_eff: T,
}

impl<T: Real> FixReport<T> {
    /// The report of a fix that was not used.
    pub(crate) fn left_out(distance: T, n_eff: T) -> Self {
        Self { accepted: false, distance, ln_evidence: T::ZERO, n_eff }
    }
}

/// The innovation of a fix, given a Gaussian pose.
pub(crate) struct FixInnovation<F: Fix> {
    /// z ⊖ ẑ.
    pub(crate) innovation: F::Measurement,
    /// H = ∂h/∂x.
    pub(crate) by_pose: Linear<F::Measurement, TangentOf<F::Pose>>,
    /// S⁻¹ ν.
    pub(crate) weighed: F::Measurement,
    /// S⁻¹.
    pub(crate) information: Linear<F::Measurement, F::Measurement>,
    /// νᵀ S⁻¹ ν.
    pub(crate) distance: ScalarOf<F::Pose>,
    /// ln N(ν; 0, S).
    pub(crate) ln_likelihood: ScalarOf<F::Pose>,
}

impl<T: Real, F: Fix<Pose: Pose<Scalar = T>>> FixInnovation<F> {
    /// The innovation given a pose with this covariance. The error is the squared distance of a fix beyond its gate, or infinity
    /// if it cannot be predicted.
    pub(crate) fn within_gate(
        fix: &F,
        measured: &F::Measurement,
        pose: &F::Pose,
        covariance: &CovarianceOf<F::Pose>,
    ) -> Result<Self, T> {
        let fix_innovation = Self::of(fix, measured, pose, covariance).ok_or(T::INFINITY)?;
        // The comparison is written so that NaN is rejected.
        if fix_innovation.distance <= fix.gate() { Ok(fix_innovation) } else { Err(fix_innovation.distance) }
    }

    /// S = H P Hᵀ + R; `None` if the fix cannot be predicted from this pose, or the result is not finite.
    pub(crate) fn of(
        fix: &F,
        measured: &F::Measurement,
        pose: &F::Pose,
        covariance: &CovarianceOf<F::Pose>,
    ) -> Option<Self> {
        let innovation = fix.innovation(measured, &fix.expect(pose)?);
        let by_pose = fix.by_pose(pose);
        let factor = covariance.congruence::<F::Measurement>(&by_pose).plus(fix.noise()).factor()?;
        let (weighed, distance) = (factor.solve(&innovation), factor.mahalanobis(&innovation));
        let ln_likelihood = factor.ln_peak() - distance * T::from_f64(0.5);
        let finite = by_pose.as_slice().iter().chain(weighed.as_slice()).all(|x| x.is_finite());
        let information = factor.inverse().to_matrix();
        let fix_innovation = Self { innovation, by_pose, weighed, information, distance, ln_likelihood };
        (finite && ln_likelihood.is_finite()).then_some(fix_innovation)
    }
}

/// The tangent vector of a vehicle's pose.
type K<M> = TangentOf<<M as Motion>::Pose>;

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>> ScPhd<'_, M> {
    /// Updates the candidates with a measurement of the pose itself, between any two steps. The weight of every candidate is
    /// multiplied by the likelihood of the fix; a candidate that has a covariance (informed proposal) is corrected by a Kalman
    /// update. The maps are unchanged: the mixture does not contain the correlation of its features with the pose, which a [joint
    /// map](crate::JointSlam::observe) does. If resampling is necessary, the next scan does it.
    ///
    /// # Errors
    /// The measurement is not finite, its noise is not positive definite, or the filter has not been reset; the state is unchanged.
    pub fn observe<F: Fix<Pose = M::Pose>>(
        &mut self,
        fix: &F,
        measured: &F::Measurement,
    ) -> Result<FixReport<T>, ObserveError> {
        self.memory.clamp();
        let Some(PoseEstimate { mean, covariance }) = self.estimate_pose() else {
            return Err(ObserveError::NotStarted);
        };
        ObserveError::check(fix, measured)?;
        let Memory { cursor, pose_covariances, candidates, ln_likelihoods, .. } = &mut self.memory;
        let children = cursor.children;
        let candidates = candidates.get_mut(..cursor.candidates()).unwrap_or(&mut []);
        let n_eff = effective_number(candidates);
        let whole = match FixInnovation::within_gate(fix, measured, &mean, &covariance) {
            Ok(whole) => whole,
            Err(distance) => return Ok(FixReport::left_out(distance, n_eff)),
        };
        for (index, (candidate, ln_likelihood)) in candidates.iter_mut().zip(ln_likelihoods.iter_mut()).enumerate() {
            *ln_likelihood = T::NEG_INFINITY;
            // With several samples of a particle, their poses have no covariance.
            let Some(pose_covariance) = pose_covariances.get_mut(index.checked_div(children).unwrap_or(0)) else {
                continue;
            };
            let Some(fix_innovation) = FixInnovation::of(fix, measured, &candidate.pose, pose_covariance) else {
                continue;
            };
            *ln_likelihood = fix_innovation.ln_likelihood;
            if *pose_covariance == Symmetric::ZERO {
                continue;
            }
            let cross = pose_covariance.times_transpose::<K<M>, F::Measurement>(&fix_innovation.by_pose);
            let gain = product::<K<M>, F::Measurement, F::Measurement>(&cross, &fix_innovation.information);
            let corrected =
                candidate.pose.displaced(&applied::<K<M>, F::Measurement>(&gain, &fix_innovation.innovation));
            let seen = product::<K<M>, F::Measurement, K<M>>(&gain, &fix_innovation.by_pose);
            let residual: Linear<K<M>, K<M>> = Matrix::with(|row, column| {
                let identity = if row == column { T::ONE } else { T::ZERO };
                identity - seen.at(row, column)
            });
            // The Joseph form: a sum of two positive semidefinite terms, so that rounding cannot make it indefinite.
            let joseph = pose_covariance.congruence::<K<M>>(&residual).plus(&fix.noise().congruence::<K<M>>(&gain));
            if is_within_range(&corrected.coordinates()) && is_within_square(&joseph) {
                (candidate.pose, *pose_covariance) = (corrected, joseph);
            }
        }
        let ln_evidence = reweigh(candidates, ln_likelihoods);
        let heaviest = (0..candidates.len()).reduce(|best, other| {
            let weight = |index: usize| candidates.get(index).map_or(T::NEG_INFINITY, |candidate| candidate.ln_weight);
            if weight(other) > weight(best) { other } else { best }
        });
        cursor.heaviest = heaviest.and_then(|index| index.checked_div(children)).unwrap_or(0);
        // The weights are no longer those of the last scan.
        cursor.weighed = 0;
        Ok(FixReport { accepted: true, distance: whole.distance, ln_evidence, n_eff: effective_number(candidates) })
    }
}
