//! Logs with the greatest cost for a filter with given capacities.

use scphd_filters::settings::Settings;
use scphd_log::log::{FixNoise, Log, Mounting, Nominal, Odometry, Scan, Sensor, Vehicle};
use scphd_log::noise::Noise;
use std::f64::consts::PI;

const RANGE_MAX_M: f64 = 15.0;
const SCANS: usize = 24;
const SCANS_PER_SECOND: f64 = 10.0;

/// A vehicle at rest that turns slowly while its sensor reports `measurements` random positions, with settings for the greatest
/// cost: noise so large that every component may have caused every measurement, no merging, births of both kinds for all of them,
/// nothing forgotten, no resampling.
///
/// The particles and samples in the settings are the capacities of the caller's memory; the map grows until all pages are in use
/// and every update exceeds its capacity.
pub fn worst_case(particles: usize, samples: usize, measurements: usize) -> (Log, Settings) {
    let mut noise = Noise::new(1);
    let scans: Vec<Scan> = (0..SCANS)
        .map(|k| {
            let mut place = || [RANGE_MAX_M * (0.05 + 0.9 * noise.uniform()), PI * (2.0 * noise.uniform() - 1.0)];
            let detections = (0..measurements).map(|_| place()).collect();
            Scan { t_s: k as f64 / SCANS_PER_SECOND, detections, ..Scan::default() }
        })
        .collect();
    let log = Log {
        name: "worst-case".into(),
        initial_pose: [0.0; 3],
        vehicle: Vehicle::Ackermann {
            wheelbase_m: 1.415,
            encoder_offset_m: 0.38,
            sensor_forward_m: 1.89,
            sensor_left_m: 0.25,
        },
        sensor: Sensor {
            range_min_m: 0.0,
            range_max_m: RANGE_MAX_M,
            bearing_min_rad: -PI,
            bearing_max_rad: PI,
            mounting: Mounting::NONE,
        },
        sensor_name: String::new(),
        others: Vec::new(),
        fixes: Vec::new(),
        fix_noise: FixNoise::default(),
        nominal: Nominal {
            range_sigma_m: Some(RANGE_MAX_M),
            range_sigma_ratio: 0.0,
            bearing_sigma_rad: Some(3.0),
            speed_sigma_mps: Some(0.01),
            steering_sigma_rad: Some(0.01),
            rate_sigma_radps: None,
            detection_probability: Some(0.5),
            clutter_per_scan: Some(1.0),
        },
        simulated: true,
        odometry: (0..2 * SCANS)
            .map(|k| Odometry { t_s: k as f64 / (2.0 * SCANS_PER_SECOND), control: [0.1, 0.3, 0.0] })
            .collect(),
        scans,
        truth: Vec::new(),
        truth_sigma_m: 0.0,
        landmarks: Vec::new(),
        moving: Vec::new(),
    };
    let mut settings = Settings::for_log(&log);
    settings.filter.particles = particles;
    settings.filter.samples = samples;
    settings.filter.birth_intensity = 1.0;
    settings.filter.resample_threshold = 0.0;
    settings.filter.prune_weight = 1e-6;
    settings.filter.merge_distance = 0.0;
    settings.filter.max_components = 65_536;
    settings.sensor.range_edge_m = 0.0;
    settings.moving.birth_intensity = 1.0;
    settings.moving.spread_max_m = 1e6;
    settings.moving.lifetime_s = 1e9;
    (log, settings)
}

/// A vehicle at rest among `measurements` landmarks, all of which are detected in every scan, with settings for the greatest cost
/// of a joint map in a scan: every measurement is associated with several features, so that all features are corrected by all
/// measurements, nevertheless there are some births, and features are merged. With wider gates a feature has a smaller share of
/// each measurement, with narrower ones nothing is merged: the noise was chosen by trials, for the longest scan on a Cortex-M7.
/// With moving-object tracks every birth also starts a track, and tracks are never removed for their uncertainty; with a higher
/// birth intensity of moving objects the features would have a smaller share.
pub fn worst_case_joint(measurements: usize) -> (Log, Settings) {
    let (mut log, _) = worst_case(1, 1, measurements);
    let seen = log.scans.first().map(|scan| scan.detections.clone()).unwrap_or_default();
    log.scans.iter_mut().for_each(|scan| scan.detections.clone_from(&seen));
    log.odometry.iter_mut().for_each(|row| row.control = [0.0; 3]);
    log.nominal.range_sigma_m = Some(2.0);
    log.nominal.bearing_sigma_rad = Some(0.2);
    log.nominal.detection_probability = Some(0.9);
    let mut settings = Settings::for_log(&log);
    settings.filter.particles = 1;
    settings.filter.samples = 1;
    settings.filter.birth_intensity = 1.0;
    settings.filter.prune_weight = 1e-6;
    settings.sensor.range_edge_m = 0.0;
    settings.moving.birth_intensity = 0.05;
    settings.moving.velocity_sigma_mps = 5.0;
    settings.moving.spread_max_m = 1e6;
    settings.moving.lifetime_s = 1e9;
    (log, settings)
}
