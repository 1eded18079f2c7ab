//! Errors of plots.

use std::io;
use std::path::PathBuf;

/// Why a plot could not be made.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    #[error("cannot write {}: {source}", path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("cannot render the picture: {0}")]
    Render(String),
}
