//! Differences between filter and reference: a table, a JSON list, CSV rows.

use super::csv;
use super::table::{grouped, ruled};
use comfy_table::Row;
use scphd_run::compare::{Differences, Figure, Figures, JointDifferences};
use scphd_score::results::OutputError;
use scphd_score::results::json::{self, Format};
use serde::Serialize;
use serde_json::Value;
use std::iter;
use std::path::Path;

/// The differences over one log in one precision, with their conditions. Serialised as one object.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Compared<D = Differences> {
    pub format: Format,
    pub log: String,
    /// Number type of the filter: `f32` or `f64`.
    pub precision: String,
    /// Particles N.
    pub particles: usize,
    /// Samples M of every particle.
    pub samples: usize,
    pub seed: u64,
    /// The largest differences of all scans.
    #[serde(flatten)]
    pub differences: D,
    /// All settings of the run, by section and name as in a settings file.
    pub settings: Value,
}

/// Differences for a kind of filter.
pub trait Fields: Figures + Sized {
    /// Rows of the table with the parameters of the filter.
    fn heads(compared: &[Compared<Self>]) -> Vec<Row>;
}

impl Fields for Differences {
    fn heads(compared: &[Compared]) -> Vec<Row> {
        vec![
            row("particles × samples", compared, |c| format!("{} × {}", c.particles, c.samples)),
            row("seed", compared, |c| c.seed.to_string()),
        ]
    }
}

impl Fields for JointDifferences {
    fn heads(_: &[Compared<Self>]) -> Vec<Row> {
        Vec::new()
    }
}

/// A row of the table: a name, and its value in every precision.
fn row<D>(name: &str, compared: &[Compared<D>], show: impl Fn(&Compared<D>) -> String) -> Row {
    Row::from(iter::once(name.to_owned()).chain(compared.iter().map(show)).collect::<Vec<_>>())
}

/// The differences as text without a newline at the end: a row for each field, a column for each precision.
pub fn render<D: Fields>(compared: &[Compared<D>]) -> String {
    let precision = row("precision", compared, |c| c.precision.clone());
    let fields = D::NAMES.iter().enumerate();
    let fields = fields.map(|(k, (_, name))| row(name, compared, |c| shown(c.differences.figures()[k])));
    let rows = iter::once(precision).chain(D::heads(compared)).chain(fields);
    ruled(row("log", compared, |c| c.log.clone()), rows)
}

/// Writes a JSON list of objects; the file is complete or not written.
pub fn write_json<D: Fields>(path: &Path, compared: &[Compared<D>]) -> Result<(), OutputError> {
    json::write(path, compared)
}

/// Writes a row for each scan, with its time (s) and its differences; the file is complete or not written.
pub fn write_csv<D: Fields>(path: &Path, scans: impl Iterator<Item = (f64, D)>) -> Result<(), OutputError> {
    let header: Vec<&str> = iter::once("t_s").chain(D::NAMES.iter().map(|&(name, _)| name)).collect();
    csv::write_rows(path, &header, scans)
}

/// A count, or a difference with its order of magnitude.
fn shown(figure: Figure) -> String {
    match figure {
        Figure::Count(count) => grouped(count as u64),
        Figure::Greatest(0.0) => "0".into(),
        Figure::Greatest(difference) => format!("{difference:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_shared_data::Folder;

    #[test]
    fn every_field_has_its_column() {
        let differences = Differences { scans: 1, covariance: 3e-9, capacity_events: 4, ..Differences::default() };
        columns_are_of(differences);
        columns_are_of(JointDifferences { scans: 1, existence: 3e-9, features: 4, ..JointDifferences::default() });
    }

    fn columns_are_of<D: Fields + Copy>(differences: D) {
        let folder = Folder::new("comparison");
        let path = folder.0.join("compare.csv");
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
        for (difference, text) in [(0.0, "0"), (1.234e-12, "1.23e-12"), (f64::NAN, "NaN")] {
            assert_eq!(shown(Figure::Greatest(difference)), text);
        }
    }
}
