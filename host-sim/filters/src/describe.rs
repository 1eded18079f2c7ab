//! The description of a vehicle from a log with its settings, for use outside the simulator.

use crate::settings::{FilterSettings, Settings};
use crate::slam::{PlanarNumbers, config_of, joint_config, odometry_prior};
use scphd::Births;
use scphd::settings::HypothesesConfig;
use scphd_log::log::{FixNoise, Log};
use scphd_vehicle::{Description, Filter, FixSpec, JointSettings, Sensor};

/// The joint map with the settings of a log; the number of sensors is limited.
#[must_use]
pub fn description(log: &Log, settings: &Settings) -> Description<f64> {
    let numbers = PlanarNumbers::<f64>::of(settings, &log.vehicle, log.initial_pose);
    let mut description = Description::robot();
    description.vehicle = numbers.vehicle;
    // A joint map uses the stated correlation time of odometry errors, without a margin.
    description.vehicle.noise.interval_s = settings.vehicle.noise_interval_s;
    let odometry = settings.calibration.as_ref().map(odometry_prior);
    let movers = (settings.moving.birth_intensity > 0.0).then_some(numbers.config.moving);
    let config = joint_config(&settings.joint);
    let most = settings.joint.hypotheses;
    let hypotheses = (most > 1).then(|| HypothesesConfig { most, ..HypothesesConfig::default() });
    let joint = JointSettings { config, movers, odometry, archive_reach_m: None, hypotheses };
    description.filter = Filter::Joint(joint);
    for (place, sensor) in description.sensors.iter_mut().zip(numbers.sensors) {
        *place = Some(sensor);
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

/// The same vehicle with the mixture of the settings, whose random numbers have this seed.
#[must_use]
pub fn mixture(log: &Log, settings: &Settings, seed: u64) -> Description<f64> {
    let numbers = PlanarNumbers::<f64>::of(settings, &log.vehicle, log.initial_pose);
    let mut description = description(log, settings);
    description.vehicle = numbers.vehicle;
    description.filter = Filter::Mixture(numbers.config);
    description.start.seed = seed;
    description
}

/// The filter under water, and the births of its camera; a description has no other models of such a vehicle.
#[must_use]
pub fn under_water(filter: &FilterSettings, is_joint: bool, seed: u64) -> Description<f64> {
    let mut description = Description::robot();
    description.filter = if is_joint {
        Filter::Joint(JointSettings { config: scphd_stream::underwater::joint_config(), ..JointSettings::default() })
    } else {
        Filter::Mixture(config_of(filter))
    };
    let births = Births::of_static(filter.birth_intensity);
    description.sensors[0] = Some(Sensor { births, ..Sensor::range_bearing(1.0, 0.5, [1.0; 2]) });
    description.start.seed = seed;
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

    /// Compares the digests after every scan of the simulator's filter and of that of the description.
    fn agree(log: &Log, settings: &Settings, memory: &mut impl Backing<f64>) {
        let mut host = joint_filter(settings, &log.vehicle, log.initial_pose, Precision::F64).unwrap();
        let description = description(log, settings);
        let mut slam = memory.start(&description).unwrap();
        slam.reset(&description.start).unwrap();
        for (row, scan) in log.odometry.iter().zip(&log.scans).take(50) {
            let [speed_mps, turn, left_mps] = row.control;
            host.predict(row.control, 0.1).unwrap();
            slam.predict(Control { speed_mps, turn, left_mps }, 0.1).unwrap();
            // As many as the memory has room for.
            let detections = &scan.detections[..scan.detections.len().min(4)];
            host.scan(0, detections).unwrap();
            let measurements: Vec<_> = detections.iter().map(|&z| Vector2::from(z)).collect();
            slam.scan(0, Measurements::RangeBearing(&measurements)).unwrap();
            assert_eq!(host.digest(), Some(slam.digest()), "{:?}", description.filter);
        }
    }

    /// A test with memory for these optional parts, on a stack that holds the simulator's filter before it is on the heap.
    macro_rules! is_the_simulators {
        ($name:ident: $pose:ident $(, $part:ident: $capacity:literal)* => $change:expr) => {
            #[test]
            fn $name() {
                joint_backing! {
                    struct Memory: $pose<f64> { features: 40, measurements: 8 $(, $part: $capacity)* }
                }
                let log = scenario::by_name("thesis-dynamic", 3).unwrap();
                let mut settings = Settings::for_log(&log);
                let change: fn(&mut Settings) = $change;
                change(&mut settings);
                let work = move || agree(&log, &settings, &mut *Box::new(Memory::new()));
                std::thread::Builder::new().stack_size(1 << 28).spawn(work).unwrap().join().unwrap();
            }
        };
    }
    is_the_simulators!(plain: PlanarPose => |_| ());
    is_the_simulators!(with_noise_that_grows: PlanarPose => |settings| settings.sensor.range_sigma_ratio = 0.05);
    is_the_simulators!(with_tracks: PlanarPose, movers: 16 => |settings| settings.moving.birth_intensity = 1e-3);
    is_the_simulators!(with_calibration: CalibratedPose => |settings| {
        settings.calibration = Some(CalibrationSettings {
            speed_scale_sigma: 0.05,
            turn_scale_sigma: 0.05,
            turn_offset_sigma: 0.02,
            lasts_s: 3600.0,
        });
    });
    is_the_simulators!(with_hypotheses: PlanarPose, hypotheses: 8 => |settings| settings.joint.hypotheses = 8);
    is_the_simulators!(with_both: PlanarPose, movers: 16, hypotheses: 8 => |settings| {
        settings.joint.hypotheses = 8;
        settings.moving.birth_intensity = 1e-3;
    });
}
