//! Number of detections: none at all, or more in a scan than filters have capacity for.

use super::finding::{Findings, Severity, short};
use scphd_filters::kind::Kind;
use scphd_filters::slam::MEASUREMENTS;

pub(super) fn look_over<K: Kind>(log: &K::Log, findings: &mut Findings) {
    let scans = K::scans(log);
    if scans.iter().all(|scan| scan.detections.is_empty()) {
        findings.warn(
            "no-detections",
            "detections.csv",
            format!("no detection in any of {} scans", scans.len()),
            "write the detections: without any the estimate is dead reckoning, and the map stays empty",
        );
    }
    let crowded = || scans.iter().enumerate().filter(|(_, scan)| scan.detections.len() > MEASUREMENTS);
    if let Some((index, scan)) = crowded().next() {
        findings.add(
            Severity::Error,
            "scan-crowded",
            "detections.csv",
            format!(
                "scan {index}, counted from 0, at {} s has {} detections; {} of {} scans have more than {MEASUREMENTS}, for which there is no room",
                short(scan.t_s),
                scan.detections.len(),
                crowded().count(),
                scans.len()
            ),
            "write one detection a landmark, not all points of a laser; of more than that leave out the weakest",
        );
    }
}
