//! The settings of a planar log in the core's types, before models are made of them.

use super::config::config_of;
use crate::settings::{SensorSettings, Settings};
use scphd::models::{AckermannGeometry, ConstantVelocity, ControlNoise, PlanarPose, RangeBearingLimits};
use scphd::settings::MovingConfig;
use scphd::{Births, Config, Real};
use scphd_log::log;
use scphd_vehicle::{Description, Sensor, Vehicle, VehicleKind};

/// Parameters of the models and of a filter in the plane, in its scalar.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanarNumbers<T> {
    /// The vehicle, with the noise of its odometry.
    pub vehicle: Vehicle<T>,
    /// The sensors: any number, unlike in a description.
    pub sensors: Vec<Sensor<T>>,
    /// The configuration of `ScPhd`.
    pub config: Config<T>,
    pub start: PlanarPose<T>,
}

impl<T: Real> PlanarNumbers<T> {
    /// The parameters of the filter with a mixture for each particle.
    pub fn of(settings: &Settings, vehicle: &log::Vehicle, initial_pose: [f64; 3]) -> Self {
        Self::with_margin(settings, settings.filter.interval_margin, vehicle, initial_pose)
    }

    /// The parameters of a filter that multiplies the correlation time of odometry errors by `interval_margin`.
    pub fn with_margin(
        settings: &Settings,
        interval_margin: f64,
        vehicle: &log::Vehicle,
        initial_pose: [f64; 3],
    ) -> Self {
        let real = T::from_f64;
        let [x, y, heading] = initial_pose.map(real);
        Self {
            vehicle: Vehicle {
                noise: ControlNoise {
                    speed_sigma_mps: real(settings.vehicle.speed_sigma_mps),
                    speed_sigma_ratio: real(settings.vehicle.speed_sigma_ratio),
                    turn_sigma: real(settings.vehicle.turn_sigma),
                    turn_sigma_ratio: real(settings.vehicle.turn_sigma_ratio),
                    interval_s: real(settings.vehicle.noise_interval_s * interval_margin),
                },
                ..vehicle_of(vehicle)
            },
            sensors: settings.sensors().map(|sensor| sensor_of(settings, sensor)).collect(),
            config: planar_config(settings),
            start: PlanarPose::new(x, y, heading),
        }
    }
}

/// A vehicle of this kind and geometry. Its noise is that of `Description::robot`; the caller replaces it.
fn vehicle_of<T: Real>(vehicle: &log::Vehicle) -> Vehicle<T> {
    let robot = Description::robot().vehicle;
    let kind = match *vehicle {
        log::Vehicle::Ackermann { wheelbase_m, encoder_offset_m, sensor_forward_m, sensor_left_m } => {
            let geometry = AckermannGeometry {
                wheelbase_m: T::from_f64(wheelbase_m),
                encoder_offset_m: T::from_f64(encoder_offset_m),
                sensor_forward_m: T::from_f64(sensor_forward_m),
                sensor_left_m: T::from_f64(sensor_left_m),
            };
            return Vehicle { kind: VehicleKind::Ackermann, geometry, ..robot };
        }
        log::Vehicle::Unicycle => VehicleKind::UnicycleEuler,
        log::Vehicle::UnicycleArc => VehicleKind::Unicycle,
        log::Vehicle::Holonomic => VehicleKind::Holonomic,
    };
    Vehicle { kind, ..robot }
}

/// The configuration of `ScPhd`, with the settings of moving features.
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

fn sensor_of<T: Real>(settings: &Settings, sensor: &SensorSettings) -> Sensor<T> {
    let place = sensor.mounting();
    let window = limits_of(sensor);
    let sigma = [sensor.range_sigma_m, sensor.bearing_sigma_rad].map(T::from_f64);
    Sensor {
        range_sigma_ratio: T::from_f64(sensor.range_sigma_ratio),
        window,
        clutter_per_scan: T::from_f64(sensor.clutter_per_scan),
        births: Births {
            of_static: T::from_f64(sensor.birth_factor * settings.filter.birth_intensity),
            of_moving: T::from_f64(sensor.birth_factor * settings.moving.birth_intensity),
        },
        seat_m: [place.forward_m, place.left_m].map(T::from_f64),
        yaw_rad: T::from_f64(place.yaw_rad),
        ..Sensor::range_bearing(window.range_max_m, window.probability_near, sigma)
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
