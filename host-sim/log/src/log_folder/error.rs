//! What can be wrong with a folder, and where.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why a folder could not be read; displays as one line.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {problem}")]
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
    /// A column of a file.
    Column(&'static str, &'static str),
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

/// Everything that is found wrong, in the order in which it is found.
#[derive(Debug, Default)]
pub(super) struct Faults(pub(super) Vec<LogError>);

impl Faults {
    /// What was read; `None` where it could not be.
    pub(super) fn take<T>(&mut self, read: Result<T, LogError>) -> Option<T> {
        read.map_err(|error| self.0.push(error)).ok()
    }
}

/// What is wrong.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// A folder, file, column or key is not there.
    #[error("missing")]
    Missing,
    /// A file, or a table that needs rows, has nothing in it.
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
        /// Fields in this row.
        found: u64,
        /// Fields in the header.
        expected: u64,
    },
    /// Not a number, or infinite or NaN.
    #[error("not a finite number: '{}'", Excerpt(.0))]
    NotFinite(String),
    /// A number (finite) that single precision, in which filters count, does not hold.
    #[error("{0:e}, expected a number of single precision, in which filters count: at most 3.4e38")]
    TooLarge(f64),
    /// Not a whole number.
    #[error("not a whole number: '{}'", Excerpt(.0))]
    NotWhole(String),
    /// A key has a value of another type.
    #[error("not {expected} but {}", Excerpt(.found))]
    Type {
        /// What it is.
        found: String,
        /// What it should be.
        expected: &'static str,
    },
    /// A number that makes no sense here.
    #[error("{found}, expected {expected}")]
    Limits {
        /// The number.
        found: f64,
        /// What is expected of it.
        expected: &'static str,
    },
    /// A model that is not known, or not supported yet.
    #[error("'{}' is not supported yet, only {supported}", Excerpt(.found))]
    Unsupported {
        /// The model.
        found: String,
        /// The models that are supported.
        supported: &'static str,
    },
    /// A key that the section does not have: a slip of the pen would leave a number out unseen.
    #[error("unknown, there are {}", .known.join(", "))]
    Unknown {
        /// The keys of the section.
        known: &'static [&'static str],
    },
    /// A key that another model of the section has, and that decides nothing here.
    #[error("not a key of the model {model}, which has {}", .known.join(", "))]
    Unused {
        /// The model.
        model: &'static str,
        /// The keys of the section for it.
        known: &'static [&'static str],
    },
    /// A key that only a folder, with its detections, has a use for.
    #[error("detections are left out when a folder is read: write the key into its log.toml")]
    OfFolders,
    /// A `kind` that says neither real nor simulated.
    #[error("'{}' says neither real nor simulated: say simulated = true or simulated = false", Excerpt(.0))]
    Kind(String),
    /// A name that no line, file or drawing can hold.
    #[error("a name has 1 to {NAME_CHARS} characters, none of them a control character")]
    Name,
    /// A camera's rotation that is none.
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
        /// The least that may stand here: one more than any number for the number after the last there is.
        least: i128,
    },
    /// Rows that are too far apart, s, for a time in seconds.
    #[error(
        "rows are {} s apart in the median, expected at most {most_s} s: times are in seconds, these look like {unit}",
        rounded(*.median_s)
    )]
    FarApart {
        /// The median from row to row, s.
        median_s: f64,
        /// The most it may be, s.
        most_s: f64,
        /// In which unit it would be plausible.
        unit: &'static str,
    },
    /// Angles that are no angles in radians.
    #[error(
        "{found}, expected -{most:.4} to {most:.4}: angles are in radians, {}",
        if *degrees { "these look like degrees" } else { "take whole turns off, unless these are degrees" }
    )]
    NotRadians {
        /// The first of them.
        found: f64,
        /// The greatest there may be.
        most: f64,
        /// Whether they are so great that they can only be degrees.
        degrees: bool,
    },
    /// Most ranges are far beyond what the sensor is said to reach.
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
    /// No two scans can show the same.
    #[error(
        "the vehicle drives {} m from scan to scan in the median, so that no two scans show the same (twice the \
         sensor's range is {most_m} m): speeds are in metres a second, times in seconds",
        rounded(*.median_m)
    )]
    DrivesTooFar {
        /// The median of how far the vehicle drives from scan to scan, m.
        median_m: f64,
        /// Twice the sensor's greatest range, m.
        most_m: f64,
    },
    /// The log has no odometry at all.
    #[error("no odometry")]
    NoOdometry,
    /// All odometry comes after the last scan.
    #[error("the odometry begins at {first_s} s, after the last scan at {last_scan_s} s")]
    LateOdometry {
        /// Time of the first row, s.
        first_s: f64,
        /// Time of the last scan, s.
        last_scan_s: f64,
    },
    /// Most scans are not from the time of the odometry.
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
    /// The log has no scan at all.
    #[error("no scans")]
    NoScans,
    /// `[sensor]` beside `[[sensors]]`.
    #[error("either one [sensor] or several [[sensors]]")]
    SensorAndSensors,
    /// A sensor's name that settings cannot name.
    #[error("a sensor's name has 1 to {SENSOR_NAME_CHARS} letters, digits, dashes and underscores")]
    SensorName,
    /// A sensor's name that another has.
    #[error("'{0}' is the name of two sensors")]
    SensorTwice(String),
    /// A scan of a sensor that `log.toml` does not have.
    #[error("no sensor '{}', log.toml has {}", Excerpt(.found), .known.join(", "))]
    NoSuchSensor {
        /// Its name.
        found: String,
        /// Those that there are.
        known: Vec<String>,
    },
    /// `fixes.csv` without `[fixes]`, which says how good they are.
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
    /// All fixes come after the last scan.
    #[error(
        "the first fix is at {first_s} s, after the last scan at {last_scan_s} s: both need the same clock, in seconds"
    )]
    LateFixes {
        /// Time of the first, s.
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

/// Characters of a name, at most.
pub(super) const NAME_CHARS: usize = 200;
/// Characters of a sensor's name, at most.
pub(super) const SENSOR_NAME_CHARS: usize = 32;
/// Characters of a file's text that a message shows, at most.
const EXCERPT_CHARS: usize = 120;

/// A measured number with four digits that count.
fn rounded(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}

/// A piece of a file's text as part of one line that any terminal can show.
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
