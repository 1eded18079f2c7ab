//! Errors of plots.

use std::io;
use std::path::PathBuf;

/// Why a plot could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// The file system refuses.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// The file or folder to be written.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// The SVG cannot be rendered as PNG.
    #[error("cannot render the picture: {0}")]
    Render(String),
}
