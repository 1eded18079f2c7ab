//! Logs and scenarios as the binary stream that a vehicle computer reads (`docs/stream.md`).

mod worst_case;

pub use worst_case::worst_case;

use crate::events::{Event, events};
use crate::log::{Log, Vehicle};
use crate::settings::{self, Settings};
use scphd_stream::{Extraction, Header, Likelihood, Proposal, Reduction, Scalar, Writer};
use std::convert::Infallible;

/// What [`write()`] put into a stream.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stream {
    /// The stream.
    pub bytes: Vec<u8>,
    /// Predictions in it.
    pub predictions: u32,
    /// Scans in it.
    pub scans: u32,
    /// The most measurements of a scan.
    pub most_measurements: u32,
}

/// The first `scans` scans of `log` with all motion before them, and in its head whatever a filter must be told.
#[must_use]
pub fn write(log: &Log, settings: &Settings, seed: u64, scalar: Scalar, scans: usize) -> Stream {
    let scans = scans.min(log.scans.len());
    let kept = &log.scans[..scans];
    let mut taken = 0;
    let records: Vec<Event> = events(log)
        .take_while(|event| {
            let open = taken < scans;
            taken += usize::from(matches!(event, Event::Scan { .. }));
            open
        })
        .collect();
    let most_measurements = kept.iter().map(|scan| scan.detections.len()).max().unwrap_or(0);
    let mut header = head(log, settings, seed, scalar);
    header.scans = count(scans);
    header.predictions = count(records.len() - scans);
    header.most_measurements = count(most_measurements);
    let mut bytes = Vec::new();
    let Ok(()) = fill(log, &header, &records, &mut bytes);
    Stream { bytes, predictions: header.predictions, scans: header.scans, most_measurements: header.most_measurements }
}

/// Writing to memory cannot fail.
fn fill(log: &Log, header: &Header, records: &[Event], bytes: &mut Vec<u8>) -> Result<(), Infallible> {
    let mut writer = Writer::start(header, |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        Ok(())
    })?;
    for record in records {
        match *record {
            Event::Predict { control, dt_s } => writer.predict(control, dt_s)?,
            Event::Scan { index } => writer.scan(&log.scans[index].detections)?,
        }
    }
    writer.end()
}

/// No log is so long that it does not fit.
fn count(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(scphd_stream::UNKNOWN)
}

/// The median time from scan to scan, s; 0 where there are no two.
fn scan_interval_s(log: &Log) -> f64 {
    let mut intervals: Vec<f64> = log.scans.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).collect();
    intervals.sort_by(f64::total_cmp);
    intervals.get(intervals.len() / 2).copied().unwrap_or(0.0)
}

fn head(log: &Log, settings: &Settings, seed: u64, scalar: Scalar) -> Header {
    let Settings { filter, vehicle, sensor, moving } = settings;
    let [start_x_m, start_y_m, start_heading_rad] = log.initial_pose;
    let mut header = Header {
        scalar,
        vehicle: match log.vehicle {
            Vehicle::Ackermann { .. } => scphd_stream::Vehicle::Ackermann,
            Vehicle::Unicycle => scphd_stream::Vehicle::Unicycle,
            Vehicle::UnicycleArc => scphd_stream::Vehicle::UnicycleArc,
        },
        likelihood: match filter.likelihood {
            settings::Likelihood::SingleCluster => Likelihood::SingleCluster,
            settings::Likelihood::RbEmpty => Likelihood::RbEmpty,
            settings::Likelihood::RbSingle => Likelihood::RbSingle,
        },
        reduction: match filter.reduction {
            settings::Reduction::Greedy => Reduction::Greedy,
            settings::Reduction::Runnalls => Reduction::Runnalls,
        },
        proposal: match filter.proposal {
            settings::Proposal::Blind => Proposal::Blind,
            settings::Proposal::Informed => Proposal::Informed,
        },
        extraction: match filter.extraction {
            settings::Extraction::Heaviest => Extraction::Heaviest,
            settings::Extraction::Peaks => Extraction::Peaks,
            settings::Extraction::Confirmed => Extraction::Confirmed,
        },
        particles: count(filter.particles),
        samples: count(filter.samples),
        max_components: count(filter.max_components),
        seed,
        start_x_m,
        start_y_m,
        start_heading_rad,
        speed_sigma_mps: vehicle.speed_sigma_mps,
        speed_sigma_ratio: vehicle.speed_sigma_ratio,
        turn_sigma: vehicle.turn_sigma,
        turn_sigma_ratio: vehicle.turn_sigma_ratio,
        noise_interval_s: vehicle.noise_interval_s,
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
        birth_intensity: filter.birth_intensity,
        resample_threshold: filter.resample_threshold,
        prune_weight: filter.prune_weight,
        confirming_detections: filter.confirming_detections,
        unconfirmed_weight: filter.unconfirmed_weight,
        confirmed_weight: filter.confirmed_weight,
        merge_distance: filter.merge_distance,
        merge_cost: filter.merge_cost,
        extraction_weight: filter.extraction_weight,
        proposal_rounds: f64::from(count(filter.proposal_rounds)),
        proposal_drawn: filter.proposal_drawn,
        proposal_least_share: filter.proposal_least_share,
        moving_birth_intensity: moving.birth_intensity,
        velocity_sigma_mps: moving.velocity_sigma_mps,
        acceleration_psd: moving.acceleration_psd,
        lifetime_s: moving.lifetime_s,
        spread_max_m: moving.spread_max_m,
        moving_extraction_weight: moving.extraction_weight,
        scan_interval_s: scan_interval_s(log),
        ..Header::EMPTY
    };
    if let Vehicle::Ackermann { wheelbase_m, encoder_offset_m, sensor_forward_m, sensor_left_m } = log.vehicle {
        header.wheelbase_m = wheelbase_m;
        header.encoder_offset_m = encoder_offset_m;
        header.sensor_forward_m = sensor_forward_m;
        header.sensor_left_m = sensor_left_m;
    }
    header
}
