//! The filters of the core over an underwater log.

use super::MEASUREMENTS;
use super::config::config_of;
use super::contract::{Refusal, refusal};
use super::core_filter::{Room, Transparent, start as core_of};
use super::filter::Precision;
use super::joint_filter::{OpenJoint, start as joint_of};
use super::joint_room::FEATURES;
use super::models::{Models, SensorModels};
use crate::underwater::models::models;
use crate::underwater::settings::Settings;
use nalgebra::{Vector3, Vector4};
use scphd::models::{Auv, AuvControl, AuvPose, Sensing, StereoCamera, StereoFrustum, UniformClutter};
use scphd::settings::Persistence;
use scphd::storage::{MapMemory, NoMoving, Static, joint_numbers};
use scphd::{Births, JointConfig, JointState, Real, State};
use scphd_log::dimensions::Underwater;
use scphd_log::underwater::Log;
use scphd_reference::space;
use scphd_stream::underwater::AuvModels;

/// Components of one map in an update that every state has room for.
const VIEW: usize = 4096;

type HostState<T, const PARTICLES: usize, const CANDIDATES: usize, const PAGES: usize> =
    State<AuvPose<T>, PARTICLES, CANDIDATES, MapMemory<Static<Vector3<T>>, PARTICLES, PAGES, 512, VIEW>, NoMoving>;

type HostJointState<T> = JointState<AuvPose<T>, Vector4<T>, FEATURES, { joint_numbers(5, 3, FEATURES) }, MEASUREMENTS>;

type AuvSensing<T> = Sensing<StereoCamera<T>, StereoFrustum<T>, UniformClutter<T>>;

/// The fixed-capacity filter in space.
type Core = Box<dyn Transparent<Underwater, space::Pose, 3, 6>>;

/// The fixed-capacity filter with the models and tuning that the settings describe.
///
/// # Errors
/// The filter cannot work with the settings.
pub fn core_filter(log: &Log, settings: &Settings, precision: Precision, seed: u64) -> Result<Core, Refusal> {
    match precision {
        Precision::F32 => start::<f32>(log, settings, seed),
        Precision::F64 => start::<f64>(log, settings, seed),
    }
}

fn start<T: Real>(log: &Log, settings: &Settings, seed: u64) -> Result<Core, Refusal> {
    let filter = &settings.filter;
    let state: Box<dyn Room<Auv<T>>> = match (filter.particles, filter.particles.saturating_mul(filter.samples)) {
        (..=64, ..=128) => Box::new(HostState::<T, 64, 128, 4096>::new()),
        (..=400, ..=800) => Box::new(HostState::<T, 400, 800, 14_000>::new()),
        _ => Box::new(HostState::<T, 2048, 4096, 65_535>::new()),
    };
    core_of(models_of(log, settings)?, config_of(filter), state, seed)
}

/// The joint filter with the models that the settings describe. Nothing is hidden and nothing vanishes under water.
///
/// # Errors
/// The filter cannot work with the settings.
pub fn joint_filter(
    log: &Log,
    settings: &Settings,
    precision: Precision,
) -> Result<Box<dyn OpenJoint<Underwater>>, Refusal> {
    match precision {
        Precision::F32 => start_joint::<f32>(log, settings),
        Precision::F64 => start_joint::<f64>(log, settings),
    }
}

/// Most of what a stereo camera measures under water is clutter, which would fill the map. What was there stays there, in sight: a feature
/// that is missed was not matched, and the next one behind it is seen all the same.
pub fn joint_config<T: Real>() -> JointConfig<T> {
    JointConfig { persistence: Persistence::FOR_EVER, behind: T::ONE, ..JointConfig::strict() }
}

fn start_joint<T: Real>(log: &Log, settings: &Settings) -> Result<Box<dyn OpenJoint<Underwater>>, Refusal> {
    joint_of(&models_of(log, settings)?, joint_config(), Box::new(HostJointState::<T>::new()), None, None)
}

fn models_of<T: Real>(log: &Log, settings: &Settings) -> Result<Models<Underwater, Auv<T>, AuvSensing<T>>, Refusal> {
    let numbers = models(log, settings)?;
    let AuvModels { motion, sensing } = numbers.of_filter().map_err(refusal)?;
    Ok(Models {
        motion,
        sensors: vec![SensorModels {
            sensing,
            mounting: None,
            births: Births::of_static(T::from_f64(settings.filter.birth_intensity)),
        }],
        fixes: (),
        start: numbers.start(),
        control: |control: AuvControl<f64>| control.rounded(),
    })
}
