//! The description of a vehicle from a log with its settings, for use outside the simulator.

use crate::settings::{FilterSettings, Settings};
use crate::slam::{PlanarNumbers, config_of, joint_config, odometry_prior};
use scphd::Births;
use scphd::settings::HypothesesConfig;
use scphd_log::log::{FixNoise, Log};
use scphd_vehicle::{Description, Filter, FixSpec, JointSettings, Sensor};

/// The joint map with the settings of a log; the number of sensors is limited.
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
pub fn mixture(log: &Log, settings: &Settings, seed: u64) -> Description<f64> {
    let numbers = PlanarNumbers::<f64>::of(settings, &log.vehicle, log.initial_pose);
    let mut description = description(log, settings);
    description.vehicle = numbers.vehicle;
    description.filter = Filter::Mixture(numbers.config);
    description.start.seed = seed;
    description
}

/// The filter under water, and the births of its camera; a description has no other models of such a vehicle.
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
