//! Streams of planar vehicles.

use super::Recorded;
use super::entry::{Entry, Stream, in_precision, scan_interval_s};
use scphd_filters::describe::{description, mixture};
use scphd_filters::settings::Settings;
use scphd_filters::slam::contract::{Refusal, refusal};
use scphd_log::events::{Event, events};
use scphd_log::log::{FixNoise, Log, PoseFix};
use scphd_stream::planar::{Fix, Odometry, Planar};
use scphd_stream::{Header, Kind, Scalar, Which};

/// The first `scans` scans of `log` with all motion and fixes before them; the parameters of the filter are in the header.
pub fn write(
    log: &Log,
    settings: &Settings,
    filter: Recorded,
    seed: u64,
    scalar: Scalar,
    scans: usize,
) -> Result<Stream, Refusal> {
    let scans = scans.min(log.scans.len());
    let too_many = || refusal(format_args!("a stream has at most {} sensors", Planar::DETECTORS));
    let which = |sensor: usize| u8::try_from(sensor).ok().and_then(Which::number).ok_or_else(too_many);
    let description = match filter {
        Recorded::Mixture => mixture(log, settings, seed),
        Recorded::Joint => description(log, settings),
    };
    let mut taken = 0;
    let kept = events(log).take_while(|event| {
        let open = taken < scans;
        taken += usize::from(matches!(event, Event::Scan { .. }));
        open
    });
    let records = kept.map(|event| match event {
        Event::Predict { control, dt_s, .. } => Ok(Entry::Predict(Odometry { control, dt_s })),
        Event::Scan { index } => Ok(Entry::Scan(which(log.scans[index].sensor)?, &log.scans[index].detections)),
        Event::Fix { fix: measured } => Ok(Entry::Fix(fix(&settings.fixes.unwrap_or_default(), measured)?)),
    });
    let entries: Vec<Entry<'_, Planar>> = records.collect::<Result<_, Refusal>>()?;
    let header = Header {
        scan_interval_s: scan_interval_s(log.scans.iter().map(|scan| scan.t_s)),
        ..Header::of(&in_precision(description, scalar), scalar).map_err(refusal)?
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
