//! Detections of text files as scans.

use scphd_log::log::Scan;

/// A detection: its time, s, range (m) and bearing (rad), and the label of its landmark, if known.
pub(super) type Seen = (f64, [f64; 2], Option<i64>);

/// Scans of detections in order of time; detections of one time are a scan. `empty` are the times, s, of scans that may have
/// none.
pub(super) fn scans(mut seen: Vec<Seen>, empty: &[f64]) -> Vec<Scan> {
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut scans: Vec<Scan> = Vec::new();
    for (t_s, detection, label) in seen {
        if scans.last().is_none_or(|scan| scan.t_s != t_s) {
            scans.push(Scan { t_s, ..Scan::default() });
        }
        if let Some(scan) = scans.last_mut() {
            scan.detections.push(detection);
            scan.labels.extend(label);
        }
    }
    let known: Vec<f64> = scans.iter().map(|scan| scan.t_s).collect();
    let missing = empty.iter().filter(|t_s| known.binary_search_by(|known| known.total_cmp(t_s)).is_err());
    scans.extend(missing.map(|&t_s| Scan { t_s, ..Scan::default() }));
    scans.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    scans
}
