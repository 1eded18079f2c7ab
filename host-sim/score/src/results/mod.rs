//! Results on disk: where they go, and the figures of a run as JSON.

pub mod json;
pub mod sink;

use std::io;
use std::path::PathBuf;

/// Why an output file could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The file system refused.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// The file that was to be written.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A row could not be put as CSV.
    #[error("cannot put a row of {}: {source}", path.display())]
    Csv {
        /// The file that was to be written.
        path: PathBuf,
        /// What the writer said.
        source: ::csv::Error,
    },
    /// A summary could not be put as JSON.
    #[error("cannot put {} as JSON: {source}", path.display())]
    Json {
        /// The file that was to be written.
        path: PathBuf,
        /// What the serializer said.
        source: serde_json::Error,
    },
}
