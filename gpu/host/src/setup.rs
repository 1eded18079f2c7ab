//! Models and tuning of a planar log as the plain numbers of a run.

use crate::unfit::Unfit;
use scphd::Config;
use scphd::settings::{Extraction, Informed, Proposal};
use scphd_filters::slam::PlanarNumbers;
use scphd_gpu_kernels::{MOUNTED, Setup, extraction, vehicle};
use scphd_vehicle::{Vehicle, VehicleKind};

/// The numbers of a run, for a filter with at most `room` particles and samples of each.
///
/// # Errors
/// The kernels have no capacity or no code for such a filter; the error names the reason.
pub fn setup_of(numbers: &PlanarNumbers<f32>, room: [usize; 2]) -> Result<Setup, Unfit> {
    let PlanarNumbers { vehicle, sensors, config, start } = numbers;
    let noise = vehicle.noise;
    let [sensor] = &sensors[..] else { return Err(Unfit(format!("{} sensors; there may be one", sensors.len()))) };
    if sensor.range_sigma_ratio != 0.0 {
        return Err(Unfit("noise that grows with the range (sensor.range_sigma_ratio)".to_owned()));
    }
    let limits = sensor.window;
    let [forward_m, left_m] = sensor.seat_m;
    let mounting = [forward_m, left_m, sensor.yaw_rad];
    Ok(Setup {
        speed_sigma_mps: noise.speed_sigma_mps,
        speed_sigma_ratio: noise.speed_sigma_ratio,
        turn_sigma: noise.turn_sigma,
        turn_sigma_ratio: noise.turn_sigma_ratio,
        noise_interval_s: noise.interval_s,
        start: [start.x_m, start.y_m, start.heading_rad],
        range_sigma_m: sensor.range_sigma_m,
        bearing_sigma_rad: sensor.bearing_sigma_rad,
        range_min_m: limits.range_min_m,
        range_max_m: limits.range_max_m,
        range_edge_m: limits.range_edge_m,
        bearing_center_rad: limits.bearing_center_rad,
        bearing_half_width_rad: limits.bearing_half_width_rad,
        bearing_edge_rad: limits.bearing_edge_rad,
        probability_near: limits.probability_near,
        probability_far: limits.probability_far,
        clutter_per_scan: sensor.clutter_per_scan,
        is_mounted: if mounting == [0.0; 3] { 0 } else { MOUNTED },
        mounting,
        births_of_static: sensor.births.of_static,
        births_of_moving: sensor.births.of_moving,
        ..of_config(config, room, of_vehicle(vehicle)?)?
    })
}

/// A setup with the fields of the vehicle; all others are zero.
fn of_vehicle(Vehicle { kind, geometry, .. }: &Vehicle<f32>) -> Result<Setup, Unfit> {
    let nothing: Setup = bytemuck::Zeroable::zeroed();
    Ok(match kind {
        VehicleKind::Ackermann => Setup {
            vehicle: vehicle::ACKERMANN,
            wheelbase_m: geometry.wheelbase_m,
            encoder_offset_m: geometry.encoder_offset_m,
            sensor_forward_m: geometry.sensor_forward_m,
            sensor_left_m: geometry.sensor_left_m,
            ..nothing
        },
        VehicleKind::UnicycleEuler => Setup { vehicle: vehicle::UNICYCLE, ..nothing },
        VehicleKind::Unicycle => Setup { vehicle: vehicle::UNICYCLE_ARC, ..nothing },
        VehicleKind::Holonomic => return Err(Unfit("a holonomic vehicle".into())),
    })
}

fn of_config(config: &Config<f32>, [particles, samples]: [usize; 2], setup: Setup) -> Result<Setup, Unfit> {
    let most = |count: usize, most: usize, of: &str| match u32::try_from(count) {
        Ok(number) if count <= most => Ok(number),
        _ => Err(Unfit(format!("{count} {of}; there is room for {most}"))),
    };
    if config.births_wait {
        return Err(Unfit("births that wait".to_owned()));
    }
    let informed = match config.proposal {
        Proposal::Blind => Informed { rounds: 0, sampled_fraction: 0.0, min_responsibility: 0.0 },
        Proposal::Informed(informed) => informed,
    };
    Ok(Setup {
        particles: most(config.particles, particles, "particles")?,
        samples: most(config.samples, samples, "samples of a particle")?,
        proposal_rounds: most(informed.rounds, 16, "rounds of the proposal")?,
        sampled_fraction: informed.sampled_fraction,
        min_responsibility: informed.min_responsibility,
        resample_threshold: config.resample_threshold,
        prune_weight: config.prune_weight,
        confirming_detections: config.confirming_detections,
        unconfirmed_weight: config.unconfirmed_weight,
        confirmed_weight: config.confirmed_weight,
        merge_distance: config.merge_distance,
        // A limit beyond `u32` exceeds every map of a slot, and has no effect.
        max_components: u32::try_from(config.max_components).unwrap_or(u32::MAX),
        extraction: match config.extraction {
            Extraction::Heaviest => extraction::HEAVIEST,
            Extraction::Peaks => extraction::PEAKS,
            Extraction::Confirmed => extraction::CONFIRMED,
        },
        extraction_weight: config.extraction_weight,
        velocity_sigma_mps: config.moving.velocity_sigma_mps,
        acceleration_psd: config.moving.motion.acceleration_psd,
        lifetime_s: config.moving.motion.lifetime_s,
        spread_max_m: config.moving.spread_max_m,
        moving_extraction_weight: config.moving.extraction_weight,
        negligible: config.negligible,
        step_max_s: config.plausible.step_max_s,
        speed_max_mps: config.plausible.speed_max_mps,
        turn_rate_max_radps: config.plausible.turn_rate_max_radps,
        jump_max_m: config.plausible.jump_max_m,
        ..setup
    })
}
