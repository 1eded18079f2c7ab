//! Pictures of a run as SVG and PNG.
//!
//! A [`Figure`] is a column of [`Chart`]s, a chart is a pair of axes with [`Mark`]s. [`write_plots`] makes the usual
//! two pictures of a log and its runs; other figures are built from the same parts:
//!
//! ```
//! use scphd_sim::plot::{Chart, Colour, Figure, Mark};
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
pub mod errors;
pub mod figure;
mod polyline;
mod raster;
pub mod study;
pub mod trajectory;

pub use axis::Interval;
pub use chart::{Chart, Colour, Gaussian, Mark, Shape};
pub use figure::Figure;

use crate::log::Log;
use crate::record::Record;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Why a picture could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// The file system refused.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// The file or folder that was to be written.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The SVG could not be turned into a PNG.
    #[error("cannot render the picture: {0}")]
    Render(String),
}

/// Writes `trajectory.svg`, `trajectory.png`, `error.svg` and `error.png` into `dir`, which is created where it is
/// missing, and returns their paths.
///
/// Every run has a label for the legend: `[("filter f32", &record)]`. Each file is written whole or not at all.
///
/// # Errors
///
/// [`PlotError`] where a file cannot be written or a picture cannot be rendered.
pub fn write_plots(dir: &Path, log: &Log, runs: &[(&str, &Record)]) -> Result<Vec<PathBuf>, PlotError> {
    fs::create_dir_all(dir).map_err(|source| PlotError::Io { path: dir.into(), source })?;
    let mut paths = Vec::new();
    paths.extend(trajectory::figure(log, runs).write(dir, "trajectory")?);
    paths.extend(errors::figure(log, runs).write(dir, "error")?);
    Ok(paths)
}

#[cfg(test)]
mod tests;
