//! A run over an underwater log as CSV tables.

use super::record::Record;
use crate::output::OutputError;
use crate::output::csv::write_rows;
use crate::score::ospa::Ospa;
use std::path::{Path, PathBuf};

/// Columns of `scans.csv`.
const SCANS: [&str; 41] = [
    "t_s",
    "x_m",
    "y_m",
    "z_m",
    "yaw_rad",
    "yaw_rate_radps",
    "cov_x_x_m2",
    "cov_x_y_m2",
    "cov_x_z_m2",
    "cov_x_yaw_m_rad",
    "cov_x_yaw_rate_m_radps",
    "cov_y_y_m2",
    "cov_y_z_m2",
    "cov_y_yaw_m_rad",
    "cov_y_yaw_rate_m_radps",
    "cov_z_z_m2",
    "cov_z_yaw_m_rad",
    "cov_z_yaw_rate_m_radps",
    "cov_yaw_yaw_rad2",
    "cov_yaw_yaw_rate_rad_radps",
    "cov_yaw_rate_yaw_rate_rad2ps2",
    "dead_reckoning_x_m",
    "dead_reckoning_y_m",
    "dead_reckoning_z_m",
    "true_x_m",
    "true_y_m",
    "true_z_m",
    "true_yaw_rad",
    "measurements",
    "features_estimated",
    "n_eff",
    "in_view",
    "no_birth",
    "pages_used",
    "scan_us",
    "ospa_c1_m",
    "ospa_c1_localization_m",
    "ospa_c1_cardinality_m",
    "ospa_c10_m",
    "ospa_c10_localization_m",
    "ospa_c10_cardinality_m",
];

/// Columns of `map.csv`.
const MAP: [&str; 11] = [
    "id",
    "weight",
    "x_m",
    "y_m",
    "z_m",
    "cov_x_x_m2",
    "cov_x_y_m2",
    "cov_x_z_m2",
    "cov_y_y_m2",
    "cov_y_z_m2",
    "cov_z_z_m2",
];

/// Writes `scans.csv` and `map.csv` into the existing folder `dir`, each all or nothing.
///
/// # Errors
/// A file cannot be written.
pub fn write_record(dir: &Path, record: &Record) -> Result<[PathBuf; 2], OutputError> {
    let scans = record.frames.iter().map(|frame| {
        let truth = frame.true_position.map_or([None; 3], |position| position.map(Some));
        let mut row = vec![Some(frame.t_s)];
        row.extend(frame.pose.map(Some));
        // The upper triangle, row by row.
        row.extend((0..5).flat_map(|i| (i..5).map(move |k| Some(frame.pose_covariance[i][k]))));
        row.extend(frame.dead_reckoning.map(Some));
        row.extend(truth);
        row.push(frame.true_yaw_rad);
        row.extend([
            Some(frame.measurements as f64),
            Some(frame.features_estimated),
            Some(frame.n_eff),
            Some(frame.in_view as f64),
            Some(frame.no_birth as f64),
            frame.pages_used.map(|pages| pages as f64),
            Some(frame.scan_us),
        ]);
        let parts = |ospa: Ospa| [ospa.distance, ospa.localization, ospa.cardinality].map(Some);
        for ospa in [frame.map_error.map(|error| error.near), frame.map_error.map(|error| error.far)] {
            row.extend(ospa.map_or([None; 3], parts));
        }
        row
    });
    let map = record.map.iter().map(|feature| {
        let c = &feature.covariance;
        let [x, y, z] = feature.mean;
        let numbers =
            [f64::from(feature.id), feature.weight, x, y, z, c[0][0], c[0][1], c[0][2], c[1][1], c[1][2], c[2][2]];
        numbers.map(Some).to_vec()
    });
    let paths = [dir.join("scans.csv"), dir.join("map.csv")];
    write_rows(&paths[0], &SCANS, scans)?;
    write_rows(&paths[1], &MAP, map)?;
    Ok(paths)
}
