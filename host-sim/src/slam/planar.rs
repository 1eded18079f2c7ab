//! The filters of the core over a planar log.

use super::config::{config_of, online_of};
use super::contract::{Refusal, refusal};
use super::core_filter::{Room, Transparent, start as core_of};
use super::filter::Precision;
use super::fixes::PlanarFixes;
use super::in_map::PlanarMap;
use super::joint_filter::{OpenJoint, start as joint_of};
use super::joint_room::{FEATURES, MEASUREMENTS};
use super::models::{Models, SensorModels};
use crate::dimensions::Planar;
use crate::log::{self, Vehicle};
use crate::settings::{JointSettings, SensorSettings, Settings};
use nalgebra::Vector2;
use scphd::{
    Ackermann, AckermannControl, AckermannGeometry, Births, Config, ConstantVelocity, ControlNoise, Dynamic,
    JointConfig, JointState, MapMemory, Motion, Mounting, MovingConfig, Persistence, PlanarPose, RangeBearing,
    RangeBearingLimits, RangeBearingWindow, Real, Sensing, State, Static, Step, Unicycle, UnicycleControl,
    UniformClutter, joint_numbers,
};
use std::fmt::Debug;

/// Components of one map in an update that every host state has room for.
const VIEW: usize = 4096;

/// Static and moving maps of the same capacities.
type HostState<T, const PARTICLES: usize, const CANDIDATES: usize, const PAGES: usize, const MAP_PAGES: usize> = State<
    PlanarPose<T>,
    PARTICLES,
    CANDIDATES,
    MapMemory<Static<Vector2<T>>, PARTICLES, PAGES, MAP_PAGES, VIEW>,
    MapMemory<Dynamic<Vector2<T>>, PARTICLES, PAGES, MAP_PAGES, VIEW>,
>;

type HostJointState<T> =
    JointState<PlanarPose<T>, Vector2<T>, FEATURES, { joint_numbers(3, 2, FEATURES) }, MEASUREMENTS>;

type PlanarSensing<T> = Sensing<RangeBearing<T>, RangeBearingWindow<T>, UniformClutter<T>>;
type PlanarModels<T, M> = Models<Planar, M, PlanarSensing<T>>;

/// The fixed-capacity filter in the plane.
type Core = Box<dyn Transparent<Planar, [f64; 3], 2, 4>>;

/// The fixed-capacity filter for a log's vehicle, in the smallest host state with room for its particles.
///
/// # Errors
/// The settings are out of range, and which.
pub fn core_filter(
    settings: &Settings,
    vehicle: &Vehicle,
    initial_pose: [f64; 3],
    precision: Precision,
    seed: u64,
) -> Result<Core, Refusal> {
    let margin = settings.filter.interval_margin;
    match precision {
        Precision::F32 => with_models::<f32, _>(settings, margin, vehicle, initial_pose, StartCore { settings, seed }),
        Precision::F64 => with_models::<f64, _>(settings, margin, vehicle, initial_pose, StartCore { settings, seed }),
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
) -> Result<Box<dyn OpenJoint<Planar>>, Refusal> {
    if settings.moving.birth_intensity > 0.0 {
        return Err(refusal("moving.birth_intensity: a joint map has no moving features; --filter core has"));
    }
    match precision {
        Precision::F32 => with_models::<f32, _>(settings, 1.0, vehicle, initial_pose, StartJoint { settings }),
        Precision::F64 => with_models::<f64, _>(settings, 1.0, vehicle, initial_pose, StartJoint { settings }),
    }
}

/// What is to be done with the models of a planar log, whichever motion they have.
trait OverModels<T: Real> {
    /// What comes of it.
    type Output;
    /// Does it.
    fn over<M: Motion<Pose = PlanarPose<T>> + Copy + Debug + 'static>(
        self,
        models: PlanarModels<T, M>,
    ) -> Result<Self::Output, Refusal>;
}

/// Starts the filter with a mixture a particle.
struct StartCore<'s> {
    settings: &'s Settings,
    seed: u64,
}

impl<T: Real> OverModels<T> for StartCore<'_> {
    type Output = Core;

    fn over<M: Motion<Pose = PlanarPose<T>> + Copy + Debug + 'static>(
        self,
        models: PlanarModels<T, M>,
    ) -> Result<Core, Refusal> {
        let Settings { filter, moving, .. } = self.settings;
        let config = Config {
            moving: MovingConfig {
                velocity_sigma_mps: T::from_f64(moving.velocity_sigma_mps),
                motion: ConstantVelocity {
                    acceleration_psd: T::from_f64(moving.acceleration_psd),
                    lifetime_s: T::from_f64(moving.lifetime_s),
                },
                spread_max_m: T::from_f64(moving.spread_max_m),
                extraction_weight: T::from_f64(moving.extraction_weight),
            },
            ..config_of(filter)
        };
        let state: Box<dyn Room<M>> = match (filter.particles, filter.particles.saturating_mul(filter.samples)) {
            (..=32, ..=64) => Box::new(HostState::<T, 32, 64, 16_384, 512>::new()),
            (..=128, ..=256) => Box::new(HostState::<T, 128, 256, 16_384, 256>::new()),
            _ => Box::new(HostState::<T, 1024, 2048, 65_535, 512>::new()),
        };
        core_of(models, config, state, self.seed)
    }
}

/// Starts the filter with a joint map.
struct StartJoint<'s> {
    settings: &'s Settings,
}

impl<T: Real> OverModels<T> for StartJoint<'_> {
    type Output = Box<dyn OpenJoint<Planar>>;

    fn over<M: Motion<Pose = PlanarPose<T>> + Copy + Debug + 'static>(
        self,
        models: PlanarModels<T, M>,
    ) -> Result<Self::Output, Refusal> {
        let config = joint_config(&self.settings.joint);
        joint_of(&models, config, Box::new(HostJointState::<T>::new()), Some(Box::new(PlanarMap::<T>::new())))
    }
}

/// The tuning of the joint filter that the settings describe.
pub(super) fn joint_config<T: Real>(joint: &JointSettings) -> JointConfig<T> {
    let real = T::from_f64;
    JointConfig {
        merge_distance: real(joint.merge_distance),
        persistence: Persistence {
            in_sight_s: real(joint.in_sight_s),
            hidden_s: real(joint.hidden_s),
            lifetime_s: real(joint.lifetime_s),
        },
        behind: real(joint.behind),
        ..JointConfig::default()
    }
}

/// Makes the models of these settings for a vehicle, whose odometry errors last so many times as long, and goes on with them.
fn with_models<T: Real, W: OverModels<T>>(
    settings: &Settings,
    interval_margin: f64,
    vehicle: &Vehicle,
    initial_pose: [f64; 3],
    work: W,
) -> Result<W::Output, Refusal> {
    let real = T::from_f64;
    let noise = ControlNoise {
        speed_sigma_mps: real(settings.vehicle.speed_sigma_mps),
        speed_sigma_ratio: real(settings.vehicle.speed_sigma_ratio),
        turn_sigma: real(settings.vehicle.turn_sigma),
        turn_sigma_ratio: real(settings.vehicle.turn_sigma_ratio),
        interval_s: real(settings.vehicle.noise_interval_s * interval_margin),
    };
    let step = match *vehicle {
        Vehicle::Ackermann { wheelbase_m, encoder_offset_m, sensor_forward_m, sensor_left_m } => {
            let geometry = AckermannGeometry {
                wheelbase_m: real(wheelbase_m),
                encoder_offset_m: real(encoder_offset_m),
                sensor_forward_m: real(sensor_forward_m),
                sensor_left_m: real(sensor_left_m),
            };
            let control = |[speed, steering]: [f64; 2]| AckermannControl {
                speed_mps: T::from_f64(speed),
                steering_rad: T::from_f64(steering),
            };
            let motion = Ackermann::new(geometry, noise).map_err(refusal)?;
            return work.over(models(settings, initial_pose, motion, control)?);
        }
        Vehicle::Unicycle => Step::Euler,
        Vehicle::UnicycleArc => Step::Arc,
    };
    let control =
        |[speed, rate]: [f64; 2]| UnicycleControl { speed_mps: T::from_f64(speed), rate_radps: T::from_f64(rate) };
    let motion = Unicycle::new(step, noise).map_err(refusal)?;
    work.over(models(settings, initial_pose, motion, control)?)
}

fn models<T: Real, M: Motion<Pose = PlanarPose<T>>>(
    settings: &Settings,
    initial_pose: [f64; 3],
    motion: M,
    control: fn([f64; 2]) -> M::Control,
) -> Result<PlanarModels<T, M>, Refusal> {
    let sensors = settings.sensors().map(|sensor| sensor_models(settings, sensor)).collect::<Result<_, _>>()?;
    let [x, y, heading] = initial_pose.map(T::from_f64);
    let start = PlanarPose::new(x, y, heading);
    Ok(Models {
        motion,
        sensors,
        fixes: PlanarFixes::of(&settings.fixes.unwrap_or_default())?,
        online: online_of(&settings.filter),
        start,
        control,
    })
}

fn sensor_models<T: Real>(
    settings: &Settings,
    sensor: &SensorSettings,
) -> Result<SensorModels<PlanarSensing<T>>, Refusal> {
    let field_of_view = RangeBearingWindow::new(limits::<T>(sensor)).map_err(refusal)?;
    let per_scan = T::from_f64(sensor.clutter_per_scan);
    let sensing = Sensing {
        sensor: range_bearing(sensor)?,
        field_of_view,
        clutter: UniformClutter::of_scan(per_scan, field_of_view.measure()).map_err(refusal)?,
    };
    let place = sensor.mounting();
    let mounting = (place != log::Mounting::NONE).then(|| {
        let [forward, left, yaw] = [place.forward_m, place.left_m, place.yaw_rad].map(T::from_f64);
        Mounting::in_plane(forward, left, yaw).map_err(refusal)
    });
    let births = Births {
        of_static: T::from_f64(sensor.birth_factor * settings.filter.birth_intensity),
        of_moving: T::from_f64(sensor.birth_factor * settings.moving.birth_intensity),
    };
    Ok(SensorModels { sensing, mounting: mounting.transpose()?, births })
}

/// The sensor of these settings.
///
/// # Errors
/// The noise is not one the sensor can work with.
pub(crate) fn range_bearing<T: Real>(sensor: &SensorSettings) -> Result<RangeBearing<T>, Refusal> {
    RangeBearing::new(T::from_f64(sensor.range_sigma_m), T::from_f64(sensor.bearing_sigma_rad)).map_err(refusal)
}

fn limits<T: Real>(sensor: &SensorSettings) -> RangeBearingLimits<T> {
    RangeBearingLimits {
        range_min_m: T::from_f64(sensor.range_min_m),
        range_max_m: T::from_f64(sensor.range_max_m),
        range_edge_m: T::from_f64(sensor.range_edge_m),
        bearing_center_rad: T::from_f64(sensor.bearing_center_rad()),
        bearing_half_width_rad: T::from_f64(sensor.bearing_half_width_rad()),
        bearing_edge_rad: T::from_f64(sensor.bearing_edge_rad),
        probability_near: T::from_f64(sensor.detection_near),
        probability_far: T::from_f64(sensor.detection_far),
    }
}
