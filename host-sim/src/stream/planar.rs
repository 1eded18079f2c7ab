//! Streams of planar vehicles.

use super::entry::{Entry, Stream, head, scan_interval_s};
use crate::events::{Event, events};
use crate::log::{Log, Vehicle};
use crate::settings::Settings;
use scphd_stream::planar::{self, Models, Odometry, Planar};
use scphd_stream::{Header, Joint, Moving, Numbers, Scalar};

/// The first `scans` scans of `log`, which has one sensor and no fixes of the pose, with all motion before them, and in its head whatever a filter must be told.
#[must_use]
pub fn write(log: &Log, settings: &Settings, seed: u64, scalar: Scalar, scans: usize) -> Stream {
    let scans = scans.min(log.scans.len());
    let mut taken = 0;
    let kept = events(log).take_while(|event| {
        let open = taken < scans;
        taken += usize::from(matches!(event, Event::Scan { .. }));
        open
    });
    let entries: Vec<Entry<'_, Planar>> = kept
        .filter_map(|event| match event {
            Event::Predict { control, dt_s, .. } => Some(Entry::Predict(Odometry { control, dt_s })),
            Event::Scan { index } => Some(Entry::Scan(&log.scans[index].detections)),
            Event::Fix { .. } => None,
        })
        .collect();
    let Settings { moving, joint, .. } = settings;
    let header = Header {
        vehicle: match log.vehicle {
            Vehicle::Ackermann { .. } => planar::Vehicle::Ackermann,
            Vehicle::Unicycle => planar::Vehicle::Unicycle,
            Vehicle::UnicycleArc => planar::Vehicle::UnicycleArc,
        },
        models: models(log, settings),
        moving: Moving {
            birth_intensity: moving.birth_intensity,
            velocity_sigma_mps: moving.velocity_sigma_mps,
            acceleration_psd: moving.acceleration_psd,
            lifetime_s: moving.lifetime_s,
            spread_max_m: moving.spread_max_m,
            extraction_weight: moving.extraction_weight,
        },
        joint: Joint {
            in_sight_s: joint.in_sight_s,
            hidden_s: joint.hidden_s,
            lifetime_s: joint.lifetime_s,
            behind: joint.behind,
            merge_distance: joint.merge_distance,
        },
        scan_interval_s: scan_interval_s(log.scans.iter().map(|scan| scan.t_s)),
        ..head(&settings.filter, seed, scalar)
    };
    Stream::of(header, &entries)
}

fn models(log: &Log, settings: &Settings) -> Models {
    let Settings { vehicle, sensor, .. } = settings;
    let [start_x_m, start_y_m, start_heading_rad] = log.initial_pose;
    let mut models = Models {
        start_x_m,
        start_y_m,
        start_heading_rad,
        speed_sigma_mps: vehicle.speed_sigma_mps,
        speed_sigma_ratio: vehicle.speed_sigma_ratio,
        turn_sigma: vehicle.turn_sigma,
        turn_sigma_ratio: vehicle.turn_sigma_ratio,
        noise_interval_s: vehicle.noise_interval_s,
        mounted_forward_m: sensor.forward_m,
        mounted_left_m: sensor.left_m,
        mounted_yaw_rad: sensor.yaw_rad,
        range_sigma_m: sensor.range_sigma_m,
        bearing_sigma_rad: sensor.bearing_sigma_rad,
        range_min_m: sensor.range_min_m,
        range_max_m: sensor.range_max_m,
        range_edge_m: sensor.range_edge_m,
        bearing_center_rad: sensor.bearing_center_rad(),
        bearing_half_width_rad: sensor.bearing_half_width_rad(),
        bearing_edge_rad: sensor.bearing_edge_rad,
        detection_near: sensor.detection_near,
        detection_far: sensor.detection_far,
        clutter_per_scan: sensor.clutter_per_scan,
        ..Models::ZERO
    };
    if let Vehicle::Ackermann { wheelbase_m, encoder_offset_m, sensor_forward_m, sensor_left_m } = log.vehicle {
        models.wheelbase_m = wheelbase_m;
        models.encoder_offset_m = encoder_offset_m;
        models.sensor_forward_m = sensor_forward_m;
        models.sensor_left_m = sensor_left_m;
    }
    models
}
