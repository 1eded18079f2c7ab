//! Errors of a folder, with their places.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why a folder cannot be read; displays as one line.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {problem}")]
pub struct LogError {
    /// The place.
    pub place: Place,
    /// The error.
    pub problem: Problem,
}

/// A place in a folder. Rows are lines of the file; the header is row 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// The folder itself.
    Folder(PathBuf),
    /// A whole file.
    File(&'static str),
    /// A row of a file.
    Row(&'static str, u64),
    /// A column of a file.
    Column(&'static str, &'static str),
    /// A column of a row of a file.
    Cell(&'static str, u64, &'static str),
    /// A key of `log.toml`, after the name of its section.
    Key(String),
}

impl Place {
    /// An error at this place.
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

/// An error.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// A folder, file, column or key is missing.
    #[error("missing")]
    Missing,
    /// A file, or a table that needs rows, is empty.
    #[error("empty")]
    Empty,
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    /// The file is not UTF-8.
    #[error("not UTF-8 text")]
    NotText,
    /// `log.toml` is not TOML, or a table is not CSV.
    #[error("{}", Excerpt(.0))]
    Syntax(String),
    /// The header names a column twice.
    #[error("named twice in the header")]
    Twice,
    /// A row has more or fewer fields than the header.
    #[error(
        "wrong number of fields: {found}, the header has {expected}{}",
        if found > expected { ": commas in numbers?" } else { "" }
    )]
    Fields {
        /// Number of fields in this row.
        found: u64,
        /// Number of fields in the header.
        expected: u64,
    },
    /// Not a number, or infinite or NaN.
    #[error("not a finite number: '{}'", Excerpt(.0))]
    NotFinite(String),
    /// A finite number beyond the range of single precision, which filters use.
    #[error("{0:e}, expected a number of single precision, in which filters count: at most 3.4e38")]
    TooLarge(f64),
    /// Not a whole number.
    #[error("not a whole number: '{}'", Excerpt(.0))]
    NotWhole(String),
    /// A key has a value of another type.
    #[error("not {expected} but {}", Excerpt(.found))]
    Type {
        /// Its value.
        found: String,
        /// The required type.
        expected: &'static str,
    },
    /// A number out of range.
    #[error("{found}, expected {expected}")]
    Limits {
        /// The number.
        found: f64,
        /// Its range.
        expected: &'static str,
    },
    /// A model that is unknown or not supported.
    #[error("'{}' is not supported yet, only {supported}", Excerpt(.found))]
    Unsupported {
        /// The model.
        found: String,
        /// The models that are supported.
        supported: &'static str,
    },
    /// A key that does not exist in the section, for example a spelling error.
    #[error("unknown, there are {}", .known.join(", "))]
    Unknown {
        /// The keys of the section.
        known: &'static [&'static str],
    },
    /// A key of another model of the section, which would have no effect.
    #[error("not a key of the model {model}, which has {}", .known.join(", "))]
    Unused {
        /// The model.
        model: &'static str,
        /// The keys of the section for it.
        known: &'static [&'static str],
    },
    /// A key that is used only when a folder is read with its detections.
    #[error("detections are left out when a folder is read: write the key into its log.toml")]
    OfFolders,
    /// A `kind` that is neither real nor simulated.
    #[error("'{}' says neither real nor simulated: say simulated = true or simulated = false", Excerpt(.0))]
    Kind(String),
    /// A name that is not suitable for a line, file or plot.
    #[error("a name has 1 to {NAME_CHARS} characters, none of them a control character")]
    Name,
    /// A matrix of a camera that is not a rotation.
    #[error("not a rotation: its rows have to be right-angled, of length 1, right-handed")]
    NoRotation,
    /// A time (s) that is earlier than the row before.
    #[error("time goes backwards from {before} to {after}")]
    Backwards {
        /// Time of the row before, s.
        before: f64,
        /// Time of this row, s.
        after: f64,
    },
    /// A scan number that is out of order.
    #[error("scan {found} out of order, expected {least} or more")]
    ScanOrder {
        /// The number.
        found: i64,
        /// The least valid number: one more than the number before if there is one.
        least: i128,
    },
    /// Intervals of rows that are too long for times in seconds, s.
    #[error(
        "rows are {} s apart in the median, expected at most {most_s} s: times are in seconds, these look like {unit}",
        rounded(*.median_s)
    )]
    FarApart {
        /// The median interval, s.
        median_s: f64,
        /// Its greatest value, s.
        most_s: f64,
        /// The unit in which it would be plausible.
        unit: &'static str,
    },
    /// Angles that are not in radians.
    #[error(
        "{found}, expected -{most:.4} to {most:.4}: angles are in radians, {}",
        if *degrees { "these look like degrees" } else { "take whole turns off, unless these are degrees" }
    )]
    NotRadians {
        /// The first of them.
        found: f64,
        /// The greatest valid one.
        most: f64,
        /// Whether they are so large that they can only be in degrees.
        degrees: bool,
    },
    /// Most ranges are far beyond the stated range of the sensor.
    #[error(
        "{} m in the median, twice the sensor's greatest range is {most_m} m: ranges are in metres",
        rounded(*.median_m)
    )]
    OutOfReach {
        /// The median of the ranges, m.
        median_m: f64,
        /// Twice the sensor's greatest range, m.
        most_m: f64,
    },
    /// The vehicle drives so far between scans that no two scans can show the same landmarks.
    #[error(
        "the vehicle drives {} m from scan to scan in the median, so that no two scans show the same (twice the \
         sensor's range is {most_m} m): speeds are in metres a second, times in seconds",
        rounded(*.median_m)
    )]
    DrivesTooFar {
        /// The median distance between scans, m.
        median_m: f64,
        /// Twice the sensor's greatest range, m.
        most_m: f64,
    },
    /// The log has no odometry.
    #[error("no odometry")]
    NoOdometry,
    /// All odometry is after the last scan.
    #[error("the odometry begins at {first_s} s, after the last scan at {last_scan_s} s")]
    LateOdometry {
        /// Time of the first row, s.
        first_s: f64,
        /// Time of the last scan, s.
        last_scan_s: f64,
    },
    /// Most scans are outside the time of the odometry.
    #[error(
        "a scan at {scan_s} s, and most scans are not between the first row of odometry at {} s and the last at {} s: \
         both need the same clock, in seconds",
        .odometry_s[0], .odometry_s[1]
    )]
    OtherClock {
        /// Time of a scan, s.
        scan_s: f64,
        /// Times of the first and the last row of odometry, s.
        odometry_s: [f64; 2],
    },
    /// A detection of a scan that `scans.csv` does not list.
    #[error("scan {0} is not in scans.csv")]
    NoSuchScan(i64),
    /// A negative range (m) in a log that is not simulated.
    #[error("negative range {0} in a log that is not simulated")]
    NegativeRange(f64),
    /// The log has no scans.
    #[error("no scans")]
    NoScans,
    /// `[sensor]` together with `[[sensors]]`.
    #[error("either one [sensor] or several [[sensors]]")]
    SensorAndSensors,
    /// A sensor's name that cannot be used in settings.
    #[error("a sensor's name has 1 to {SENSOR_NAME_CHARS} letters, digits, dashes and underscores")]
    SensorName,
    /// Two sensors have the same name.
    #[error("'{0}' is the name of two sensors")]
    SensorTwice(String),
    /// A scan of a sensor that `log.toml` does not have.
    #[error("no sensor '{}', log.toml has {}", Excerpt(.found), .known.join(", "))]
    NoSuchSensor {
        /// Its name.
        found: String,
        /// The names in `log.toml`.
        known: Vec<String>,
    },
    /// `fixes.csv` without `[fixes]`, which has their noise.
    #[error("missing: it says how good the fixes of fixes.csv are")]
    NoFixNoise,
    /// A row without any fix.
    #[error("no fix: neither x_m and y_m nor heading_rad")]
    EmptyFix,
    /// A fix before the first row of odometry.
    #[error("a fix at {t_s} s, before the odometry, which begins at {first_s} s")]
    EarlyFix {
        /// Its time, s.
        t_s: f64,
        /// Time of the first row of odometry, s.
        first_s: f64,
    },
    /// All fixes are after the last scan.
    #[error(
        "the first fix is at {first_s} s, after the last scan at {last_scan_s} s: both need the same clock, in seconds"
    )]
    LateFixes {
        /// Time of the first fix, s.
        first_s: f64,
        /// Time of the last scan, s.
        last_scan_s: f64,
    },
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

/// Greatest number of characters of a name.
pub(super) const NAME_CHARS: usize = 200;
/// Greatest number of characters of a sensor's name.
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
