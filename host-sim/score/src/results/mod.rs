//! Results on disk: writing of files, and the figures of a run as JSON.

pub mod json;
pub mod sink;

use std::io;
use std::path::PathBuf;

/// Why an output file could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The file system refuses.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// The file to be written.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// A row cannot be converted to CSV.
    #[error("cannot put a row of {}: {source}", path.display())]
    Csv {
        /// The file to be written.
        path: PathBuf,
        /// The error of the CSV writer.
        source: ::csv::Error,
    },
    /// A summary cannot be converted to JSON.
    #[error("cannot put {} as JSON: {source}", path.display())]
    Json {
        /// The file to be written.
        path: PathBuf,
        /// The error of the serialiser.
        source: serde_json::Error,
    },
}
