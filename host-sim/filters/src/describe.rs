//! The description of a vehicle from a log with its settings, for use outside the simulator.

use crate::settings::Settings;
use crate::slam::{PlanarNumbers, PlanarVehicle, joint_config};
use scphd::models::{OdometryCorrection, OdometryPrior, Step};
use scphd::settings::HypothesesConfig;
use scphd_log::log::{FixNoise, Log};
use scphd_vehicle::{Description, Filter, FixSpec, JointSettings, Sensor, VehicleKind};

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
    let odometry = settings.calibration.as_ref().map(|calibration| OdometryPrior {
        sigma: OdometryCorrection {
            speed_scale: calibration.speed_scale_sigma,
            turn_scale: calibration.turn_scale_sigma,
            turn_offset: calibration.turn_offset_sigma,
        },
        lasts_s: calibration.lasts_s,
    });
    let movers = (settings.moving.birth_intensity > 0.0).then_some(numbers.config.moving);
    let config = joint_config(&settings.joint);
    let most = settings.joint.hypotheses;
    let hypotheses = (most > 1).then(|| HypothesesConfig { most, ..HypothesesConfig::default() });
    let joint = JointSettings { config, movers, odometry, archive_reach_m: None, hypotheses };
    description.filter = Filter::Joint(joint);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::CalibrationSettings;
    use crate::slam::{Precision, joint_filter};
    use nalgebra::Vector2;
    use scphd_vehicle::{Backing, Control, Measurements, Services as _, Slam as _, joint_backing};
    use scphd_worlds::scenario;

    joint_backing! { struct Plain: PlanarPose<f64> { features: 60, measurements: 64 } }
    joint_backing! { struct Movers: PlanarPose<f64> { features: 60, measurements: 64, movers: 32 } }
    joint_backing! { struct Calibrated: CalibratedPose<f64> { features: 60, measurements: 64 } }
    joint_backing! { struct Several: PlanarPose<f64> { features: 60, measurements: 64, hypotheses: 8 } }
    joint_backing! { struct Both: PlanarPose<f64> { features: 60, measurements: 64, movers: 32, hypotheses: 8 } }

    /// Compares the digests after every scan of the simulator's filter and of that of the description.
    fn agree(log: &Log, settings: &Settings, memory: &mut impl Backing<f64>) {
        let mut host = joint_filter(settings, &log.vehicle, log.initial_pose, Precision::F64).unwrap();
        let description = description(log, settings);
        let mut slam = memory.start(&description).unwrap();
        slam.reset(&description.start).unwrap();
        for (row, scan) in log.odometry.iter().zip(&log.scans).take(60) {
            let [speed_mps, turn, left_mps] = row.control;
            host.predict(row.control, 0.1).unwrap();
            slam.predict(Control { speed_mps, turn, left_mps }, 0.1).unwrap();
            // As many as 60 features can be made of.
            let detections = &scan.detections[..scan.detections.len().min(5)];
            host.scan(0, detections).unwrap();
            let measurements: Vec<_> = detections.iter().map(|&z| Vector2::from(z)).collect();
            slam.scan(0, Measurements::RangeBearing(&measurements)).unwrap();
            assert_eq!(host.digest(), Some(slam.digest()), "{:?}", description.filter);
        }
    }

    #[test]
    fn the_filter_of_a_description_is_the_simulators_with_every_optional_part() {
        let log = scenario::by_name("thesis-dynamic", 3).unwrap();
        let plain = Settings::for_log(&log);
        let mut moving = plain.clone();
        moving.moving.birth_intensity = 1e-3;
        let calibration = CalibrationSettings {
            speed_scale_sigma: 0.05,
            turn_scale_sigma: 0.05,
            turn_offset_sigma: 0.02,
            lasts_s: 3600.0,
        };
        let calibrated = Settings { calibration: Some(calibration), ..plain.clone() };
        let [mut several, mut both] = [plain.clone(), moving.clone()];
        (several.joint.hypotheses, both.joint.hypotheses) = (8, 8);
        agree(&log, &plain, &mut *Box::new(Plain::new()));
        agree(&log, &moving, &mut *Box::new(Movers::new()));
        agree(&log, &calibrated, &mut *Box::new(Calibrated::new()));
        agree(&log, &several, &mut *Box::new(Several::new()));
        agree(&log, &both, &mut *Box::new(Both::new()));
    }
}
