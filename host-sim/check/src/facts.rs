//! The figures that a check measures, independent of its findings.

use super::finding::{Motion, quantile};
use scphd_filters::kind::Kind;
use scphd_log::truth;
use serde::Serialize;

/// The figures of a log; `None` if the log has no data for them.
/// `docs/results.md` defines the keys.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Facts {
    pub scans: usize,
    pub duration_s: f64,
    pub scan_interval_s: Option<f64>,
    pub detections: usize,
    pub empty_scans: usize,
    pub detections_out_of_view: Option<f64>,
    pub odometry_rows: usize,
    pub odometry_interval_s: Option<f64>,
    pub odometry_gap_s: Option<f64>,
    pub way_m: Option<f64>,
    pub scans_with_truth: usize,
    pub dead_reckoning_rmse_m: Option<f64>,
}

impl Facts {
    pub(super) fn of<K: Kind>(log: &K::Log, motion: &[Motion]) -> Self {
        let scans = K::scans(log);
        let between = |times: Vec<f64>| times.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>();
        let of_scans = between(scans.iter().map(|scan| scan.t_s).collect());
        let of_rows = between(motion.iter().map(|row| row.t_s).collect());
        Self {
            scans: scans.len(),
            duration_s: of_scans.iter().sum(),
            scan_interval_s: quantile(of_scans, 0.5),
            detections: scans.iter().map(|scan| scan.detections.len()).sum(),
            empty_scans: scans.iter().filter(|scan| scan.detections.is_empty()).count(),
            detections_out_of_view: None,
            odometry_rows: motion.len(),
            odometry_interval_s: quantile(of_rows.clone(), 0.5),
            odometry_gap_s: of_rows.into_iter().reduce(f64::max),
            way_m: None,
            scans_with_truth: scans.iter().filter(|scan| truth::at(K::truth(log), scan.t_s).is_some()).count(),
            dead_reckoning_rmse_m: None,
        }
    }
}
