//! The filter with a joint map over a log.

use super::contract::{PoseAndCovariance, Refusal, ScanOutcome, Slam, left_out, refusal};
use super::models::{Models, feature_of, measured, pose_of};
use crate::dimensions::Dimensions;
use crate::record::{MapFeature, Usage};
use scphd::{
    Detector, Implausible, JointConfig, JointSlam, JointState, MeasurementModel, Motion, Real, ScalarOf, SetupError,
    Vector,
};
use std::fmt::Debug;

/// Features and measurements in a scan that the host's state has room for.
pub(super) const FEATURES: usize = 1024;
pub(super) const MEASUREMENTS: usize = 256;

/// A joint state of whatever capacities.
pub(crate) trait JointRoom<M: Motion, Z: Vector>: Debug {
    /// The filter over it, which goes on from where the last one left off.
    fn filter(&mut self, motion: M, config: JointConfig<ScalarOf<M::Pose>>) -> Result<JointSlam<'_, M, Z>, SetupError>;
}

impl<M, Z, const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize> JointRoom<M, Z>
    for JointState<M::Pose, Z, FEATURES, NUMBERS, MEASUREMENTS>
where
    M: Motion,
    Z: Vector<Scalar = ScalarOf<M::Pose>>,
{
    fn filter(&mut self, motion: M, config: JointConfig<ScalarOf<M::Pose>>) -> Result<JointSlam<'_, M, Z>, SetupError> {
        JointSlam::new(motion, config, self)
    }
}

/// The joint filter of one log, with its state on the heap.
struct JointFilter<D: Dimensions, M: Motion, X: MeasurementModel> {
    motion: M,
    control: fn(D::Control) -> M::Control,
    detector: Detector<X>,
    config: JointConfig<ScalarOf<M::Pose>>,
    state: Box<dyn JointRoom<M, X::Measurement>>,
}

/// The filter at the start of its log.
///
/// # Errors
/// The settings are out of range, and which.
pub(crate) fn start<D, M, X>(
    models: &Models<D, M, X>,
    config: JointConfig<ScalarOf<M::Pose>>,
    mut state: Box<dyn JointRoom<M, X::Measurement>>,
) -> Result<Box<dyn Slam<D>>, Refusal>
where
    D: Dimensions,
    M: Motion + Copy + 'static,
    X: MeasurementModel<Pose = M::Pose> + Copy + 'static,
{
    state.filter(models.motion, config).map_err(refusal)?.reset(models.start).map_err(refusal)?;
    let Models { motion, control, .. } = *models;
    Ok(Box::new(JointFilter { motion, control, detector: models.detector()?, config, state }))
}

impl<D: Dimensions, M: Motion + Copy, X: MeasurementModel<Pose = M::Pose>> JointFilter<D, M, X> {
    /// Works on the filter. A state goes on from where the last filter over it left off.
    fn with<R>(
        &mut self,
        work: impl FnOnce(&mut JointSlam<'_, M, X::Measurement>, &Detector<X>) -> R,
    ) -> Result<R, Refusal> {
        let mut filter = self.state.filter(self.motion, self.config).map_err(refusal)?;
        Ok(work(&mut filter, &self.detector))
    }
}

impl<D: Dimensions, M: Motion + Copy, X: MeasurementModel<Pose = M::Pose>> Slam<D> for JointFilter<D, M, X> {
    fn predict(&mut self, control: D::Control, dt_s: f64) -> Result<Option<Implausible>, Refusal> {
        let control = (self.control)(control);
        left_out(self.with(|filter, _| filter.predict(&control, ScalarOf::<M::Pose>::from_f64(dt_s)))?)
    }

    fn scan(&mut self, detections: &[D::Measurement]) -> Result<ScanOutcome, Refusal> {
        let measurements = measured::<D, X::Measurement>(detections);
        let report = self.with(|filter, detector| filter.scan(detector, &measurements))?.map_err(refusal)?;
        Ok(ScanOutcome {
            ln_evidence: Some(report.ln_evidence.to_f64()),
            innovation: Some(report.innovation.to_f64()).filter(|&innovation| innovation > 0.0),
            usage: Usage { in_view: report.in_view, no_birth: report.no_birth, pages_used: None },
            health: report.health,
            ..ScanOutcome::SILENT
        })
    }

    fn pose(&mut self) -> Result<PoseAndCovariance<D>, Refusal> {
        let estimate = self.with(|filter, _| filter.estimate_pose())?.ok_or_else(|| refusal("not started"))?;
        Ok(pose_of::<D, M::Pose>(&estimate))
    }

    fn map(&mut self) -> Result<(f64, Vec<MapFeature<D>>), Refusal> {
        self.with(|filter, _| {
            let features = filter.features().map(|feature| feature_of(&feature));
            (filter.expected_features().to_f64(), features.collect())
        })
    }

    fn digest(&mut self) -> Option<u64> {
        self.with(|filter, _| filter.digest()).ok()
    }

    fn state_bytes(&self) -> Option<u64> {
        Some(size_of_val(&*self.state) as u64)
    }
}
