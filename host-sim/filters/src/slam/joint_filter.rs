//! The filter with a joint map over a log.

use super::contract::{PoseAndCovariance, Refusal, ScanOutcome, Search, Slam, left_out, no_sensor, refusal};
use super::fixes::{Fixed, Map};
use super::in_map::{InMap, Mapped};
use super::joint_room::JointRoom;
use super::joint_snapshot;
use super::models::{Models, feature_of, measured, moving_of, pose_of};
use scphd::errors::Implausible;
use scphd::models::{MeasurementModel, Motion, ScalarOf, TangentOf};
use scphd::numerics::Symmetric;
use scphd::storage::JointFilter as _;
use scphd::{Detector, JointConfig, Real};
use scphd_log::dimensions::{Covariance, Dimensions};
use scphd_reference::joint;
use scphd_score::record::{MapFeature, MovingFeature, Usage};
use std::convert::Infallible;

/// A joint filter that shows its whole state, for lockstep with the reference.
pub trait OpenJoint<D: Dimensions>: Slam<D> {
    /// The present state.
    fn snapshot(&mut self) -> Result<joint::State, Refusal>;
}

/// The joint filter of one log, with its state on the heap.
struct JointFilter<D, M, X, R>
where
    D: Dimensions,
    M: Motion<Pose: Fixed<D>>,
    X: MeasurementModel<Pose = M::Pose>,
{
    motion: M,
    control: fn(D::Control) -> M::Control,
    /// The detector of every sensor.
    detectors: Vec<Detector<X>>,
    fixes: <M::Pose as Fixed<D>>::Models,
    config: JointConfig<ScalarOf<M::Pose>>,
    state: Box<R>,
    start: M::Pose,
    /// Maps of earlier drives, if the kind of vehicle supports them.
    maps: Option<Box<dyn InMap<X>>>,
}

/// Starts the filter of a log, with the covariance of its initial state; `None`: the state is certain.
pub(super) fn start<D, M, X, R>(
    models: Models<D, M, X>,
    config: JointConfig<ScalarOf<M::Pose>>,
    mut state: Box<R>,
    maps: Option<Box<dyn InMap<X>>>,
    prior: Option<Symmetric<TangentOf<M::Pose>>>,
) -> Result<Box<dyn OpenJoint<D>>, Refusal>
where
    D: Dimensions,
    M: Motion<Pose: Fixed<D>> + Copy + 'static,
    X: MeasurementModel<Pose = M::Pose> + Copy + 'static,
    R: JointRoom<M> + 'static,
{
    {
        let mut filter = state.filter(models.motion, config).map_err(refusal)?;
        match prior {
            None => filter.reset(models.start),
            Some(prior) => filter.reset_within(models.start, &prior),
        }
        .map_err(refusal)?;
    }
    let Models { motion, detectors, fixes, start, control } = models;
    Ok(Box::new(JointFilter { motion, control, detectors, fixes, config, state, start, maps }))
}

impl<D, M, X, R> JointFilter<D, M, X, R>
where
    D: Dimensions,
    M: Motion<Pose: Fixed<D>> + Copy,
    X: MeasurementModel<Pose = M::Pose>,
    R: JointRoom<M>,
{
    /// Calls `work` with the filter, in the state that the last filter left.
    fn with<Y>(&mut self, work: impl FnOnce(&mut R::Filter<'_>, &[Detector<X>]) -> Y) -> Result<Y, Refusal> {
        let mut filter = self.state.filter(self.motion, self.config).map_err(refusal)?;
        Ok(work(&mut filter, &self.detectors))
    }

    /// Calls `work` with the filter and its maps of earlier drives, if supported.
    fn with_maps<Y>(
        &mut self,
        work: impl FnOnce(&mut dyn InMap<X>, &mut dyn Mapped<M::Pose>, &[Detector<X>]) -> Result<Y, Refusal>,
    ) -> Option<Result<Y, Refusal>> {
        let maps = self.maps.as_deref_mut()?;
        let filter = self.state.filter(self.motion, self.config).map_err(refusal);
        Some(filter.and_then(|mut filter| work(maps, &mut filter, &self.detectors)))
    }
}

impl<D, M, X, R> Slam<D> for JointFilter<D, M, X, R>
where
    D: Dimensions,
    M: Motion<Pose: Fixed<D>> + Copy,
    X: MeasurementModel<Pose = M::Pose>,
    R: JointRoom<M>,
{
    fn predict(&mut self, control: D::Control, dt_s: f64) -> Result<Option<Implausible>, Refusal> {
        let control = (self.control)(control);
        left_out(self.with(|filter, _| filter.predict(&control, ScalarOf::<M::Pose>::from_f64(dt_s)))?)
    }

    fn observe(&mut self, fix: &D::Fix) -> Result<bool, Refusal> {
        let models = self.fixes;
        self.with(|filter, _| M::Pose::observe(filter, &models, fix))?
    }

    fn relocate(&mut self, pose: &D::Pose, covariance: &Covariance<D::Pose>) -> Result<(), Refusal> {
        self.with(|filter, _| M::Pose::relocate(filter, Map::Kept, pose, covariance))?
    }

    fn restart(&mut self, pose: &D::Pose, covariance: &Covariance<D::Pose>) -> Result<(), Refusal> {
        self.with(|filter, _| M::Pose::relocate(filter, Map::Dropped, pose, covariance))?
    }

    fn scan(&mut self, sensor: usize, detections: &[D::Measurement]) -> Result<ScanOutcome, Refusal> {
        let measurements = measured::<D, X::Measurement>(detections);
        let report = self
            .with(|filter, detectors| detectors.get(sensor).map(|detector| filter.scan(detector, &measurements)))?
            .ok_or_else(|| no_sensor(sensor))?
            .map_err(refusal)?;
        self.with_maps(|maps, filter, detectors| {
            detectors.get(sensor).map_or(Ok(()), |detector| maps.look(filter, detector))
        })
        .transpose()?;
        Ok(ScanOutcome {
            n_eff: report.hypotheses as f64,
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

    fn moving(&mut self) -> Result<Vec<MovingFeature<D>>, Refusal> {
        self.with(|filter, _| filter.moving().map(|feature| moving_of(&feature)).collect())
    }

    fn start_in(&mut self, file: &[u8], pose_is_known: bool) -> Result<(), Refusal> {
        let known = pose_is_known.then_some(self.start);
        if !pose_is_known {
            let JointConfig { least_existence, least_tentative, .. } = JointConfig::strict();
            (self.config.least_existence, self.config.least_tentative) = (least_existence, least_tentative);
        }
        self.with_maps(|maps, filter, _| maps.start(filter, file, known)).unwrap_or_else(|| Err(only_in_the_plane()))
    }

    fn map_file(&mut self) -> Result<Vec<u8>, Refusal> {
        self.with_maps(|maps, filter, _| maps.file(filter)).unwrap_or_else(|| Err(only_in_the_plane()))
    }

    fn search(&self) -> Option<Search> {
        self.maps.as_ref().and_then(|maps| maps.search())
    }

    fn digest(&mut self) -> Option<u64> {
        self.with(|filter, _| filter.digest()).ok()
    }

    fn state_bytes(&self) -> Option<u64> {
        Some(size_of_val(&*self.state) as u64)
    }
}

impl<D, M, X, R> OpenJoint<D> for JointFilter<D, M, X, R>
where
    D: Dimensions,
    M: Motion<Pose: Fixed<D>> + Copy,
    X: MeasurementModel<Pose = M::Pose>,
    R: JointRoom<M>,
{
    fn snapshot(&mut self) -> Result<joint::State, Refusal> {
        if !R::HAS_REFERENCE {
            return Err(refusal("joint.hypotheses: the reference has one"));
        }
        let mut bytes = Vec::new();
        let save = |bytes: &mut Vec<u8>, part: &[u8]| -> Result<(), Infallible> {
            bytes.extend_from_slice(part);
            Ok(())
        };
        let saved = self.with(|filter, _| filter.save(0, |part| save(&mut bytes, part)))?;
        saved.map_err(|error| refusal(format!("{error:?}")))?;
        Ok(joint_snapshot::read(&bytes))
    }
}

fn only_in_the_plane() -> Refusal {
    refusal("maps are saved and started in only in the plane, without [calibration]")
}
