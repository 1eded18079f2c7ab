//! A run over an underwater log as CSV tables.

use super::record::Record;
use crate::output::OutputError;
use crate::output::csv::write_rows;
use std::path::{Path, PathBuf};

/// Columns of `scans.csv`.
const SCANS: [&str; 25] = [
    "t_s",
    "x_m",
    "y_m",
    "z_m",
    "yaw_rad",
    "yaw_rate_radps",
    "sigma_x_m",
    "sigma_y_m",
    "sigma_z_m",
    "sigma_yaw_rad",
    "sigma_yaw_rate_radps",
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
];

/// Columns of `map.csv`.
const MAP: [&str; 11] = ["id", "weight", "x_m", "y_m", "z_m", "xx_m2", "yx_m2", "yy_m2", "zx_m2", "zy_m2", "zz_m2"];

/// Writes `scans.csv` and `map.csv` into the existing folder `dir`, each all or nothing.
///
/// # Errors
/// A file cannot be written.
pub fn write_record(dir: &Path, record: &Record) -> Result<[PathBuf; 2], OutputError> {
    let scans = record.frames.iter().map(|frame| {
        let truth = frame.true_position.map_or([None; 3], |position| position.map(Some));
        let mut row = vec![Some(frame.t_s)];
        row.extend(frame.pose.iter().chain(&frame.sigmas).chain(&frame.dead_reckoning).copied().map(Some));
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
        row
    });
    let map = record.map.iter().map(|feature| {
        let c = &feature.covariance;
        let [x, y, z] = feature.mean;
        let numbers =
            [f64::from(feature.id), feature.weight, x, y, z, c[0][0], c[1][0], c[1][1], c[2][0], c[2][1], c[2][2]];
        numbers.map(Some).to_vec()
    });
    let paths = [dir.join("scans.csv"), dir.join("map.csv")];
    write_rows(&paths[0], &SCANS, scans)?;
    write_rows(&paths[1], &MAP, map)?;
    Ok(paths)
}
