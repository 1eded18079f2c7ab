//! Differences between filter and reference: a table, a JSON list, CSV rows.

use super::csv;
use super::table::{grouped, ruled};
use comfy_table::Row;
use scphd_run::compare::{Differences, JointDifferences};
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

/// A field: its name in files, its name with the unit in the table, and its value as text.
type Field<D> = (&'static str, &'static str, fn(&D) -> String);

/// Differences for a kind of filter.
pub trait Fields: Serialize + Sized + 'static {
    /// Its fields in order.
    const FIELDS: &'static [Field<Self>];

    /// Rows of the table with the parameters of the filter.
    fn heads(compared: &[Compared<Self>]) -> Vec<Row>;
}

impl Fields for Differences {
    const FIELDS: &'static [Field<Self>] = &FIELDS;

    fn heads(compared: &[Compared]) -> Vec<Row> {
        vec![
            row("particles × samples", compared, |c| format!("{} × {}", c.particles, c.samples)),
            row("seed", compared, |c| c.seed.to_string()),
        ]
    }
}

impl Fields for JointDifferences {
    const FIELDS: &'static [Field<Self>] = &JOINT_FIELDS;

    fn heads(_: &[Compared<Self>]) -> Vec<Row> {
        Vec::new()
    }
}

const FIELDS: [Field<Differences>; 18] = [
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

const JOINT_FIELDS: [Field<JointDifferences>; 25] = [
    ("scans", "scans", |d| count(d.scans)),
    ("predicted_position_m", "predicted position (m)", |d| power(d.predicted_position_m)),
    ("predicted_heading_rad", "predicted heading (rad)", |d| power(d.predicted_heading_rad)),
    ("predicted_covariance", "predicted covariance (relative)", |d| power(d.predicted_covariance)),
    ("waited_s", "time since the scan (s)", |d| power(d.waited_s)),
    ("ln_evidence", "ln evidence (relative)", |d| power(d.ln_evidence)),
    ("innovation", "mean squared innovation (relative)", |d| power(d.innovation)),
    ("estimated_position_m", "estimated position (m)", |d| power(d.estimated_position_m)),
    ("estimated_heading_rad", "estimated heading (rad)", |d| power(d.estimated_heading_rad)),
    ("mean", "feature mean (relative)", |d| power(d.mean)),
    ("pose_covariance", "pose covariance (relative)", |d| power(d.pose_covariance)),
    ("feature_covariance", "feature covariance (relative)", |d| power(d.feature_covariance)),
    ("cross_covariance", "cross-covariance (relative)", |d| power(d.cross_covariance)),
    ("existence", "probability of a feature", |d| power(d.existence)),
    ("detections", "detections of a feature", |d| power(d.detections)),
    ("mover_weight", "probability of a mover", |d| power(d.mover_weight)),
    ("mover_mean", "mean of a mover (relative)", |d| power(d.mover_mean)),
    ("mover_covariance", "covariance of a mover (relative)", |d| power(d.mover_covariance)),
    ("features", "features compared", |d| count(d.features)),
    ("movers", "movers compared", |d| count(d.movers)),
    ("unmatched", "features unmatched", |d| count(d.unmatched)),
    ("other_views", "scans with other views", |d| count(d.other_views)),
    ("capacity_events", "scans short of room", |d| count(d.capacity_events)),
    ("own_way_position_m", "position, each on its own way (m)", |d| power(d.own_way_position_m)),
    ("own_way_heading_rad", "heading, each on its own way (rad)", |d| power(d.own_way_heading_rad)),
];

/// A row of the table: a name, and its value in every precision.
fn row<D>(name: &str, compared: &[Compared<D>], show: impl Fn(&Compared<D>) -> String) -> Row {
    Row::from(iter::once(name.to_owned()).chain(compared.iter().map(show)).collect::<Vec<_>>())
}

/// The differences as text without a newline at the end: a row for each field, a column for each precision.
pub fn render<D: Fields>(compared: &[Compared<D>]) -> String {
    let precision = row("precision", compared, |c| c.precision.clone());
    let fields = D::FIELDS.iter().map(|(_, name, show)| row(name, compared, |c| show(&c.differences)));
    let rows = iter::once(precision).chain(D::heads(compared)).chain(fields);
    ruled(row("log", compared, |c| c.log.clone()), rows)
}

/// Writes a JSON list of objects; the file is complete or not written.
pub fn write_json<D: Fields>(path: &Path, compared: &[Compared<D>]) -> Result<(), OutputError> {
    json::write(path, compared)
}

/// Writes a row for each scan, with its time (s) and its differences; the file is complete or not written.
pub fn write_csv<D: Fields>(path: &Path, scans: impl Iterator<Item = (f64, D)>) -> Result<(), OutputError> {
    let header: Vec<&str> = iter::once("t_s").chain(D::FIELDS.iter().map(|&(name, ..)| name)).collect();
    csv::write_rows(path, &header, scans)
}

fn count(value: usize) -> String {
    grouped(value as u64)
}

/// A difference with its order of magnitude.
fn power(value: f64) -> String {
    if value == 0.0 { "0".into() } else { format!("{value:.2e}") }
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
        assert_eq!(power(0.0), "0");
        assert_eq!(power(1.234e-12), "1.23e-12");
        assert_eq!(power(f64::NAN), "NaN");
    }
}
