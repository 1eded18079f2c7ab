//! The files as text: byte order marks, line ends, columns. A readable deviation is a note, an unreadable one an error.

use super::advice;
use super::finding::{Finding, Findings, Severity};
use scphd_log::log_folder::has_camera;
use std::fs;
use std::path::Path;
use toml::Table;

/// The tables of a folder, and whether they are required.
const TABLES: [(&str, bool); 7] = [
    ("odometry.csv", true),
    ("scans.csv", true),
    ("detections.csv", true),
    ("truth.csv", false),
    ("landmarks.csv", false),
    ("moving.csv", false),
    ("fixes.csv", false),
];

/// Suffixes of column names in other units, and how to convert to the unit of the column.
const UNITS: [(&str, &str); 14] = [
    ("_deg", "degrees: multiply by 0.0174533"),
    ("_degps", "degrees a second: multiply by 0.0174533"),
    ("_dps", "degrees a second: multiply by 0.0174533"),
    ("_ms", "milliseconds: divide by 1e3"),
    ("_us", "microseconds: divide by 1e6"),
    ("_ns", "nanoseconds: divide by 1e9"),
    ("_mm", "millimetres: divide by 1000"),
    ("_cm", "centimetres: divide by 100"),
    ("_km", "kilometres: multiply by 1000"),
    ("_ft", "feet: multiply by 0.3048"),
    ("_kmh", "kilometres an hour: divide by 3.6"),
    ("_kph", "kilometres an hour: divide by 3.6"),
    ("_mmps", "millimetres a second: divide by 1000"),
    ("_rpm", "turns a minute: multiply by 0.104720"),
];

pub(super) fn look_over(dir: &Path, findings: &mut Findings) {
    let head = fs::read(dir.join("log.toml")).ok();
    let head = head.and_then(|bytes| written("log.toml", &bytes, findings));
    let head: Option<Table> = head.and_then(|text| text.parse().ok());
    for (file, needed) in TABLES {
        match fs::read(dir.join(file)) {
            Ok(bytes) => {
                if let Some(text) = written(file, &bytes, findings) {
                    columns(file, &text, &wanted(dir, file, head.as_ref()), findings);
                }
            }
            Err(_) if needed && dir.is_dir() => findings.add(
                Severity::Error,
                "file-missing",
                file,
                "missing".to_owned(),
                "a log needs log.toml, odometry.csv, scans.csv and detections.csv; scphd-sim export survey DIR writes one to look at",
            ),
            Err(_) => {}
        }
    }
}

/// Decodes the text of a file. Reports byte order marks and unusual line ends.
fn written(file: &'static str, bytes: &[u8], findings: &mut Findings) -> Option<String> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        findings.add(Severity::Error, "encoding", file, "UTF-16 text".to_owned(), "save it as UTF-8");
        return None;
    }
    let text = String::from_utf8(bytes.to_vec()).ok()?;
    let (mark, text) = match text.strip_prefix('\u{feff}') {
        Some(rest) => (true, rest.to_owned()),
        None => (false, text),
    };
    if text.trim().is_empty() {
        findings.add(Severity::Error, "file-empty", file, "empty".to_owned(), advice::EMPTY);
        return None;
    }
    let windows = text.contains("\r\n");
    if mark || windows {
        let what = match (mark, windows) {
            (true, true) => "a byte order mark and the line ends of Windows",
            (true, false) => "a byte order mark",
            _ => "the line ends of Windows",
        };
        findings.note("text-form", file, what.to_owned(), "nothing: they are read");
    }
    Some(text)
}

/// The columns that a table must have, according to `log.toml`.
fn wanted(dir: &Path, file: &str, head: Option<&Table>) -> Vec<&'static str> {
    let camera = has_camera(dir);
    let model = head.and_then(|head| head.get("vehicle")?.get("model")?.as_str());
    let several = head.is_some_and(|head| head.contains_key("sensors"));
    match (file, camera) {
        ("odometry.csv", true) => vec!["t_s", "vx_mps", "vy_mps", "vz_mps", "wx_radps", "wy_radps", "wz_radps"],
        ("odometry.csv", false) => match model {
            Some("ackermann") => vec!["t_s", "speed_mps", "steering_rad"],
            Some("unicycle" | "unicycle_arc") => vec!["t_s", "v_mps", "omega_radps"],
            Some("holonomic") => vec!["t_s", "vx_mps", "vy_mps", "omega_radps"],
            _ => vec!["t_s"],
        },
        ("scans.csv", _) if several => vec!["scan", "t_s", "sensor"],
        ("scans.csv", _) => vec!["scan", "t_s"],
        ("detections.csv", true) => vec!["scan", "ul_px", "vl_px", "ur_px", "vr_px"],
        ("detections.csv", false) => vec!["scan", "range_m", "bearing_rad"],
        ("truth.csv", true) => vec!["t_s", "x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"],
        ("truth.csv", false) => vec!["t_s", "x_m", "y_m"],
        ("landmarks.csv", true) => vec!["x_m", "y_m", "z_m"],
        ("landmarks.csv", false) => vec!["x_m", "y_m"],
        ("moving.csv", false) => vec!["subject", "t_s", "x_m", "y_m"],
        ("fixes.csv", false) => vec!["t_s"],
        _ => Vec::new(),
    }
}

fn columns(file: &'static str, text: &str, wanted: &[&'static str], findings: &mut Findings) {
    let header = text.lines().next().unwrap_or_default();
    if wanted.len() > 1 && !header.contains(',') && (header.contains(';') || header.contains('\t')) {
        let found = if header.contains(';') { "semicolons" } else { "tabs" };
        findings.add(
            Severity::Error,
            "separator",
            format!("{file}, row 1"),
            format!("columns are separated by {found}"),
            "write commas between columns, and points, not commas, in numbers",
        );
        return;
    }
    if header.trim_start().starts_with(['#', '%']) {
        findings.add(
            Severity::Error,
            "comment",
            format!("{file}, row 1"),
            "a comment, not the names of the columns".to_owned(),
            "take comments away: the first row names the columns, all others are numbers",
        );
        return;
    }
    let there: Vec<&str> = header.split(',').map(|name| name.trim().trim_matches('"')).collect();
    for name in wanted.iter().filter(|name| !there.contains(*name)) {
        // A column of the same quantity with another unit has the same name up to the unit.
        let stem = |name: &str| name.rsplit_once('_').map_or(name, |(stem, _)| stem).to_ascii_lowercase();
        let alike = there.iter().find(|other| stem(other) == stem(name) || other.eq_ignore_ascii_case(name));
        let advice = match alike.and_then(|other| UNITS.iter().find(|(end, _)| other.ends_with(end))) {
            Some((_, unit)) => format!("name the column {name}; {} is in {unit}", alike.copied().unwrap_or_default()),
            None => match alike {
                Some(other) => {
                    format!("there is a column {other}: name it {name} if that is what it holds, in that unit")
                }
                None => format!("write a column {name}; the header has {}", there.join(", ")),
            },
        };
        findings.0.push(Finding {
            severity: Severity::Error,
            code: "column-missing",
            place: format!("{file}, row 1, column {name}"),
            what: "missing".to_owned(),
            advice,
        });
    }
}
