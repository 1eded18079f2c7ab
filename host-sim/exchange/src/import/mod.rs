//! Import of other formats as logs.
//!
//! | file or folder | |
//! |---|---|
//! | `draft.rs`, `clean.rs` | the data read, removal of invalid detections, and the log made of them |
//! | `recording/` | MCAP files with messages of ROS 2 |
//! | `text.rs`, `scans.rs` | tables in text files, and their detections |
//! | `columns.rs` | tables of any kind, by an assignment of their columns |
//! | `mrclam.rs` | the original files of MRCLAM |
//! | `matlab.rs`, `victoria_park.rs` | the original files of Victoria Park |

mod clean;
pub mod columns;
mod draft;
mod matlab;
pub mod mrclam;
pub mod recording;
mod scans;
mod text;
pub mod victoria_park;

pub use draft::Draft;

use scphd_log::log::Log;
use scphd_log::log_folder::LogError;
use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

/// An imported log, and messages about the import: choices, assumptions, data left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    pub log: Log,
    /// One sentence each.
    pub told: Vec<String>,
}

/// Why an import failed.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// A file cannot be read.
    #[error("{path}: {error}", path = .0.display(), error = .1)]
    Io(PathBuf, io::Error),
    /// Error in a `log.toml` that supplements the files.
    #[error("{0}: {1}")]
    Head(String, LogError),
    /// Error in a file, or missing data.
    #[error("{place}: {what}")]
    At { place: String, what: String },
}

impl ImportError {
    fn at(place: impl Display, what: impl Display) -> Self {
        Self::At { place: place.to_string(), what: what.to_string() }
    }

    fn io(path: &Path, error: io::Error) -> Self {
        Self::Io(path.to_path_buf(), error)
    }
}
