//! The filters of the core over a planar log.

use super::contract::{Refusal, refusal};
use super::core_filter::{Transparent, start as core_of};
use super::filter::{Precision, in_precision};
use super::fixes::{Fixed, PlanarFixes};
use super::in_map::{InMap, PlanarMap};
use super::joint_filter::{OpenJoint, start as joint_of};
use super::joint_room::{FEATURES, FEATURES_OF_EACH, One, Several};
use super::models::{Models, SensorModels};
use super::planar_numbers::{PlanarNumbers, PlanarVehicle, SensorNumbers, planar_config};
use crate::settings::{CalibrationSettings, JointSettings, SensorSettings, Settings};
use nalgebra::Vector2;
use scphd::models::{
    Ackermann, AckermannControl, Calibrated, CalibratedPose, Holonomic, HolonomicControl, MeasurementModel, Motion,
    Mounting, OdometryCorrection, OdometryPrior, PlanarControl, PlanarMotion, PlanarPose, Pose, RangeBearing,
    RangeBearingWindow, RangeNoise, SelfCalibrating, Sensing, TangentOf, Unicycle, UnicycleControl, UniformClutter,
    WithNoise,
};
use scphd::numerics::Symmetric;
use scphd::settings::Persistence;
use scphd::storage::{Dynamic, MapMemory, Static, joint_numbers};
use scphd::{JointConfig, Real, State};
use scphd_log::dimensions::Planar;
use scphd_log::log::Vehicle;

/// Capacity of the host's state for particles.
const PARTICLES: usize = 1024;
/// Capacity for components of one map in an update.
const VIEW: usize = 4096;

/// A state with equal capacities for static and moving maps.
type HostState<T> = State<
    PlanarPose<T>,
    PARTICLES,
    { 2 * PARTICLES },
    MapMemory<Static<Vector2<T>>, PARTICLES, 65_535, 512, VIEW>,
    MapMemory<Dynamic<Vector2<T>>, PARTICLES, 65_535, 512, VIEW>,
>;

/// Capacity for numbers of a joint state without and with calibration of the odometry.
const NUMBERS: usize = joint_numbers(3, 2, FEATURES);
const CALIBRATED_NUMBERS: usize = joint_numbers(6, 2, FEATURES);
/// The same of each of several hypotheses.
const HYPOTHESIS_NUMBERS: usize = joint_numbers(3, 2, FEATURES_OF_EACH);
const CALIBRATED_HYPOTHESIS_NUMBERS: usize = joint_numbers(6, 2, FEATURES_OF_EACH);

/// The sensor of a planar log; its noise may grow with the range.
pub type Ranging<T> = WithNoise<RangeBearing<T>, RangeNoise<T>>;
type PlanarSensing<T> = Sensing<Ranging<T>, RangeBearingWindow<T>, UniformClutter<T>>;
/// Converts a row of odometry to a control.
type Steered<T> = fn([f64; 3]) -> PlanarControl<T>;

type PlanarModels<T> = Models<Planar, PlanarMotion<T>, PlanarSensing<T>>;

/// The fixed-capacity filter in the plane.
type Core = Box<dyn Transparent<Planar, [f64; 3], 2, 4>>;

/// The fixed-capacity filter for a log's vehicle, with its state on the heap.
///
/// # Errors
/// The first setting that is out of range.
pub fn core_filter(
    settings: &Settings,
    vehicle: &Vehicle,
    initial_pose: [f64; 3],
    precision: Precision,
    seed: u64,
) -> Result<Core, Refusal> {
    if settings.calibration.is_some() {
        return Err(refusal("calibration: particles do not learn what odometry is off by; --filter joint does"));
    }
    let margin = settings.filter.interval_margin;
    in_precision!(precision, T => core_of_models(models::<T>(settings, margin, vehicle, initial_pose)?, settings, seed))
}

/// The joint filter for a log's vehicle.
///
/// # Errors
/// The first setting that is out of range.
pub fn joint_filter(
    settings: &Settings,
    vehicle: &Vehicle,
    initial_pose: [f64; 3],
    precision: Precision,
) -> Result<Box<dyn OpenJoint<Planar>>, Refusal> {
    in_precision!(precision, T => joint_of_models(models::<T>(settings, 1.0, vehicle, initial_pose)?, settings))
}

/// Starts the filter with a mixture for each particle.
fn core_of_models<T: Real>(models: PlanarModels<T>, settings: &Settings, seed: u64) -> Result<Core, Refusal> {
    core_of(models, planar_config(settings), Box::new(HostState::<T>::new()), seed)
}

/// Starts the filter with a joint map.
fn joint_of_models<T: Real>(
    models: PlanarModels<T>,
    settings: &Settings,
) -> Result<Box<dyn OpenJoint<Planar>>, Refusal> {
    if let Some(calibration) = &settings.calibration {
        return joint_of_calibrated(models, settings, calibration);
    }
    let maps = Some(Box::new(PlanarMap::<T>::new()) as _);
    joint_over::<_, _, _, NUMBERS, HYPOTHESIS_NUMBERS>(&models, settings, maps, None)
}

/// Starts it with moving-object tracks if they have births.
fn joint_over<T, M, X, const NUMBERS: usize, const OF_EACH: usize>(
    models: &Models<Planar, M, X>,
    settings: &Settings,
    maps: Option<Box<dyn InMap<X>>>,
    prior: Option<Symmetric<TangentOf<M::Pose>>>,
) -> Result<Box<dyn OpenJoint<Planar>>, Refusal>
where
    T: Real,
    M: Motion<Pose: Fixed<Planar> + Pose<Scalar = T>> + Copy + 'static,
    X: MeasurementModel<Pose = M::Pose> + Copy + 'static,
{
    let moving = (settings.moving.birth_intensity > 0.0).then(|| planar_config(settings).moving);
    let (config, most) = (joint_config(&settings.joint), settings.joint.hypotheses);
    if most > 1 {
        let state = Box::new(Several::<M, X::Measurement, OF_EACH>::new(most, moving));
        return joint_of(models, config, state, maps, prior);
    }
    joint_of(models, config, Box::new(One::<M, X::Measurement, FEATURES, NUMBERS>::new(moving)), maps, prior)
}

/// Starts the filter with a joint map and calibration of the odometry.
fn joint_of_calibrated<T: Real>(
    models: PlanarModels<T>,
    settings: &Settings,
    calibration: &CalibrationSettings,
) -> Result<Box<dyn OpenJoint<Planar>>, Refusal> {
    let real = T::from_f64;
    let sigma = OdometryCorrection {
        speed_scale: real(calibration.speed_scale_sigma),
        turn_scale: real(calibration.turn_scale_sigma),
        turn_offset: real(calibration.turn_offset_sigma),
    };
    let Models { motion, sensors, fixes, start, control } = models;
    let prior = OdometryPrior { sigma, lasts_s: real(calibration.lasts_s) };
    let motion = SelfCalibrating::new(motion, prior).map_err(refusal)?;
    let calibrated = |SensorModels { sensing, mounting, births }| {
        let Sensing { sensor, field_of_view, clutter } = sensing;
        SensorModels { sensing: Sensing { sensor: Calibrated(sensor), field_of_view, clutter }, mounting, births }
    };
    let models = Models {
        motion,
        sensors: sensors.into_iter().map(calibrated).collect(),
        fixes,
        start: CalibratedPose::at(start),
        control,
    };
    joint_over::<_, _, _, CALIBRATED_NUMBERS, CALIBRATED_HYPOTHESIS_NUMBERS>(
        &models,
        settings,
        None,
        Some(motion.prior()),
    )
}

/// The configuration of the joint filter.
pub fn joint_config<T: Real>(joint: &JointSettings) -> JointConfig<T> {
    let real = T::from_f64;
    JointConfig {
        merge_distance: real(joint.merge_distance),
        persistence: Persistence {
            visible_s: real(joint.visible_s),
            occluded_s: real(joint.occluded_s),
            lifetime_s: real(joint.lifetime_s),
        },
        occlusion_factor: real(joint.occlusion_factor),
        ..JointConfig::default()
    }
}

/// The models of these settings for a vehicle; the correlation time of odometry errors is multiplied by `interval_margin`.
fn models<T: Real>(
    settings: &Settings,
    interval_margin: f64,
    vehicle: &Vehicle,
    initial_pose: [f64; 3],
) -> Result<PlanarModels<T>, Refusal> {
    let numbers = PlanarNumbers::<T>::with_margin(settings, interval_margin, vehicle, initial_pose);
    let (motion, control): (_, Steered<T>) = match numbers.vehicle {
        PlanarVehicle::Ackermann(geometry) => {
            (PlanarMotion::Ackermann(Ackermann::new(geometry, numbers.noise).map_err(refusal)?), |control| {
                let [speed_mps, steering_rad, _] = control.map(T::from_f64);
                PlanarControl::Ackermann(AckermannControl { speed_mps, steering_rad })
            })
        }
        PlanarVehicle::Unicycle(step) => {
            (PlanarMotion::Unicycle(Unicycle::new(step, numbers.noise).map_err(refusal)?), |control| {
                let [speed_mps, rate_radps, _] = control.map(T::from_f64);
                PlanarControl::Unicycle(UnicycleControl { speed_mps, rate_radps })
            })
        }
        PlanarVehicle::Holonomic => {
            (PlanarMotion::Holonomic(Holonomic::new(numbers.noise).map_err(refusal)?), |control| {
                let [forward_mps, rate_radps, left_mps] = control.map(T::from_f64);
                PlanarControl::Holonomic(HolonomicControl { forward_mps, left_mps, rate_radps })
            })
        }
    };
    Ok(Models {
        motion,
        sensors: numbers.sensors.iter().map(sensor_models).collect::<Result<_, _>>()?,
        fixes: PlanarFixes::of(&settings.fixes.unwrap_or_default())?,
        start: numbers.start,
        control,
    })
}

fn sensor_models<T: Real>(numbers: &SensorNumbers<T>) -> Result<SensorModels<PlanarSensing<T>>, Refusal> {
    let field_of_view = RangeBearingWindow::new(numbers.limits).map_err(refusal)?;
    let sensing = Sensing {
        sensor: ranging([numbers.range_sigma_m, numbers.range_sigma_ratio, numbers.bearing_sigma_rad])?,
        field_of_view,
        clutter: UniformClutter::of_scan(numbers.clutter_per_scan, field_of_view.measure()).map_err(refusal)?,
    };
    let mounting = numbers.mounting.map(|[forward, left, yaw]| Mounting::in_plane(forward, left, yaw).map_err(refusal));
    Ok(SensorModels { sensing, mounting: mounting.transpose()?, births: numbers.births })
}

/// The sensor of these settings.
///
/// # Errors
/// The noise is out of range.
pub fn range_bearing<T: Real>(sensor: &SensorSettings) -> Result<Ranging<T>, Refusal> {
    ranging([sensor.range_sigma_m, sensor.range_sigma_ratio, sensor.bearing_sigma_rad].map(T::from_f64))
}

fn ranging<T: Real>([range_sigma_m, ratio, bearing_sigma_rad]: [T; 3]) -> Result<Ranging<T>, Refusal> {
    let sensor = RangeBearing::new(range_sigma_m, bearing_sigma_rad).map_err(refusal)?;
    Ok(WithNoise { sensor, noise: RangeNoise::new(ratio).map_err(refusal)? })
}
