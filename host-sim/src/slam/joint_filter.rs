//! The filter with a joint map over a planar log.

use super::core_filter::{
    OverModels, PlanarDetector, PlanarModels, PlanarMotion, Precision, full, refusal, with_planar_models,
};
use super::{PoseAndCovariance, Refusal, ScanOutcome, Slam, left_out};
use crate::log::Vehicle;
use crate::record::{MapFeature, MovingFeature};
use crate::settings::Settings;
use nalgebra::Vector2;
use scphd::{Implausible, JointConfig, JointSlam, JointState, Persistence, PlanarPose, Real, joint_numbers};

/// Features and measurements in a scan that the host's state has room for.
const FEATURES: usize = 1024;
const MEASUREMENTS: usize = 256;

type HostJointState<T> =
    JointState<PlanarPose<T>, Vector2<T>, FEATURES, { joint_numbers(3, 2, FEATURES) }, MEASUREMENTS>;

type PlanarJoint<'s, T, M> = JointSlam<'s, M, Vector2<T>>;

/// The joint filter of one planar log, with its state on the heap.
#[derive(Debug)]
struct JointFilter<T: Real, M> {
    motion: M,
    detector: PlanarDetector<T>,
    config: JointConfig<T>,
    state: Box<HostJointState<T>>,
}

impl<T: Real, M: PlanarMotion<T>> JointFilter<T, M> {
    /// Works on the filter. A state goes on from where the last filter over it left off.
    fn with<R>(
        &mut self,
        work: impl FnOnce(&mut PlanarJoint<'_, T, M>, &PlanarDetector<T>) -> R,
    ) -> Result<R, Refusal> {
        let mut filter = PlanarJoint::new(self.motion, self.config, &mut *self.state).map_err(refusal)?;
        Ok(work(&mut filter, &self.detector))
    }
}

impl<T: Real, M: PlanarMotion<T>> Slam for JointFilter<T, M> {
    fn predict(&mut self, control: [f64; 2], dt_s: f64) -> Result<Option<Implausible>, Refusal> {
        left_out(self.with(|filter, _| filter.predict(&M::control(control), T::from_f64(dt_s)))?)
    }

    fn scan(&mut self, detections: &[[f64; 2]]) -> Result<ScanOutcome, Refusal> {
        let measurements: Vec<_> = detections.iter().map(|z| Vector2::from(z.map(T::from_f64))).collect();
        let report = self.with(|filter, detector| filter.scan(detector, &measurements))?.map_err(refusal)?;
        let innovation = report.innovation.to_f64();
        Ok(ScanOutcome {
            n_eff: 1.0,
            resampled: false,
            ln_evidence: Some(report.ln_evidence.to_f64()),
            innovation: (innovation > 0.0).then_some(innovation),
            health: report.health,
        })
    }

    fn pose(&mut self) -> Result<PoseAndCovariance, Refusal> {
        let estimate = self.with(|filter, _| filter.estimate_pose())?.ok_or_else(|| refusal("not started"))?;
        let mean = estimate.mean;
        Ok(([mean.x_m, mean.y_m, mean.heading_rad].map(T::to_f64), full(&estimate.covariance)))
    }

    fn map(&mut self) -> Result<(f64, Vec<MapFeature>), Refusal> {
        self.with(|filter, _| {
            let features = filter.features().map(|feature| MapFeature {
                id: feature.label,
                weight: feature.ln_weight.exp().to_f64(),
                mean: std::array::from_fn(|k| feature.mean[k].to_f64()),
                covariance: full(&feature.covariance),
            });
            (filter.expected_features().to_f64(), features.collect())
        })
    }

    fn moving(&mut self) -> Result<Vec<MovingFeature>, Refusal> {
        Ok(Vec::new())
    }

    fn digest(&mut self) -> Option<u64> {
        self.with(|filter, _| filter.digest()).ok()
    }

    fn state_bytes(&self) -> Option<u64> {
        Some(size_of_val(&*self.state) as u64)
    }
}

/// The joint filter for a log's vehicle.
///
/// # Errors
/// The settings are out of range, and which.
pub fn joint_filter(
    settings: &Settings,
    vehicle: &Vehicle,
    initial_pose: [f64; 3],
    precision: Precision,
) -> Result<Box<dyn Slam>, Refusal> {
    match precision {
        Precision::F32 => start::<f32>(settings, vehicle, initial_pose),
        Precision::F64 => start::<f64>(settings, vehicle, initial_pose),
    }
}

fn start<T: Real>(settings: &Settings, vehicle: &Vehicle, initial_pose: [f64; 3]) -> Result<Box<dyn Slam>, Refusal> {
    if settings.moving.birth_intensity > 0.0 {
        return Err(refusal("moving.birth_intensity: a joint map has no moving features; --filter core has"));
    }
    let real = T::from_f64;
    let joint = &settings.joint;
    let config = JointConfig {
        merge_distance: real(joint.merge_distance),
        persistence: Persistence {
            in_sight_s: real(joint.in_sight_s),
            hidden_s: real(joint.hidden_s),
            lifetime_s: real(joint.lifetime_s),
        },
        behind: real(joint.behind),
        ..JointConfig::default()
    };
    with_planar_models(settings, vehicle, Start { config, initial_pose })
}

struct Start<T: Real> {
    config: JointConfig<T>,
    initial_pose: [f64; 3],
}
impl<T: Real> OverModels<T> for Start<T> {
    type Output = Box<dyn Slam>;
    fn over<M: PlanarMotion<T> + 'static>(self, models: PlanarModels<T, M>) -> Result<Self::Output, Refusal> {
        let mut state = Box::new(HostJointState::new());
        let [x, y, heading] = self.initial_pose.map(T::from_f64);
        PlanarJoint::new(models.motion, self.config, &mut *state)
            .map_err(refusal)?
            .reset(PlanarPose::new(x, y, heading))
            .map_err(refusal)?;
        Ok(Box::new(JointFilter { motion: models.motion, detector: models.detector()?, config: self.config, state }))
    }
}
