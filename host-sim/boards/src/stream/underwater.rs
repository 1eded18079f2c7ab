//! Streams of underwater vehicles.

use super::entry::{Entry, Stream, head, scan_interval_s};
use scphd::settings::HypothesesConfig;
use scphd_filters::slam::contract::Refusal;
use scphd_filters::underwater::models::models;
use scphd_filters::underwater::settings::Settings;
use scphd_filters::underwater::timeline::Timeline;
use scphd_log::underwater::Log;
use scphd_stream::underwater::{Underwater, joint_config};
use scphd_stream::{Header, Joint, Scalar, Which};

/// The first `scans` frames of `log` with all readings of the instruments before them; the parameters of the filter are in the
/// header.
///
/// # Errors
/// The log has no instruments.
pub fn write(log: &Log, settings: &Settings, seed: u64, scalar: Scalar, scans: usize) -> Result<Stream, Refusal> {
    let mut timeline = Timeline::new(log, settings.vehicle.yaw_rate_sigma_radps);
    let mut entries: Vec<Entry<'_, Underwater>> = Vec::new();
    for scan in log.scans.iter().take(scans) {
        entries.extend(timeline.steps_to(scan.t_s).into_iter().map(|step| Entry::Predict(step.navigation)));
        entries.push(Entry::Scan(Which::FIRST, &scan.detections));
    }
    let header = Header {
        models: models(log, settings)?,
        joint: Joint::of(&joint_config::<f64>(), &HypothesesConfig::default()),
        scan_interval_s: scan_interval_s(log.scans.iter().map(|scan| scan.t_s)),
        ..head(&settings.filter, seed, scalar)
    };
    Ok(Stream::of(header, &entries))
}
