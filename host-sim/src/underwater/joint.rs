//! The filter with a joint map over an underwater log.

use super::log::Log;
use super::record::MapFeature;
use super::settings::Settings;
use super::slam::{Camera, Outcome, Slam};
use crate::slam::{Precision, Refusal, full, left_out, refusal};
use crate::stream::underwater_models;
use crate::threads::Threads;
use nalgebra::Vector4;
use scphd::{
    Auv, AuvControl, AuvPose, Births, Detector, Implausible, JointConfig, JointSlam, JointState, Real, joint_numbers,
};
use scphd_stream::underwater::AuvModels;

/// Features and keypoints in a frame that the host's state has room for.
const FEATURES: usize = 1024;
const MEASUREMENTS: usize = 256;

type HostJointState<T> = JointState<AuvPose<T>, Vector4<T>, FEATURES, { joint_numbers(5, 3, FEATURES) }, MEASUREMENTS>;

type AuvJoint<'s, T> = JointSlam<'s, Auv<T>, Vector4<T>>;

/// The joint filter of one underwater log, with its state on the heap.
#[derive(Debug)]
struct JointFilter<T: Real> {
    motion: Auv<T>,
    camera: Camera<T>,
    config: JointConfig<T>,
    state: Box<HostJointState<T>>,
}

impl<T: Real> JointFilter<T> {
    /// Works on the filter. A state goes on from where the last filter over it left off.
    fn with<R>(&mut self, work: impl FnOnce(&mut AuvJoint<'_, T>, &Camera<T>) -> R) -> Result<R, Refusal> {
        let mut filter = AuvJoint::new(self.motion, self.config, &mut *self.state).map_err(refusal)?;
        Ok(work(&mut filter, &self.camera))
    }
}

impl<T: Real> Slam for JointFilter<T> {
    fn predict(&mut self, control: &AuvControl<f64>, dt_s: f64) -> Result<Option<Implausible>, Refusal> {
        left_out(self.with(|filter, _| filter.predict(&control.rounded(), T::from_f64(dt_s)))?)
    }

    fn scan(&mut self, keypoints: &[[f64; 4]]) -> Result<Outcome, Refusal> {
        let measurements: Vec<_> = keypoints.iter().map(|z| Vector4::from(z.map(T::from_f64))).collect();
        let report = self.with(|filter, camera| filter.scan(camera, &measurements))?.map_err(refusal)?;
        Ok(Outcome {
            n_eff: 1.0,
            in_view: report.in_view,
            no_birth: report.no_birth,
            ln_evidence: report.ln_evidence.to_f64(),
            innovation: Some(report.innovation.to_f64()).filter(|&innovation| innovation > 0.0),
            pages_used: None,
            health: report.health,
        })
    }

    fn pose(&mut self) -> Result<([f64; 5], [[f64; 5]; 5]), Refusal> {
        let estimate = self.with(|filter, _| filter.estimate_pose())?.ok_or_else(|| refusal("not started"))?;
        let AuvPose { x_m, y_m, z_m, yaw_rad, yaw_rate_radps, .. } = estimate.mean;
        Ok(([x_m, y_m, z_m, yaw_rad, yaw_rate_radps].map(T::to_f64), full(&estimate.covariance)))
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

    fn weigh_on(&mut self, _threads: &Threads) {}

    fn digest(&mut self) -> Option<u64> {
        self.with(|filter, _| filter.digest()).ok()
    }

    fn state_bytes(&self) -> Option<u64> {
        Some(size_of_val(&*self.state) as u64)
    }
}

/// The joint filter with the models that the settings describe. Nothing is hidden and nothing vanishes under water.
///
/// # Errors
/// The filter cannot work with the settings.
pub fn joint_filter(log: &Log, settings: &Settings, precision: Precision) -> Result<Box<dyn Slam>, Refusal> {
    match precision {
        Precision::F32 => start::<f32>(log, settings),
        Precision::F64 => start::<f64>(log, settings),
    }
}

fn start<T: Real>(log: &Log, settings: &Settings) -> Result<Box<dyn Slam>, Refusal> {
    let numbers = underwater_models(log, settings)?;
    let AuvModels { motion, sensing } = numbers.of_filter().map_err(refusal)?;
    let births = Births::of_static(T::from_f64(settings.filter.birth_intensity));
    let camera = Detector::new(sensing, births).map_err(refusal)?;
    let mut started =
        JointFilter { motion, camera, config: JointConfig::default(), state: Box::new(HostJointState::new()) };
    started.with(|filter, _| filter.reset(numbers.start()))?.map_err(refusal)?;
    Ok(Box::new(started))
}
