//! Results on disk: writing of files, and the figures of a run as JSON.

pub mod json;
pub mod sink;

use std::io;
use std::path::PathBuf;

/// Why an output file could not be written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    #[error("cannot write {}: {source}", path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("cannot put a row of {}: {source}", path.display())]
    Csv { path: PathBuf, source: ::csv::Error },
    #[error("cannot put {} as JSON: {source}", path.display())]
    Json { path: PathBuf, source: serde_json::Error },
}
