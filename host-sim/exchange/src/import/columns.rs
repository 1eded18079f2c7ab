//! Text tables of any kind, read by a file that assigns their columns; described in docs/logs.md.

use super::scans::{Seen, scans};
use super::text::{Delimiter, Row, Text, Writing};
use super::{Draft, ImportError, Imported};
use crate::calendar;
use scphd_log::log::{Fix, Log, Odometry, PoseFix, TruePose};
use serde::Deserialize;
use std::fs;
use std::path::Path;

/// Contents of the file; paths are relative to its folder.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Map {
    name: Option<String>,
    odometry: Moves,
    detections: Sees,
    scans: Option<Times>,
    truth: Option<Places>,
    fixes: Option<Places>,
    landmarks: Option<Marks>,
}

/// Format of a table.
#[derive(Debug, Deserialize)]
struct Source {
    file: String,
    #[serde(default)]
    delimiter: Option<String>,
    #[serde(default = "yes")]
    header: bool,
}

fn yes() -> bool {
    true
}

#[derive(Debug, Deserialize)]
struct Moves {
    #[serde(flatten)]
    source: Source,
    time: Column,
    speed: Column,
    turn: Column,
}

#[derive(Debug, Deserialize)]
struct Sees {
    #[serde(flatten)]
    source: Source,
    time: Column,
    range: Option<Column>,
    bearing: Option<Column>,
    ahead: Option<Column>,
    left: Option<Column>,
    label: Option<Column>,
}

#[derive(Debug, Deserialize)]
struct Times {
    #[serde(flatten)]
    source: Source,
    time: Column,
}

#[derive(Debug, Deserialize)]
struct Places {
    #[serde(flatten)]
    source: Source,
    time: Column,
    x: Option<Column>,
    y: Option<Column>,
    heading: Option<Column>,
}

#[derive(Debug, Deserialize)]
struct Marks {
    #[serde(flatten)]
    source: Source,
    x: Column,
    y: Column,
}

/// A column, by its name or number, and its unit.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Column {
    Number(u64),
    Name(String),
    Scaled(Scaled),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Scaled {
    column: Box<Column>,
    unit: Option<String>,
    factor: Option<f64>,
    offset: Option<f64>,
}

/// Keys of each section, besides the common ones: serde does not report unknown keys of a section with a flattened source.
const KEYS: [(&str, &[&str]); 6] = [
    ("odometry", &["time", "speed", "turn"]),
    ("detections", &["time", "range", "bearing", "ahead", "left", "label"]),
    ("scans", &["time"]),
    ("truth", &["time", "x", "y", "heading"]),
    ("fixes", &["time", "x", "y", "heading"]),
    ("landmarks", &["x", "y"]),
];
const KEYS_OF_ALL: [&str; 3] = ["file", "delimiter", "header"];

/// Keys that no section has: spelling errors would otherwise be ignored.
fn known(text: &str) -> Vec<String> {
    let table: toml::Table = text.parse().unwrap_or_default();
    let mut strangers = Vec::new();
    for (section, keys) in KEYS {
        let inside = table.get(section).and_then(toml::Value::as_table);
        let known = |key: &&String| keys.contains(&key.as_str()) || KEYS_OF_ALL.contains(&key.as_str());
        for key in inside.into_iter().flat_map(toml::Table::keys).filter(|key| !known(key)) {
            let all = [keys, &KEYS_OF_ALL].concat().join(", ");
            strangers.push(format!("[{section}] has no key '{key}', but {all}"));
        }
    }
    strangers
}

/// Units, each with its size in metres, seconds or radians.
const UNITS: [(&str, f64); 13] = [
    ("s", 1.0),
    ("ms", 1e-3),
    ("us", 1e-6),
    ("ns", 1e-9),
    ("m", 1.0),
    ("cm", 1e-2),
    ("mm", 1e-3),
    ("rad", 1.0),
    ("deg", std::f64::consts::PI / 180.0),
    ("mps", 1.0),
    ("kmph", 1.0 / 3.6),
    ("radps", 1.0),
    ("degps", std::f64::consts::PI / 180.0),
];

/// A column that was found in a table.
struct Found {
    place: usize,
    factor: f64,
    offset: f64,
}

impl Column {
    fn find(&self, text: &Text) -> Result<Found, ImportError> {
        match self {
            Self::Number(number) => Ok(Found { place: text.column(&number.to_string())?, factor: 1.0, offset: 0.0 }),
            Self::Name(name) => Ok(Found { place: text.column(name)?, factor: 1.0, offset: 0.0 }),
            Self::Scaled(Scaled { column, unit, factor, offset }) => {
                let place = column.find(text)?.place;
                let unit = match unit {
                    None => 1.0,
                    Some(unit) => {
                        UNITS.iter().find(|(name, _)| name == unit).map(|(_, size)| *size).ok_or_else(|| {
                            let names = UNITS.map(|(name, _)| name).join(", ");
                            ImportError::at(format_args!("unit '{unit}'"), format_args!("unknown, there are {names}"))
                        })?
                    }
                };
                Ok(Found { place, factor: unit * factor.unwrap_or(1.0), offset: offset.unwrap_or(0.0) })
            }
        }
    }
}

impl Found {
    fn of(&self, row: &Row<'_>) -> Result<f64, ImportError> {
        let number = row.number(self.place)?;
        Ok(self.scaled(number))
    }

    fn if_any(&self, row: &Row<'_>) -> Result<Option<f64>, ImportError> {
        Ok(row.number_if_any(self.place)?.map(|number| self.scaled(number)))
    }

    fn scaled(&self, number: f64) -> f64 {
        // If the factor is 1/n, dividing by n gives the number nearest to the decimal.
        let parts = (1.0 / self.factor).round();
        let scaled = if self.factor < 1.0 && (self.factor * parts - 1.0).abs() < 1e-15 {
            number / parts
        } else {
            number * self.factor
        };
        scaled + self.offset
    }
}

impl Source {
    fn read(&self, folder: &Path) -> Result<Text, ImportError> {
        let path = folder.join(&self.file);
        let delimiter = match self.delimiter.as_deref() {
            None => Delimiter::Guessed,
            Some("space") => Delimiter::Space,
            Some("tab") => Delimiter::Byte(b'\t'),
            Some(text) => match text.as_bytes() {
                [byte] => Delimiter::Byte(*byte),
                _ => {
                    let place = format!("delimiter '{text}'");
                    return Err(ImportError::at(
                        place,
                        "a single character, or \"tab\", or \"space\" for any white space",
                    ));
                }
            },
        };
        Text::read(&path, Writing { delimiter, header: self.header })
    }
}

/// Reads the tables that `map` names. `head`, if given, describes vehicle and sensors. Detections with a range of
/// `range_below_m`, m, or more are left out.
///
/// # Errors
/// A file or column is missing, or a cell has no number: see [`ImportError`].
pub fn read(map: &Path, head: Option<Log>, range_below_m: Option<f64>) -> Result<Imported, ImportError> {
    let text = fs::read_to_string(map).map_err(|error| ImportError::io(map, error))?;
    let named = |error: toml::de::Error| {
        let what = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
        ImportError::at(map.display(), what)
    };
    let strangers = known(&text);
    // A key that is missing may be misspelt: report that first.
    let columns: Result<Map, _> = toml::from_str(&text);
    let columns = match (columns, &strangers[..]) {
        (Ok(columns), []) => columns,
        (Err(error), []) => return Err(named(error)),
        (Ok(_), _) => return Err(ImportError::at(map.display(), strangers.join("; "))),
        (Err(error), _) => {
            let what = format!("{}; {}", strangers.join("; "), error.message());
            return Err(ImportError::at(map.display(), what.split_whitespace().collect::<Vec<_>>().join(" ")));
        }
    };
    let folder = map.parent().unwrap_or(Path::new(""));
    let mut odometry = Vec::new();
    let table = columns.odometry.source.read(folder)?;
    let Moves { time, speed, turn, .. } = &columns.odometry;
    let (time, speed, turn) = (time.find(&table)?, speed.find(&table)?, turn.find(&table)?);
    let mut told = Vec::new();
    for row in table.rows() {
        let t_s = time.of(&row)?;
        if let Some(before) = odometry.last().map(|row: &Odometry| row.t_s).filter(|before| t_s < *before) {
            let (back_s, before) = (before - t_s, calendar::shown(before));
            let what = format!(
                "time goes back by {back_s:.3} s, from {before} to {}: rows of both times do not belong together",
                calendar::shown(t_s)
            );
            return Err(row.error(time.place, what));
        }
        odometry.push(Odometry { t_s, control: [speed.of(&row)?, turn.of(&row)?, 0.0] });
    }
    table.tell(&mut told);
    let seen = seen(&columns.detections, folder, &mut told)?;
    let mut empty = Vec::new();
    if let Some(Times { source, time }) = &columns.scans {
        let table = source.read(folder)?;
        let time = time.find(&table)?;
        empty = table.rows().map(|row| time.of(&row)).collect::<Result<Vec<f64>, _>>()?;
    }
    let mut truth: Vec<TruePose> = Vec::new();
    each(columns.truth.as_ref(), folder, "truth", &mut told, |t_s, place, heading_rad| {
        truth.extend(place.map(|position| TruePose { t_s, position, heading_rad }));
    })?;
    let mut fixes = Vec::new();
    each(columns.fixes.as_ref(), folder, "fixes", &mut told, |t_s, place, heading_rad| {
        let place = place.map(PoseFix::Position);
        fixes.extend(place.into_iter().chain(heading_rad.map(PoseFix::Heading)).map(|measured| Fix { t_s, measured }));
    })?;
    if !fixes.is_empty() && head.is_none() {
        return Err(ImportError::at(map.display(), "fixes need a --head that says under [fixes] how good they are"));
    }
    let mut landmarks = Vec::new();
    if let Some(Marks { source, x, y }) = &columns.landmarks {
        let table = source.read(folder)?;
        let (x, y) = (x.find(&table)?, y.find(&table)?);
        landmarks = table.rows().map(|row| Ok([x.of(&row)?, y.of(&row)?])).collect::<Result<Vec<_>, ImportError>>()?;
    }
    told.push(format!("{} rows of odometry, {} detections", odometry.len(), seen.len()));
    let initial_pose = truth.first().map(|row| [row.position[0], row.position[1], row.heading_rad.unwrap_or(0.0)]);
    let scans = scans(seen, &empty);
    let name = columns.name.unwrap_or_else(|| "log".to_owned());
    let sensors = vec![(String::new(), None)];
    let places = Draft { initial_pose, fixes, truth, landmarks, ..Draft::default() };
    Draft { name, head, sensors, odometry, scans, told, range_below_m, ..places }.finish()
}

fn seen(columns: &Sees, folder: &Path, told: &mut Vec<String>) -> Result<Vec<Seen>, ImportError> {
    let table = columns.source.read(folder)?;
    let time = columns.time.find(&table)?;
    let find = |column: &Option<Column>| column.as_ref().map(|column| column.find(&table)).transpose();
    let polar = find(&columns.range)?.zip(find(&columns.bearing)?);
    let level = find(&columns.ahead)?.zip(find(&columns.left)?);
    let label = find(&columns.label)?;
    let mut seen = Vec::new();
    for row in table.rows() {
        let detection = match (&polar, &level) {
            (Some((range, bearing)), None) => [range.of(&row)?, bearing.of(&row)?],
            (None, Some((ahead, left))) => {
                let (ahead, left) = (ahead.of(&row)?, left.of(&row)?);
                [libm::hypot(ahead, left), libm::atan2(left, ahead)]
            }
            _ => return Err(ImportError::at("[detections]", "either range and bearing or ahead and left")),
        };
        // Labels are whole numbers.
        let label = label.as_ref().map(|label| label.of(&row)).transpose()?.map(|label| label as i64);
        seen.push((time.of(&row)?, detection, label));
    }
    table.tell(told);
    Ok(seen)
}

/// Passes on every row of poses: time, position, and heading if known.
fn each(
    columns: Option<&Places>,
    folder: &Path,
    section: &str,
    told: &mut Vec<String>,
    mut show: impl FnMut(f64, Option<[f64; 2]>, Option<f64>),
) -> Result<(), ImportError> {
    let Some(Places { source, time, x, y, heading }) = columns else { return Ok(()) };
    let table = source.read(folder)?;
    let time = time.find(&table)?;
    let find = |column: &Option<Column>| column.as_ref().map(|column| column.find(&table)).transpose();
    let (x, y, heading) = (find(x)?, find(y)?, find(heading)?);
    if x.is_some() != y.is_some() || (x.is_none() && heading.is_none()) {
        return Err(ImportError::at(format_args!("[{section}]"), "x and y, or heading, or all three"));
    }
    let places = x.zip(y);
    for row in table.rows() {
        let place = match &places {
            Some((x, y)) => x.if_any(&row)?.zip(y.if_any(&row)?).map(|(x, y)| [x, y]),
            None => None,
        };
        let heading_rad = match &heading {
            Some(heading) => heading.if_any(&row)?,
            None => None,
        };
        show(time.of(&row)?, place, heading_rad);
    }
    table.tell(told);
    Ok(())
}
