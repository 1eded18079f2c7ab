//! The filter with several joint maps over a log.

use super::MEASUREMENTS;
use super::contract::{PoseAndCovariance, Refusal, ScanOutcome, Slam, left_out, no_sensor, refusal};
use super::fixes::{Fixed, Map};
use super::joint_filter::OpenJoint;
use super::joint_room::MOVERS;
use super::models::{Models, feature_of, measured, moving_of, pose_of};
use scphd::errors::{Implausible, SetupError};
use scphd::models::{MeasurementModel, Motion, ScalarOf, TangentOf};
use scphd::numerics::{Symmetric, Vector};
use scphd::settings::{HypothesesConfig, MovingConfig};
use scphd::storage::{JointHypotheses, JointMovers, Tracked};
use scphd::{Detector, JointConfig, JointSlam, JointState, MultiHypothesisSlam, Real};
use scphd_log::dimensions::{Covariance, Dimensions};
use scphd_reference::joint;
use scphd_score::record::{MapFeature, MovingFeature, Usage};

/// Capacity of each hypothesis for features.
pub(super) const FEATURES_OF_EACH: usize = 512;
/// Capacity for hypotheses beside the likeliest.
const OTHERS: usize = 15;

/// The memory of all hypotheses.
struct Room<M: Motion, Z: Vector<Scalar = ScalarOf<M::Pose>>, const NUMBERS: usize> {
    state: JointState<M::Pose, Z, FEATURES_OF_EACH, NUMBERS, MEASUREMENTS>,
    movers: Option<JointMovers<M::Pose, MOVERS>>,
    others: JointHypotheses<M::Pose, OTHERS, FEATURES_OF_EACH, NUMBERS, MEASUREMENTS, MOVERS>,
}

/// The filter over it.
type Several<'s, M, Z> = MultiHypothesisSlam<'s, M, Z, Option<Tracked<'s, <M as Motion>::Pose>>, OTHERS>;

/// The filter of one log, with its state on the heap.
struct HypothesesFilter<D, M, X, const NUMBERS: usize>
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
    hypotheses: HypothesesConfig<ScalarOf<M::Pose>>,
    moving: Option<MovingConfig<ScalarOf<M::Pose>>>,
    room: Box<Room<M, X::Measurement, NUMBERS>>,
}

/// Starts the filter of a log with so many hypotheses at most, with the covariance of its initial state; `None`: the state is certain.
///
/// # Errors
/// The first setting that is out of range.
pub(super) fn start<D, M, X, const NUMBERS: usize>(
    models: &Models<D, M, X>,
    config: JointConfig<ScalarOf<M::Pose>>,
    most: usize,
    moving: Option<MovingConfig<ScalarOf<M::Pose>>>,
    prior: Option<Symmetric<TangentOf<M::Pose>>>,
) -> Result<Box<dyn OpenJoint<D>>, Refusal>
where
    D: Dimensions,
    M: Motion<Pose: Fixed<D>> + Copy + 'static,
    X: MeasurementModel<Pose = M::Pose> + Copy + 'static,
{
    let Models { motion, control, fixes, start, .. } = *models;
    let movers = moving.map(|_| JointMovers::new());
    let mut filter: HypothesesFilter<D, M, X, NUMBERS> = HypothesesFilter {
        motion,
        control,
        detectors: models.sensors.iter().map(|sensor| sensor.detector()).collect::<Result<_, _>>()?,
        fixes,
        config,
        hypotheses: HypothesesConfig { most, ..HypothesesConfig::default() },
        moving,
        room: Box::new(Room { state: JointState::new(), movers, others: JointHypotheses::new() }),
    };
    filter
        .with(|filter, _| match prior {
            None => filter.reset(start),
            Some(prior) => filter.reset_within(start, &prior),
        })?
        .map_err(refusal)?;
    Ok(Box::new(filter))
}

impl<D, M, X, const NUMBERS: usize> HypothesesFilter<D, M, X, NUMBERS>
where
    D: Dimensions,
    M: Motion<Pose: Fixed<D>> + Copy,
    X: MeasurementModel<Pose = M::Pose>,
{
    /// The filter over the state that the last filter left.
    fn filter(&mut self) -> Result<Several<'_, M, X::Measurement>, SetupError> {
        let Room { state, movers, others } = &mut *self.room;
        let movers = movers.as_mut().zip(self.moving);
        let slam = JointSlam::new(self.motion, self.config, state)?.with_movers_if(movers)?;
        slam.with_hypotheses(others, self.hypotheses)
    }

    /// Calls `work` with the filter.
    fn with<Y>(
        &mut self,
        work: impl FnOnce(&mut Several<'_, M, X::Measurement>, &[Detector<X>]) -> Y,
    ) -> Result<Y, Refusal> {
        let detectors = std::mem::take(&mut self.detectors);
        let done = self.filter().map_err(refusal).map(|mut filter| work(&mut filter, &detectors));
        self.detectors = detectors;
        done
    }
}

impl<D, M, X, const NUMBERS: usize> Slam<D> for HypothesesFilter<D, M, X, NUMBERS>
where
    D: Dimensions,
    M: Motion<Pose: Fixed<D>> + Copy,
    X: MeasurementModel<Pose = M::Pose>,
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
        let joint = report.joint;
        Ok(ScanOutcome {
            n_eff: report.hypotheses as f64,
            ln_evidence: Some(joint.ln_evidence.to_f64()),
            innovation: Some(joint.innovation.to_f64()).filter(|&innovation| innovation > 0.0),
            usage: Usage { in_view: joint.in_view, no_birth: joint.no_birth, pages_used: None },
            health: joint.health,
            ..ScanOutcome::SILENT
        })
    }

    fn pose(&mut self) -> Result<PoseAndCovariance<D>, Refusal> {
        let estimate = self.with(|filter, _| filter.estimate_pose())?.ok_or_else(|| refusal("not started"))?;
        Ok(pose_of::<D, M::Pose>(&estimate))
    }

    fn map(&mut self) -> Result<(f64, Vec<MapFeature<D>>), Refusal> {
        self.with(|filter, _| {
            let features = filter.likeliest().features().map(|feature| feature_of(&feature));
            (filter.likeliest().expected_features().to_f64(), features.collect())
        })
    }

    fn moving(&mut self) -> Result<Vec<MovingFeature<D>>, Refusal> {
        self.with(|filter, _| filter.likeliest().moving().map(|feature| moving_of(&feature)).collect())
    }

    fn start_in(&mut self, _file: &[u8], _pose_is_known: bool) -> Result<(), Refusal> {
        Err(refusal("with several hypotheses it does not start in a map"))
    }

    fn map_file(&mut self) -> Result<Vec<u8>, Refusal> {
        Err(refusal("with several hypotheses no map is saved"))
    }

    fn digest(&mut self) -> Option<u64> {
        self.with(|filter, _| filter.digest()).ok()
    }

    fn state_bytes(&self) -> Option<u64> {
        Some(size_of_val(&*self.room) as u64)
    }
}

/// Comparisons with the reference, which has one hypothesis, are refused.
impl<D, M, X, const NUMBERS: usize> OpenJoint<D> for HypothesesFilter<D, M, X, NUMBERS>
where
    D: Dimensions,
    M: Motion<Pose: Fixed<D>> + Copy,
    X: MeasurementModel<Pose = M::Pose>,
{
    fn snapshot(&mut self) -> Result<joint::State, Refusal> {
        Err(refusal("joint.hypotheses: the reference has one"))
    }
}
