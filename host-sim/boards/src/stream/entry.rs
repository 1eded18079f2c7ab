//! Records and header of a stream, for any vehicle.

use scphd::Config;
use scphd_stream::{Header, Kind, Scalar, Which, Writer};
use scphd_vehicle::{Description, Filter};
use std::convert::Infallible;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stream {
    pub bytes: Vec<u8>,
    pub predictions: u32,
    pub scans: u32,
    /// Greatest number of measurements in a scan.
    pub most_measurements: u32,
}

/// A record to be written.
pub(super) enum Entry<'a, K: Kind> {
    Predict(K::Input),
    /// A measurement of the pose.
    Fix(K::Fix),
    Scan(Which<K>, &'a [K::Measurement]),
}

impl Stream {
    /// The stream with this header, whose counts are set here, and these records.
    pub(super) fn of<K: Kind>(mut header: Header<K>, entries: &[Entry<'_, K>]) -> Self {
        let scans = || {
            entries.iter().filter_map(|entry| match entry {
                Entry::Scan(_, measurements) => Some(measurements.len()),
                _ => None,
            })
        };
        header.scans = count(scans().count());
        header.predictions = count(entries.iter().filter(|entry| matches!(entry, Entry::Predict(_))).count());
        header.most_measurements = count(scans().max().unwrap_or(0));
        let mut bytes = Vec::new();
        let Ok(()) = fill(&header, entries, &mut bytes);
        let Header { predictions, scans, most_measurements, .. } = header;
        Self { bytes, predictions, scans, most_measurements }
    }
}

/// Writing to memory cannot fail.
fn fill<K: Kind>(header: &Header<K>, entries: &[Entry<'_, K>], bytes: &mut Vec<u8>) -> Result<(), Infallible> {
    let mut writer = Writer::start(header, |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        Ok(())
    })?;
    for entry in entries {
        match entry {
            Entry::Predict(input) => writer.predict(input)?,
            Entry::Fix(fix) => writer.fix(fix)?,
            Entry::Scan(which, measurements) => writer.scan_of(*which, measurements)?,
        }
    }
    writer.end()
}

/// The counts of all practical logs are in range.
fn count(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(scphd_stream::UNKNOWN)
}

/// The median interval of scans, s; 0 for less than two scans.
pub(super) fn scan_interval_s(times_s: impl Iterator<Item = f64>) -> f64 {
    let times_s: Vec<f64> = times_s.collect();
    let mut intervals: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    intervals.sort_by(f64::total_cmp);
    intervals.get(intervals.len() / 2).copied().unwrap_or(0.0)
}

/// The description for a filter that computes in this number type, whose precision decides what is negligible.
pub(super) fn in_precision(mut description: Description<f64>, scalar: Scalar) -> Description<f64> {
    if let Filter::Mixture(config) = &mut description.filter {
        config.negligible = match scalar {
            Scalar::F32 => f64::from(Config::<f32>::default().negligible),
            Scalar::F64 => Config::<f64>::default().negligible,
        };
    }
    description
}
