//! The settings of a planar log in the core's types, before models are made of them.

use super::config::config_of;
use crate::settings::{SensorSettings, Settings};
use scphd::models::{AckermannGeometry, ConstantVelocity, ControlNoise, PlanarPose, RangeBearingLimits, Step};
use scphd::settings::MovingConfig;
use scphd::{Births, Config, Real};
use scphd_log::log::{self, Vehicle};

/// Parameters of the models and of a filter in the plane, in its scalar.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanarNumbers<T> {
    /// The vehicle.
    pub vehicle: PlanarVehicle<T>,
    /// Noise of its odometry.
    pub noise: ControlNoise<T>,
    /// The sensors.
    pub sensors: Vec<SensorNumbers<T>>,
    /// The recursion.
    pub config: Config<T>,
    /// The initial pose.
    pub start: PlanarPose<T>,
}

/// Motion model of a vehicle, without noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlanarVehicle<T> {
    /// A car.
    Ackermann(AckermannGeometry<T>),
    /// A unicycle or a differential drive.
    Unicycle(Step),
    /// A vehicle that also moves sideways.
    Holonomic,
}

/// One sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorNumbers<T> {
    /// Standard deviation of the range, m.
    pub range_sigma_m: T,
    /// Standard deviation of the range divided by the range; adds in quadrature.
    pub range_sigma_ratio: T,
    /// Standard deviation of the bearing, rad.
    pub bearing_sigma_rad: T,
    /// The field of view, with the probability of detection.
    pub limits: RangeBearingLimits<T>,
    /// Mean number of false measurements a scan.
    pub clutter_per_scan: T,
    /// Mounting: ahead of the vehicle's pose, to its left, m, and turned to the left, rad; `None` if the sensor is at the pose.
    pub mounting: Option<[T; 3]>,
    /// The births of its measurements.
    pub births: Births<T>,
}

impl<T: Real> PlanarNumbers<T> {
    /// The parameters of the filter with a mixture for each particle.
    #[must_use]
    pub fn of(settings: &Settings, vehicle: &Vehicle, initial_pose: [f64; 3]) -> Self {
        Self::with_margin(settings, settings.filter.interval_margin, vehicle, initial_pose)
    }

    /// The parameters of a filter that multiplies the correlation time of odometry errors by `interval_margin`.
    pub(super) fn with_margin(
        settings: &Settings,
        interval_margin: f64,
        vehicle: &Vehicle,
        initial_pose: [f64; 3],
    ) -> Self {
        let real = T::from_f64;
        let [x, y, heading] = initial_pose.map(real);
        Self {
            vehicle: vehicle_of(vehicle),
            noise: ControlNoise {
                speed_sigma_mps: real(settings.vehicle.speed_sigma_mps),
                speed_sigma_ratio: real(settings.vehicle.speed_sigma_ratio),
                turn_sigma: real(settings.vehicle.turn_sigma),
                turn_sigma_ratio: real(settings.vehicle.turn_sigma_ratio),
                interval_s: real(settings.vehicle.noise_interval_s * interval_margin),
            },
            sensors: settings.sensors().map(|sensor| sensor_of(settings, sensor)).collect(),
            config: planar_config(settings),
            start: PlanarPose::new(x, y, heading),
        }
    }
}

fn vehicle_of<T: Real>(vehicle: &Vehicle) -> PlanarVehicle<T> {
    match *vehicle {
        Vehicle::Ackermann { wheelbase_m, encoder_offset_m, sensor_forward_m, sensor_left_m } => {
            PlanarVehicle::Ackermann(AckermannGeometry {
                wheelbase_m: T::from_f64(wheelbase_m),
                encoder_offset_m: T::from_f64(encoder_offset_m),
                sensor_forward_m: T::from_f64(sensor_forward_m),
                sensor_left_m: T::from_f64(sensor_left_m),
            })
        }
        Vehicle::Unicycle => PlanarVehicle::Unicycle(Step::Euler),
        Vehicle::UnicycleArc => PlanarVehicle::Unicycle(Step::Arc),
        Vehicle::Holonomic => PlanarVehicle::Holonomic,
    }
}

/// The configuration of the recursion, with moving features.
pub(super) fn planar_config<T: Real>(settings: &Settings) -> Config<T> {
    let moving = &settings.moving;
    let moving = MovingConfig {
        velocity_sigma_mps: T::from_f64(moving.velocity_sigma_mps),
        motion: ConstantVelocity {
            acceleration_psd: T::from_f64(moving.acceleration_psd),
            lifetime_s: T::from_f64(moving.lifetime_s),
        },
        spread_max_m: T::from_f64(moving.spread_max_m),
        extraction_weight: T::from_f64(moving.extraction_weight),
    };
    Config { moving, ..config_of(&settings.filter) }
}

fn sensor_of<T: Real>(settings: &Settings, sensor: &SensorSettings) -> SensorNumbers<T> {
    let place = sensor.mounting();
    SensorNumbers {
        range_sigma_m: T::from_f64(sensor.range_sigma_m),
        range_sigma_ratio: T::from_f64(sensor.range_sigma_ratio),
        bearing_sigma_rad: T::from_f64(sensor.bearing_sigma_rad),
        limits: limits_of(sensor),
        clutter_per_scan: T::from_f64(sensor.clutter_per_scan),
        mounting: (place != log::Mounting::NONE)
            .then(|| [place.forward_m, place.left_m, place.yaw_rad].map(T::from_f64)),
        births: Births {
            of_static: T::from_f64(sensor.birth_factor * settings.filter.birth_intensity),
            of_moving: T::from_f64(sensor.birth_factor * settings.moving.birth_intensity),
        },
    }
}

fn limits_of<T: Real>(sensor: &SensorSettings) -> RangeBearingLimits<T> {
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
