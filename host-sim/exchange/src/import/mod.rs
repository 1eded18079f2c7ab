//! Files of others as logs.
//!
//! | file or folder | |
//! |---|---|
//! | `draft.rs`, `clean.rs` | what is read, what of it is no detection, and the log that it makes |
//! | `recording/` | MCAP files with messages of ROS 2 |
//! | `text.rs`, `scans.rs` | tables in text files, and detections of them |
//! | `columns.rs` | tables of any kind, by a map of their columns |
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

/// A log that was read, and what has to be told of how it was read: choices, guesses, what was left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The log.
    pub log: Log,
    /// A sentence each.
    pub told: Vec<String>,
}

/// Why there is no log.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// A file cannot be read.
    #[error("{path}: {error}", path = .0.display(), error = .1)]
    Io(PathBuf, io::Error),
    /// A `log.toml` that says what the files do not.
    #[error("{0}: {1}")]
    Head(String, LogError),
    /// Something in a file, or missing there.
    #[error("{place}: {what}")]
    At {
        /// The file, and where in it.
        place: String,
        /// What is wrong.
        what: String,
    },
}

impl ImportError {
    fn at(place: impl Display, what: impl Display) -> Self {
        Self::At { place: place.to_string(), what: what.to_string() }
    }

    fn io(path: &Path, error: io::Error) -> Self {
        Self::Io(path.to_path_buf(), error)
    }
}
