//! Streams of underwater vehicles.

use super::{Entry, Stream, head, scan_interval_s};
use crate::slam::Refusal;
use crate::underwater::log::Log;
use crate::underwater::settings::Settings;
use crate::underwater::timeline::Timeline;
use scphd_stream::underwater::{Models, Underwater};
use scphd_stream::{Header, Scalar};

/// The first `scans` frames of `log` with all that the instruments said before them, and in its head whatever a filter must be
/// told.
///
/// # Errors
/// The log has no instruments.
pub fn write(log: &Log, settings: &Settings, seed: u64, scalar: Scalar, scans: usize) -> Result<Stream, Refusal> {
    let mut timeline = Timeline::new(log, settings.vehicle.yaw_rate_sigma_radps);
    let mut entries: Vec<Entry<'_, Underwater>> = Vec::new();
    for frame in log.frames.iter().take(scans) {
        entries.extend(timeline.steps_to(frame.t_s).into_iter().map(|step| Entry::Predict(step.navigation)));
        entries.push(Entry::Scan(&frame.keypoints));
    }
    let header = Header {
        models: models(log, settings)?,
        scan_interval_s: scan_interval_s(log.frames.iter().map(|frame| frame.t_s)),
        ..head(&settings.filter, seed, scalar)
    };
    Ok(Stream::of(header, &entries))
}

/// Where a log's vehicle starts and what is known of it, its instruments and its camera.
///
/// # Errors
/// The log has no instruments.
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
