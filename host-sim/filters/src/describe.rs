//! The description of a vehicle from a log with its settings, for use outside the simulator.

use crate::settings::Settings;
use crate::slam::{PlanarNumbers, PlanarVehicle};
use scphd::JointConfig;
use scphd::models::{OdometryCorrection, OdometryPrior, Step};
use scphd::settings::Persistence;
use scphd_log::log::{FixNoise, Log};
use scphd_vehicle::{Description, Filter, FixSpec, JointFilter, Sensor, VehicleKind};

/// The joint map with the settings of a log; the number of sensors is limited.
#[must_use]
pub fn description(log: &Log, settings: &Settings) -> Description<f64> {
    let numbers = PlanarNumbers::<f64>::of(settings, &log.vehicle, log.initial_pose);
    let mut description = Description::robot();
    description.vehicle.noise = numbers.noise;
    // A joint map uses the stated correlation time of odometry errors, without a margin.
    description.vehicle.noise.interval_s = settings.vehicle.noise_interval_s;
    description.vehicle.kind = match numbers.vehicle {
        PlanarVehicle::Ackermann(geometry) => {
            description.vehicle.geometry = geometry;
            VehicleKind::Ackermann
        }
        PlanarVehicle::Unicycle(Step::Euler) => VehicleKind::UnicycleEuler,
        PlanarVehicle::Unicycle(_) => VehicleKind::Unicycle,
        PlanarVehicle::Holonomic => VehicleKind::Holonomic,
    };
    let joint = &settings.joint;
    let config = JointConfig {
        merge_distance: joint.merge_distance,
        persistence: Persistence {
            visible_s: joint.visible_s,
            occluded_s: joint.occluded_s,
            lifetime_s: joint.lifetime_s,
        },
        occlusion_factor: joint.occlusion_factor,
        ..JointConfig::default()
    };
    let odometry = settings.calibration.as_ref().map(|calibration| OdometryPrior {
        sigma: OdometryCorrection {
            speed_scale: calibration.speed_scale_sigma,
            turn_scale: calibration.turn_scale_sigma,
            turn_offset: calibration.turn_offset_sigma,
        },
        lasts_s: calibration.lasts_s,
    });
    let movers = (settings.moving.birth_intensity > 0.0).then_some(numbers.config.moving);
    description.filter = Filter::Joint(JointFilter { config, movers, odometry, archive_reach_m: None });
    for (place, of) in description.sensors.iter_mut().zip(&numbers.sensors) {
        let [forward_m, left_m, yaw_rad] = of.mounting.unwrap_or_default();
        *place = Some(Sensor {
            window: of.limits,
            clutter_per_scan: of.clutter_per_scan,
            births: of.births,
            seat_m: [forward_m, left_m],
            yaw_rad,
            ..Sensor::range_bearing(
                of.limits.range_max_m,
                of.limits.probability_near,
                [of.range_sigma_m, of.bearing_sigma_rad],
            )
        });
    }
    let fixes = settings.fixes.filter(|_| !log.fixes.is_empty());
    let spec = |sigma: Option<f64>, antenna_m| {
        let noise = fixes?;
        let watch = Some(noise.rule());
        Some(FixSpec { sigma: sigma?, antenna_m, gate: noise.gate.unwrap_or(FixNoise::USUAL_GATE), watch })
    };
    let FixNoise { position_sigma_m, heading_sigma_rad, forward_m, left_m, .. } = fixes.unwrap_or_default();
    description.position = spec(position_sigma_m, [forward_m, left_m]);
    description.heading = spec(heading_sigma_rad, [0.0; 2]);
    description.start.pose = numbers.start;
    description
}
