//! What a run leaves on disk and on the terminal: CSV rows, JSON summaries, tables.

pub mod comparison;
pub mod csv;
pub mod difference;
pub mod json;
pub mod repeats;
pub mod sink;
pub mod studies;
pub mod table;
pub mod tuning;

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
