//! The filters of the core over a planar log.

use super::contract::{Refusal, refusal};
use super::core_filter::{Transparent, start as core_of};
use super::filter::{Precision, in_precision};
use super::fixes::PlanarFixes;
use super::in_map::{InMap, PlanarMap};
use super::joint_filter::{OpenJoint, start as joint_of};
use super::joint_room::{FEATURES, FEATURES_OF_EACH, One, Several};
use super::models::Models;
use super::planar_numbers::{PlanarNumbers, planar_config};
use crate::settings::{CalibrationSettings, JointSettings, SensorSettings, Settings};
use nalgebra::Vector2;
use scphd::models::{
    CalibratedPose, OdometryCorrection, OdometryPrior, PlanarPose, RangeBearing, RangeBearingWindow, RangeNoise,
    ScalarOf, Sensing, TangentOf, UniformClutter, WithNoise,
};
use scphd::numerics::Symmetric;
use scphd::settings::Persistence;
use scphd::storage::{Dynamic, MapMemory, Static, joint_numbers};
use scphd::{JointConfig, Real, State};
use scphd_log::dimensions::Planar;
use scphd_log::log::Vehicle;
use scphd_vehicle::{Control, PlanarState, Sensor, VehicleKind};

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
type PlanarSensing<P> = Sensing<
    <P as PlanarState>::Seen<Ranging<ScalarOf<P>>>,
    RangeBearingWindow<ScalarOf<P>>,
    UniformClutter<ScalarOf<P>>,
>;
type PlanarModels<P> = Models<Planar, <P as PlanarState>::Moves, PlanarSensing<P>>;

/// `ScPhd` in the plane.
type Core = Box<dyn Transparent<Planar, [f64; 3], 2, 4>>;

/// `ScPhd` for a log's vehicle, with its state on the heap.
pub fn core_filter(
    settings: &Settings,
    vehicle: &Vehicle,
    initial_pose: [f64; 3],
    precision: Precision,
    seed: u64,
) -> Result<Core, Refusal> {
    if settings.calibration.is_some() {
        return Err(refusal(
            "calibration: `ScPhd` does not estimate scale and offset of the odometry; use --filter joint",
        ));
    }
    in_precision!(precision, T => {
        let numbers = PlanarNumbers::of(settings, vehicle, initial_pose);
        let models = models::<PlanarPose<T>>(&numbers, settings, None)?;
        core_of(models, numbers.config, Box::new(HostState::<T>::new()), seed)
    })
}

/// The joint filter for a log's vehicle.
pub fn joint_filter(
    settings: &Settings,
    vehicle: &Vehicle,
    initial_pose: [f64; 3],
    precision: Precision,
) -> Result<Box<dyn OpenJoint<Planar>>, Refusal> {
    in_precision!(precision, T => {
        let numbers = PlanarNumbers::<T>::with_margin(settings, 1.0, vehicle, initial_pose);
        match settings.calibration.as_ref().map(odometry_prior) {
            None => {
                let models = models::<PlanarPose<T>>(&numbers, settings, None)?;
                let maps = Some(Box::new(PlanarMap::<T>::new()) as _);
                joint_over::<PlanarPose<T>, NUMBERS, HYPOTHESIS_NUMBERS>(models, settings, maps, None)
            }
            Some(prior) => {
                let models = models::<CalibratedPose<T>>(&numbers, settings, Some(prior))?;
                let prior = Some(models.motion.prior());
                let start = joint_over::<CalibratedPose<T>, CALIBRATED_NUMBERS, CALIBRATED_HYPOTHESIS_NUMBERS>;
                start(models, settings, None, prior)
            }
        }
    })
}

/// Starts the joint filter, with moving-object tracks if they have births.
fn joint_over<P: PlanarState + Copy + 'static, const NUMBERS: usize, const OF_EACH: usize>(
    models: PlanarModels<P>,
    settings: &Settings,
    maps: Option<Box<dyn InMap<PlanarSensing<P>>>>,
    prior: Option<Symmetric<TangentOf<P>>>,
) -> Result<Box<dyn OpenJoint<Planar>>, Refusal>
where
    P::Moves: Copy,
    PlanarSensing<P>: Copy,
{
    let moving = (settings.moving.birth_intensity > 0.0).then(|| planar_config(settings).moving);
    let (config, most) = (joint_config(&settings.joint), settings.joint.hypotheses);
    if most > 1 {
        let state = Box::new(Several::<P::Moves, Vector2<P::Scalar>, OF_EACH>::new(most, moving));
        return joint_of(models, config, state, maps, prior);
    }
    let state = Box::new(One::<P::Moves, Vector2<P::Scalar>, FEATURES, NUMBERS>::new(moving));
    joint_of(models, config, state, maps, prior)
}

/// The prior of the odometry's scale and offset.
pub fn odometry_prior<T: Real>(calibration: &CalibrationSettings) -> OdometryPrior<T> {
    let real = T::from_f64;
    OdometryPrior {
        sigma: OdometryCorrection {
            speed_scale: real(calibration.speed_scale_sigma),
            turn_scale: real(calibration.turn_scale_sigma),
            turn_offset: real(calibration.turn_offset_sigma),
        },
        lasts_s: real(calibration.lasts_s),
    }
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

/// The models of a vehicle in the plane, as `scphd-vehicle` makes them.
fn models<P: PlanarState>(
    numbers: &PlanarNumbers<P::Scalar>,
    settings: &Settings,
    prior: Option<OdometryPrior<P::Scalar>>,
) -> Result<PlanarModels<P>, Refusal> {
    let motion = numbers.vehicle.drive().and_then(|motion| P::moves(motion, prior)).map_err(refusal)?;
    let motion = motion.ok_or_else(|| refusal("calibration: this filter has no calibration of the odometry"))?;
    let (start, _) = P::start(&motion, numbers.start, &Symmetric::ZERO);
    Ok(Models {
        motion,
        detectors: numbers.sensors.iter().map(Sensor::polar::<P>).collect::<Result<_, _>>().map_err(refusal)?,
        fixes: PlanarFixes::of(&settings.fixes.unwrap_or_default())?,
        start,
        control: match numbers.vehicle.kind {
            VehicleKind::Ackermann => |row| VehicleKind::Ackermann.control(&control(row)),
            VehicleKind::Unicycle | VehicleKind::UnicycleEuler => |row| VehicleKind::Unicycle.control(&control(row)),
            VehicleKind::Holonomic => |row| VehicleKind::Holonomic.control(&control(row)),
        },
    })
}

/// A row of odometry as a control.
fn control<T: Real>(row: [f64; 3]) -> Control<T> {
    let [speed_mps, turn, left_mps] = row.map(T::from_f64);
    Control { speed_mps, left_mps, turn }
}

pub fn range_bearing<T: Real>(sensor: &SensorSettings) -> Result<Ranging<T>, Refusal> {
    let [range_sigma_m, ratio, bearing_sigma_rad] =
        [sensor.range_sigma_m, sensor.range_sigma_ratio, sensor.bearing_sigma_rad].map(T::from_f64);
    let sensor = RangeBearing::new(range_sigma_m, bearing_sigma_rad).map_err(refusal)?;
    Ok(WithNoise { sensor, noise: RangeNoise::new(ratio).map_err(refusal)? })
}
