//! Streams of underwater vehicles.

use super::Recorded;
use super::entry::{Entry, Stream, in_precision, scan_interval_s};
use scphd_filters::describe::under_water;
use scphd_filters::slam::contract::Refusal;
use scphd_filters::underwater::models::models;
use scphd_filters::underwater::settings::Settings;
use scphd_filters::underwater::timeline::Timeline;
use scphd_log::underwater::Log;
use scphd_stream::underwater::Underwater;
use scphd_stream::{Header, Scalar, Which};

/// The first `scans` frames of `log` with all readings of the instruments before them; the parameters of the filter are in the
/// header.
pub fn write(
    log: &Log,
    settings: &Settings,
    filter: Recorded,
    seed: u64,
    scalar: Scalar,
    scans: usize,
) -> Result<Stream, Refusal> {
    let mut timeline = Timeline::new(log, settings.vehicle.yaw_rate_sigma_radps);
    let mut entries: Vec<Entry<'_, Underwater>> = Vec::new();
    for scan in log.scans.iter().take(scans) {
        entries.extend(timeline.steps_to(scan.t_s).into_iter().map(|step| Entry::Predict(step.navigation)));
        entries.push(Entry::Scan(Which::FIRST, &scan.detections));
    }
    let description = under_water(&settings.filter, filter == Recorded::Joint, seed);
    let header = Header {
        scan_interval_s: scan_interval_s(log.scans.iter().map(|scan| scan.t_s)),
        ..Header::with(&in_precision(description, scalar), models(log, settings)?, scalar)
    };
    Ok(Stream::of(header, &entries))
}
