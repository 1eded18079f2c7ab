//! The filters of the core over an underwater log.

use super::config::config_of;
use super::contract::{Refusal, refusal};
use super::core_filter::{Transparent, start as core_of};
use super::filter::{Precision, in_precision};
use super::joint_filter::{OpenJoint, start as joint_of};
use super::joint_room::{FEATURES, One};
use super::models::Models;
use crate::underwater::models::models;
use crate::underwater::settings::Settings;
use nalgebra::{Vector3, Vector4};
use scphd::models::{Auv, AuvControl, AuvPose, Sensing, StereoCamera, StereoFrustum, UniformClutter};
use scphd::storage::{MapMemory, NoMoving, Static, joint_numbers};
use scphd::{Births, Detector, Real, State};
use scphd_log::dimensions::Underwater;
use scphd_log::underwater::Log;
use scphd_reference::space;
use scphd_stream::underwater::{AuvModels, joint_config};

/// Capacity of the state for particles.
const PARTICLES: usize = 2048;
/// Capacity for components of one map in an update.
const VIEW: usize = 4096;

type HostState<T> = State<
    AuvPose<T>,
    PARTICLES,
    { 2 * PARTICLES },
    MapMemory<Static<Vector3<T>>, PARTICLES, 65_535, 512, VIEW>,
    NoMoving,
>;

type AuvSensing<T> = Sensing<StereoCamera<T>, StereoFrustum<T>, UniformClutter<T>>;

/// The fixed-capacity filter in space.
type Core = Box<dyn Transparent<Underwater, space::Pose, 3, 6>>;

/// The fixed-capacity filter with these settings.
pub fn core_filter(log: &Log, settings: &Settings, precision: Precision, seed: u64) -> Result<Core, Refusal> {
    in_precision!(precision, T => start::<T>(log, settings, seed))
}

fn start<T: Real>(log: &Log, settings: &Settings, seed: u64) -> Result<Core, Refusal> {
    core_of(models_of(log, settings)?, config_of(&settings.filter), Box::new(HostState::<T>::new()), seed)
}

/// The joint filter with these settings. Features are never occluded or removed under water.
pub fn joint_filter(
    log: &Log,
    settings: &Settings,
    precision: Precision,
) -> Result<Box<dyn OpenJoint<Underwater>>, Refusal> {
    in_precision!(precision, T => start_joint::<T>(log, settings))
}

fn start_joint<T: Real>(log: &Log, settings: &Settings) -> Result<Box<dyn OpenJoint<Underwater>>, Refusal> {
    let state = Box::new(One::<Auv<T>, Vector4<T>, FEATURES, { joint_numbers(5, 3, FEATURES) }>::new(None));
    joint_of(models_of::<T>(log, settings)?, joint_config(), state, None, None)
}

fn models_of<T: Real>(log: &Log, settings: &Settings) -> Result<Models<Underwater, Auv<T>, AuvSensing<T>>, Refusal> {
    let numbers = models(log, settings)?;
    let AuvModels { motion, sensing } = numbers.of_filter().map_err(refusal)?;
    let births = Births::of_static(T::from_f64(settings.filter.birth_intensity));
    Ok(Models {
        motion,
        detectors: vec![Detector::new(sensing, births).map_err(refusal)?],
        fixes: (),
        start: numbers.start(),
        control: |control: AuvControl<f64>| control.rounded(),
    })
}
