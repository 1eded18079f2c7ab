//! Differences between filter and reference: a table, a JSON list, CSV rows.

use super::json::{self, Format};
use super::table::{grouped, ruled};
use super::{OutputError, csv};
use crate::compare::Differences;
use comfy_table::Row;
use serde::Serialize;
use serde_json::Value;
use std::iter;
use std::path::Path;

/// The differences over one log in one precision, with what they depend on. Serialised as one object.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Compared {
    /// The format of the keys.
    pub format: Format,
    /// Name of the log.
    pub log: String,
    /// Number type of the filter: `f32` or `f64`.
    pub precision: String,
    /// Number of particles N.
    pub particles: usize,
    /// Samples M of every particle.
    pub samples: usize,
    /// Seed of the random numbers.
    pub seed: u64,
    /// The largest differences of all scans.
    #[serde(flatten)]
    pub differences: Differences,
    /// All settings of the run, by section and name as in a settings file.
    pub settings: Value,
}

/// A field: its name in files, its name with the unit in the table, and its text there.
type Field = (&'static str, &'static str, fn(&Differences) -> String);

/// The fields of [`Differences`] in order.
const FIELDS: [Field; 18] = [
    ("scans", "scans", |d| count(d.scans)),
    ("predicted_position_m", "predicted position (m)", |d| power(d.predicted_position_m)),
    ("predicted_heading_rad", "predicted heading (rad)", |d| power(d.predicted_heading_rad)),
    ("waited_s", "time since the scan (s)", |d| power(d.waited_s)),
    ("ln_likelihood", "ln likelihood (relative)", |d| power(d.ln_likelihood)),
    ("particle_weight", "particle weight (relative)", |d| power(d.particle_weight)),
    ("component_weight", "component weight (relative)", |d| power(d.component_weight)),
    ("mean", "component mean (relative)", |d| power(d.mean)),
    ("covariance", "component covariance (relative)", |d| power(d.covariance)),
    ("mass", "map mass (relative)", |d| power(d.mass)),
    ("estimated_position_m", "estimated position (m)", |d| power(d.estimated_position_m)),
    ("estimated_heading_rad", "estimated heading (rad)", |d| power(d.estimated_heading_rad)),
    ("other_survivors", "scans with other survivors", |d| count(d.other_survivors)),
    ("components", "static components compared", |d| count(d.components)),
    ("moving_components", "moving components compared", |d| count(d.moving_components)),
    ("unmatched", "components unmatched", |d| count(d.unmatched)),
    ("unmatched_mass", "unmatched mass (share of a map)", |d| power(d.unmatched_mass)),
    ("capacity_events", "scans short of room", |d| count(d.capacity_events)),
];

/// The differences side by side, as text without a newline at the end: one row a field, one column a precision.
#[must_use]
pub fn render(compared: &[Compared]) -> String {
    let row = |name: &str, show: &dyn Fn(&Compared) -> String| {
        Row::from(iter::once(name.to_owned()).chain(compared.iter().map(show)).collect::<Vec<_>>())
    };
    let heads = [
        row("precision", &|c| c.precision.clone()),
        row("particles × samples", &|c| format!("{} × {}", c.particles, c.samples)),
        row("seed", &|c| c.seed.to_string()),
    ];
    let fields = FIELDS.iter().map(|(_, name, show)| row(name, &|c| show(&c.differences)));
    ruled(row("log", &|c| c.log.clone()), heads.into_iter().chain(fields))
}

/// Writes a JSON list of objects, all or nothing.
///
/// # Errors
///
/// [`OutputError`] where the file cannot be written.
pub fn write_json(path: &Path, compared: &[Compared]) -> Result<(), OutputError> {
    json::write(path, compared)
}

/// Writes one row a scan, its time (s) and its differences, all or nothing.
///
/// # Errors
///
/// [`OutputError`] where the file cannot be written.
pub fn write_csv(path: &Path, scans: impl Iterator<Item = (f64, Differences)>) -> Result<(), OutputError> {
    let header: Vec<&str> = iter::once("t_s").chain(FIELDS.map(|(name, ..)| name)).collect();
    csv::write_rows(path, &header, scans)
}

fn count(value: usize) -> String {
    grouped(value as u64)
}

/// A difference: its order of magnitude is what matters.
fn power(value: f64) -> String {
    if value == 0.0 { "0".into() } else { format!("{value:.2e}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::sink::tests::Folder;

    #[test]
    fn every_field_has_its_column() {
        let folder = Folder::new("comparison");
        let path = folder.0.join("compare.csv");
        let differences = Differences { scans: 1, covariance: 3e-9, capacity_events: 4, ..Differences::default() };
        write_csv(&path, iter::once((0.5, differences))).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let mut writer = ::csv::Writer::from_writer(Vec::new());
        writer.serialize(differences).unwrap();
        let plain = String::from_utf8(writer.into_inner().unwrap()).unwrap();
        let expected: Vec<String> =
            plain.lines().zip(["t_s", "0.5"]).map(|(line, first)| format!("{first},{line}")).collect();
        assert_eq!(text.lines().collect::<Vec<_>>(), expected);
    }

    #[test]
    fn magnitudes_are_readable() {
        assert_eq!(power(0.0), "0");
        assert_eq!(power(1.234e-12), "1.23e-12");
        assert_eq!(power(f64::NAN), "NaN");
    }
}
