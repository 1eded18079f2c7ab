//! Plots of a run as SVG and PNG.
//!
//! A [`Figure`] is a column of [`Chart`]s, a chart is a pair of axes with [`Mark`]s. [`write_plots`] makes the usual two figures
//! of a log and its runs; other figures have the same parts:
//!
//! ```
//! use scphd_view::plot::{Chart, Colour, Figure, Mark};
//!
//! let mean: Vec<[f64; 2]> = (0..50).map(|i| [f64::from(i), f64::from(i).sqrt()]).collect();
//! let band = mean.iter().map(|&[x, y]| [x, y - 0.5, y + 0.5]).collect();
//! let chart = Chart {
//!     x_label: "particles".into(),
//!     y_label: "position RMSE (m)".into(),
//!     marks: vec![
//!         Mark::band("±1σ", Colour::of_curve(0), band),
//!         Mark::line("mean", Colour::of_curve(0), mean),
//!     ],
//!     ..Chart::default()
//! };
//! let figure = Figure { title: "Error over particles".into(), charts: vec![(chart, 400.0)] };
//! assert!(figure.svg().contains("±1σ"));
//! ```

pub mod axis;
pub mod chart;
mod draw;
mod error;
pub mod errors;
pub mod figure;
mod font;
mod polyline;
mod raster;
pub mod study;
pub mod trajectory;

pub use axis::Interval;
pub use chart::{Chart, Colour, Gaussian, Mark, Shape};
pub use error::PlotError;
pub use figure::Figure;

use scphd_filters::kind::Kind;
use scphd_score::record::Record;
use std::fs;
use std::path::{Path, PathBuf};

/// Writes `trajectory.svg`, `trajectory.png`, `error.svg` and `error.png` into `dir`, which is created if missing. Returns their
/// paths.
///
/// Every run has a label for the legend: `[("filter f32", &record)]`. Each file is complete or not written.
pub fn write_plots<K: Kind>(dir: &Path, log: &K::Log, runs: &[(&str, &Record<K>)]) -> Result<Vec<PathBuf>, PlotError> {
    fs::create_dir_all(dir).map_err(|source| PlotError::Io { path: dir.into(), source })?;
    let mut paths = Vec::new();
    paths.extend(trajectory::figure::<K>(log, runs).write(dir, "trajectory")?);
    paths.extend(errors::figure(K::name(log), runs).write(dir, "error")?);
    Ok(paths)
}

#[cfg(test)]
mod tests;
