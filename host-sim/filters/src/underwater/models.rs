//! Models of an underwater vehicle for a filter.

use super::settings::Settings;
use crate::slam::contract::Refusal;
use scphd_log::underwater::Log;
use scphd_stream::underwater::Models;

/// Initial state of a log's vehicle with its uncertainty, instruments and camera.
pub fn models(log: &Log, settings: &Settings) -> Result<Models, Refusal> {
    let first = log.instruments.first().ok_or_else(|| Refusal("the log has no instruments".into()))?;
    let Settings { vehicle, camera, .. } = settings;
    let (start_m, start_yaw_rad) = log.start;
    Ok(Models {
        start_m,
        start_yaw_rad,
        start_tilt_rad: [first.roll_rad, first.pitch_rad],
        velocity_walk_mps_rts: vehicle.velocity_walk_mps_rts,
        velocity_sigma_mps: vehicle.velocity_sigma_mps,
        z_sigma_m: vehicle.z_sigma_m,
        gate_sigmas: vehicle.gate_sigmas,
        outliers_believed: f64::from(vehicle.outliers_believed),
        yaw_acceleration_sigma_radps2: vehicle.yaw_acceleration_sigma_radps2,
        velocity_interval_s: vehicle.velocity_interval_s,
        projections: log.camera.projections,
        pixel_sigmas: camera.pixel_sigmas,
        common_sigmas: camera.common_sigmas,
        epipolar_gate: camera.epipolar_gate,
        size_px: log.camera.size_px,
        edge_px: camera.edge_px,
        near_m: camera.near_m,
        far_m: camera.far_m,
        depth_edge_m: camera.depth_edge_m,
        detection: camera.detection,
        clutter_per_scan: camera.clutter_per_scan,
        disparities_px: settings.disparities_px(log),
        row_tolerance_px: log.camera.row_tolerance_px,
    })
}
