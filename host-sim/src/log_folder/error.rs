//! What can be wrong with a folder, and where.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why a folder could not be read; displays as one line.
#[derive(Debug)]
pub struct LogError {
    /// Where.
    pub place: Place,
    /// What.
    pub problem: Problem,
}

/// A place in a folder. Rows are lines of the file, the header being row 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// The folder itself.
    Folder(PathBuf),
    /// A whole file.
    File(&'static str),
    /// A row of a file.
    Row(&'static str, u64),
    /// A column of a row of a file.
    Cell(&'static str, u64, &'static str),
    /// A key of `log.toml`, with the section's name in front.
    Key(String),
}

impl Place {
    /// An error at this place.
    pub(super) fn error(self, problem: Problem) -> LogError {
        LogError { place: self, problem }
    }
}

/// What is wrong.
#[derive(Debug)]
#[non_exhaustive]
pub enum Problem {
    /// A folder, file, column or key is not there.
    Missing,
    /// The file cannot be read.
    Unreadable(io::Error),
    /// The file is not UTF-8.
    NotText,
    /// `log.toml` is not TOML, or a table is not CSV.
    Syntax(String),
    /// The header names a column twice.
    Twice,
    /// A row has more or fewer fields than the header.
    Fields {
        /// Fields in this row.
        found: u64,
        /// Fields in the header.
        expected: u64,
    },
    /// Not a number, or infinite or NaN.
    NotFinite(String),
    /// Not a whole number.
    NotWhole(String),
    /// A key has a value of another type.
    Type {
        /// What it is.
        found: String,
        /// What it should be.
        expected: &'static str,
    },
    /// A number that makes no sense here.
    Limits {
        /// The number.
        found: f64,
        /// What is expected of it.
        expected: &'static str,
    },
    /// A model that is not known, or not supported yet.
    Unsupported {
        /// The model.
        found: String,
        /// The models that are supported.
        supported: &'static str,
    },
    /// A key that the section does not have: a slip of the pen would leave a number out unseen.
    Unknown {
        /// The keys of the section.
        known: &'static [&'static str],
    },
    /// A time (s) that is earlier than the row before.
    Backwards {
        /// Time of the row before, s.
        before: f64,
        /// Time of this row, s.
        after: f64,
    },
    /// A scan number that is out of order.
    ScanOrder {
        /// The number.
        found: i64,
        /// The least that may stand here.
        least: i64,
    },
    /// A detection of a scan that `scans.csv` does not list.
    NoSuchScan(i64),
    /// A negative range (m) in a log that is not simulated.
    NegativeRange(f64),
    /// The log has no scan at all.
    NoScans,
}

impl fmt::Display for LogError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.problem)
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Folder(path) => write!(f, "{}", path.display()),
            Self::File(file) => write!(f, "{file}"),
            Self::Row(file, row) => write!(f, "{file}, row {row}"),
            Self::Cell(file, row, column) => write!(f, "{file}, row {row}, column {column}"),
            Self::Key(key) => write!(f, "log.toml, key {key}"),
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing => write!(f, "missing"),
            Self::Unreadable(error) => write!(f, "cannot be read: {error}"),
            Self::NotText => write!(f, "not UTF-8 text"),
            Self::Syntax(what) => write!(f, "{what}"),
            Self::Twice => write!(f, "named twice in the header"),
            Self::Fields { found, expected } => {
                write!(f, "wrong number of fields: {found}, the header has {expected}")
            }
            Self::NotFinite(text) => write!(f, "not a finite number: '{text}'"),
            Self::NotWhole(text) => write!(f, "not a whole number: '{text}'"),
            Self::Type { found, expected } => write!(f, "not {expected} but {found}"),
            Self::Limits { found, expected } => write!(f, "{found}, expected {expected}"),
            Self::Unsupported { found, supported } => {
                write!(f, "'{found}' is not supported yet, only {supported}")
            }
            Self::Unknown { known } => write!(f, "unknown, there are {}", known.join(", ")),
            Self::Backwards { before, after } => {
                write!(f, "time goes backwards from {before} to {after}")
            }
            Self::ScanOrder { found, least } => {
                write!(f, "scan {found} out of order, expected {least} or more")
            }
            Self::NoSuchScan(scan) => write!(f, "scan {scan} is not in scans.csv"),
            Self::NegativeRange(range) => {
                write!(f, "negative range {range} in a log that is not simulated")
            }
            Self::NoScans => write!(f, "no scans"),
        }
    }
}

impl std::error::Error for LogError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &self.problem {
            Problem::Unreadable(error) => Some(error),
            _ => None,
        }
    }
}
