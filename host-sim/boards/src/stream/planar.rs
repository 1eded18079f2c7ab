//! Streams of planar vehicles.

use super::entry::{Entry, Stream, head, scan_interval_s};
use scphd::settings::HypothesesConfig;
use scphd_filters::settings::{SensorSettings, Settings};
use scphd_filters::slam::contract::{Refusal, refusal};
use scphd_filters::slam::joint_config;
use scphd_log::events::{Event, events};
use scphd_log::log::{FixNoise, Log, PoseFix, Vehicle};
use scphd_stream::planar::{self, Fix, Models, Odometry, Planar, SensorModels};
use scphd_stream::{Header, Joint, Kind, Moving, Numbers, Recursion, Scalar, Which};

/// The first `scans` scans of `log` with all motion and fixes before them; the parameters of the filter are in the header, or in
/// records before the others.
///
/// # Errors
/// The log has more sensors than a stream can have, or fixes without stated noise.
pub fn write(log: &Log, settings: &Settings, seed: u64, scalar: Scalar, scans: usize) -> Result<Stream, Refusal> {
    let scans = scans.min(log.scans.len());
    let too_many = || refusal(format_args!("a stream has at most {} sensors", Planar::DETECTORS));
    let which = |sensor: usize| u8::try_from(sensor).ok().and_then(Which::number).ok_or_else(too_many);
    let others = settings
        .others
        .iter()
        .enumerate()
        .map(|(place, (_, sensor))| Ok(Entry::Detector(which(place + 1)?, detector(settings, sensor))));
    let mut taken = 0;
    let kept = events(log).take_while(|event| {
        let open = taken < scans;
        taken += usize::from(matches!(event, Event::Scan { .. }));
        open
    });
    let records = kept.map(|event| match event {
        Event::Predict { control: [speed, turn, _], dt_s, .. } => {
            Ok(Entry::Predict(Odometry { control: [speed, turn], dt_s }))
        }
        Event::Scan { index } => Ok(Entry::Scan(which(log.scans[index].sensor)?, &log.scans[index].detections)),
        Event::Fix { fix: measured } => Ok(Entry::Fix(fix(&settings.fixes.unwrap_or_default(), measured)?)),
    });
    let entries: Vec<Entry<'_, Planar>> = others.chain(records).collect::<Result<_, Refusal>>()?;
    if settings.calibration.is_some() {
        return Err(Refusal("calibration: a stream has no vehicle that learns what its odometry is off by".into()));
    }
    if settings.joint.hypotheses > 1 {
        return Err(Refusal("joint.hypotheses: a stream has one".into()));
    }
    let Settings { sensor, moving, joint, .. } = settings;
    let first = detector(settings, sensor);
    let head = head(&settings.filter, seed, scalar);
    let header = Header {
        vehicle: match log.vehicle {
            Vehicle::Ackermann { .. } => planar::Vehicle::Ackermann,
            Vehicle::Unicycle => planar::Vehicle::Unicycle,
            Vehicle::UnicycleArc => planar::Vehicle::UnicycleArc,
            Vehicle::Holonomic => return Err(Refusal("vehicle: a stream has no holonomic one".into())),
        },
        models: models(log, settings, first.models),
        moving: Moving {
            birth_intensity: first.moving_birth_intensity,
            velocity_sigma_mps: moving.velocity_sigma_mps,
            acceleration_psd: moving.acceleration_psd,
            lifetime_s: moving.lifetime_s,
            spread_max_m: moving.spread_max_m,
            extraction_weight: moving.extraction_weight,
        },
        joint: Joint::of(&joint_config::<f64>(joint), &HypothesesConfig::default()),
        scan_interval_s: scan_interval_s(log.scans.iter().map(|scan| scan.t_s)),
        recursion: Recursion { birth_intensity: first.birth_intensity, ..head.recursion },
        ..head
    };
    Ok(Stream::of(header, &entries))
}

/// A fix with this noise.
fn fix(noise: &FixNoise, measured: PoseFix) -> Result<Fix, Refusal> {
    let unstated = |what| refusal(format_args!("fixes.{what}: not stated"));
    let gate = noise.gate();
    Ok(match measured {
        PoseFix::Position(place_m) => Fix::Position {
            place_m,
            sigma_m: noise.position_sigma_m.ok_or_else(|| unstated("position_sigma_m"))?,
            gate,
            antenna_m: [noise.forward_m, noise.left_m],
        },
        PoseFix::Heading(heading_rad) => Fix::Heading {
            heading_rad,
            sigma_rad: noise.heading_sigma_rad.ok_or_else(|| unstated("heading_sigma_rad"))?,
            gate,
        },
    })
}

/// A sensor with its births.
fn detector(settings: &Settings, sensor: &SensorSettings) -> planar::Sensor {
    let models = SensorModels {
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
    };
    planar::Sensor {
        models,
        birth_intensity: sensor.birth_factor * settings.filter.birth_intensity,
        moving_birth_intensity: sensor.birth_factor * settings.moving.birth_intensity,
    }
}

fn models(log: &Log, settings: &Settings, sensor: SensorModels) -> Models {
    let vehicle = &settings.vehicle;
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
        sensor,
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
