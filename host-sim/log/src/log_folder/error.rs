//! Errors of a folder, with their places.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why a folder cannot be read; displays as one line.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {problem}")]
pub struct LogError {
    pub place: Place,
    pub problem: Problem,
}

/// A place in a folder. Rows are lines of the file; the header is row 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    Folder(PathBuf),
    File(&'static str),
    Row(&'static str, u64),
    Column(&'static str, &'static str),
    Cell(&'static str, u64, &'static str),
    /// A key of `log.toml`, after the name of its section.
    Key(String),
}

impl Place {
    pub(super) fn error(self, problem: Problem) -> LogError {
        LogError { place: self, problem }
    }
}

/// All errors, in the order in which they are found.
#[derive(Debug, Default)]
pub(super) struct Faults(pub(super) Vec<LogError>);

impl Faults {
    /// The value that was read; after an error `None`.
    pub(super) fn take<T>(&mut self, read: Result<T, LogError>) -> Option<T> {
        read.map_err(|error| self.0.push(error)).ok()
    }
}

#[derive(Debug, thiserror::Error)]
pub enum Problem {
    #[error("missing")]
    Missing,
    #[error("empty")]
    Empty,
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    #[error("not UTF-8 text")]
    NotText,
    /// `log.toml` is not TOML, or a table is not CSV.
    #[error("{}", Excerpt(.0))]
    Syntax(String),
    #[error("named twice in the header")]
    Twice,
    #[error(
        "wrong number of fields: {found}, the header has {expected}{}",
        if found > expected { ": commas in numbers?" } else { "" }
    )]
    Fields { found: u64, expected: u64 },
    #[error("not a finite number: '{}'", Excerpt(.0))]
    NotFinite(String),
    #[error("{0:e}, expected a number of single precision, in which filters count: at most 3.4e38")]
    TooLarge(f64),
    #[error("not a whole number: '{}'", Excerpt(.0))]
    NotWhole(String),
    #[error("not {expected} but {}", Excerpt(.found))]
    Type { found: String, expected: &'static str },
    #[error("{found}, expected {expected}")]
    Limits { found: f64, expected: &'static str },
    #[error("'{}' is not supported yet, only {supported}", Excerpt(.found))]
    Unsupported { found: String, supported: &'static str },
    #[error("unknown, there are {}", .known.join(", "))]
    Unknown { known: &'static [&'static str] },
    #[error("not a key of the model {model}, which has {}", .known.join(", "))]
    Unused { model: &'static str, known: &'static [&'static str] },
    #[error("detections are left out when a folder is read: write the key into its log.toml")]
    OfFolders,
    #[error("'{}' says neither real nor simulated: say simulated = true or simulated = false", Excerpt(.0))]
    Kind(String),
    #[error("a name has 1 to {NAME_CHARS} characters, none of them a control character")]
    Name,
    #[error("not a rotation: its rows have to be right-angled, of length 1, right-handed")]
    NoRotation,
    #[error("time goes backwards from {before} to {after}")]
    Backwards { before: f64, after: f64 },
    #[error("scan {found} out of order, expected {least} or more")]
    ScanOrder {
        found: i64,
        /// The least valid number: one more than the number before if there is one.
        least: i128,
    },
    #[error(
        "rows are {} s apart in the median, expected at most {most_s} s: times are in seconds, these look like {unit}",
        rounded(*.median_s)
    )]
    FarApart { median_s: f64, most_s: f64, unit: &'static str },
    #[error(
        "{found}, expected -{most:.4} to {most:.4}: angles are in radians, {}",
        if *degrees { "these look like degrees" } else { "take whole turns off, unless these are degrees" }
    )]
    NotRadians { found: f64, most: f64, degrees: bool },
    #[error(
        "{} m in the median, twice the sensor's greatest range is {most_m} m: ranges are in metres",
        rounded(*.median_m)
    )]
    OutOfReach { median_m: f64, most_m: f64 },
    /// The vehicle drives so far between scans that no two scans can show the same landmarks.
    #[error(
        "the vehicle drives {} m from scan to scan in the median, so that no two scans show the same (twice the \
         sensor's range is {most_m} m): speeds are in metres a second, times in seconds",
        rounded(*.median_m)
    )]
    DrivesTooFar { median_m: f64, most_m: f64 },
    #[error("no odometry")]
    NoOdometry,
    #[error("the odometry begins at {first_s} s, after the last scan at {last_scan_s} s")]
    LateOdometry { first_s: f64, last_scan_s: f64 },
    #[error(
        "a scan at {scan_s} s, and most scans are not between the first row of odometry at {} s and the last at {} s: \
         both need the same clock, in seconds",
        .odometry_s[0], .odometry_s[1]
    )]
    OtherClock { scan_s: f64, odometry_s: [f64; 2] },
    #[error("scan {0} is not in scans.csv")]
    NoSuchScan(i64),
    #[error("negative range {0} in a log that is not simulated")]
    NegativeRange(f64),
    #[error("no scans")]
    NoScans,
    #[error("either one [sensor] or several [[sensors]]")]
    SensorAndSensors,
    #[error("a sensor's name has 1 to {SENSOR_NAME_CHARS} letters, digits, dashes and underscores")]
    SensorName,
    #[error("'{0}' is the name of two sensors")]
    SensorTwice(String),
    #[error("no sensor '{}', log.toml has {}", Excerpt(.found), .known.join(", "))]
    NoSuchSensor { found: String, known: Vec<String> },
    #[error("missing: it says how good the fixes of fixes.csv are")]
    NoFixNoise,
    #[error("no fix: neither x_m and y_m nor heading_rad")]
    EmptyFix,
    #[error("a fix at {t_s} s, before the odometry, which begins at {first_s} s")]
    EarlyFix { t_s: f64, first_s: f64 },
    #[error(
        "the first fix is at {first_s} s, after the last scan at {last_scan_s} s: both need the same clock, in seconds"
    )]
    LateFixes { first_s: f64, last_scan_s: f64 },
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Folder(path) => write!(f, "{}", path.display()),
            Self::File(file) => write!(f, "{file}"),
            Self::Row(file, row) => write!(f, "{file}, row {row}"),
            Self::Column(file, column) => write!(f, "{file}, column {column}"),
            Self::Cell(file, row, column) => write!(f, "{file}, row {row}, column {column}"),
            Self::Key(key) => write!(f, "log.toml, key {}", Excerpt(key)),
        }
    }
}

pub(super) const NAME_CHARS: usize = 200;
pub(super) const SENSOR_NAME_CHARS: usize = 32;
/// Greatest number of characters of a file's text in a message.
const EXCERPT_CHARS: usize = 120;

/// A measured number with four significant digits.
fn rounded(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}

/// An excerpt of a file's text in one line, printable on any terminal.
struct Excerpt<'a>(&'a str);

impl fmt::Display for Excerpt<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, character) in self.0.chars().enumerate() {
            if place == EXCERPT_CHARS {
                return write!(f, " …");
            }
            if character.is_control() {
                write!(f, "{}", character.escape_default())?
            } else {
                write!(f, "{character}")?
            }
        }
        Ok(())
    }
}
