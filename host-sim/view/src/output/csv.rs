//! A record as CSV: `scans.csv` with a row for each scan, `map.csv` with a row for each feature of the final map, and
//! `moving.csv` with a row for each moving feature and scan.
//!
//! Numbers have as many digits as are needed to restore the same `f64`; an unknown value is an empty cell.

use scphd_log::dimensions::{Coordinates, Dimensions};
use scphd_score::map_error::MapError;
use scphd_score::record::{MapFeature, MovingFeature, Record, ScanRecord};
use scphd_score::results::{OutputError, sink};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub(crate) enum Cell {
    /// A count or an index.
    Count(usize),
    Number(f64),
    Text(String),
    Unknown,
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Count(count)
    }
}

impl From<&str> for Cell {
    fn from(name: &str) -> Self {
        Self::Text(name.to_owned())
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Unknown, T::into)
    }
}

/// The columns of a table with rows of type `R`: each has a name and a function of the row.
pub(crate) struct Columns<R>(Vec<Column<R>>);

/// The name of a column, and its function of the row.
type Column<R> = (String, Box<dyn Fn(&R) -> Cell>);

impl<R> Columns<R> {
    pub(crate) fn new() -> Self {
        Self(Vec::new())
    }

    pub(crate) fn with<C: Into<Cell>>(mut self, name: impl Into<String>, cell: impl Fn(&R) -> C + 'static) -> Self {
        self.0.push((name.into(), Box::new(move |row| cell(row).into())));
        self
    }

    /// Adds columns for the first `count` coordinates of a pose.
    fn with_coordinates<D: Dimensions, C: Into<Cell>>(
        mut self,
        prefix: &str,
        count: usize,
        value: impl Fn(&R, usize) -> C + Copy + 'static,
    ) -> Self {
        for (k, (name, unit)) in D::POSE[..count].iter().enumerate() {
            self = self.with(format!("{prefix}{name}_{unit}"), move |row| value(row, k));
        }
        self
    }

    /// Adds columns for the upper triangle, row by row, of the covariance of the first `count` coordinates.
    fn with_covariance<D: Dimensions>(
        mut self,
        count: usize,
        entry: impl Fn(&R, usize, usize) -> f64 + Copy + 'static,
    ) -> Self {
        for (i, (row_name, row_unit)) in D::POSE[..count].iter().enumerate() {
            for (k, (name, unit)) in D::POSE[..count].iter().enumerate().skip(i) {
                let unit = if unit == row_unit { squared(unit) } else { format!("{row_unit}_{unit}") };
                self = self.with(format!("cov_{row_name}_{name}_{unit}"), move |row| entry(row, i, k));
            }
        }
        self
    }

    /// Writes the table; the file is complete or not written.
    pub(crate) fn write<'r>(&self, path: &Path, rows: impl Iterator<Item = &'r R>) -> Result<(), OutputError>
    where
        R: 'r,
    {
        let header: Vec<&str> = self.0.iter().map(|(name, _)| name.as_str()).collect();
        write_rows(path, &header, rows.map(|row| self.0.iter().map(|(_, cell)| cell(row)).collect::<Vec<_>>()))
    }
}

fn squared(unit: &str) -> String {
    match unit.strip_suffix("ps") {
        Some(unit) => format!("{unit}2ps2"),
        None => format!("{unit}2"),
    }
}

/// `scans.csv`, a row for each scan. With figures of moving landmarks if the kind has them, otherwise of memory.
fn scan_columns<D: Dimensions>() -> Columns<ScanRecord<D>> {
    let (place, pose) = (D::Position::COUNT, D::Pose::COUNT);
    let mut columns = Columns::new()
        .with("t_s", |scan: &ScanRecord<D>| scan.t_s)
        .with_coordinates::<D, _>("", pose, |scan, k| scan.pose.as_ref()[k])
        .with_covariance::<D>(pose, |scan, i, k| scan.pose_covariance.as_ref()[i].as_ref()[k])
        .with_coordinates::<D, _>("dead_reckoning_", D::Reckoned::COUNT, |scan, k| scan.dead_reckoning.as_ref()[k])
        .with_coordinates::<D, _>("true_", place, |scan, k| scan.true_position.map(|place| place.as_ref()[k]));
    let (heading, unit) = D::POSE[place];
    columns = columns
        .with(format!("true_{heading}_{unit}"), |scan| scan.true_heading_rad)
        .with("measurements", |scan| scan.measurements)
        .with("features_estimated", |scan| scan.features_estimated)
        .with("n_eff", |scan| scan.n_eff);
    if !D::MOVING {
        columns = columns
            .with("in_view", |scan| scan.usage.in_view)
            .with("no_birth", |scan| scan.usage.no_birth)
            .with("pages_used", |scan| scan.usage.pages_used);
    }
    columns = columns.with("scan_us", |scan| scan.scan_us);
    for (name, of) in
        [("ospa_c1", (|error| error.near) as fn(MapError) -> scphd_score::ospa::Ospa), ("ospa_c10", |error| error.far)]
    {
        columns = columns
            .with(format!("{name}_m"), move |scan| scan.map_error.map(|error| of(error).distance))
            .with(format!("{name}_localization_m"), move |scan| scan.map_error.map(|error| of(error).localization))
            .with(format!("{name}_cardinality_m"), move |scan| scan.map_error.map(|error| of(error).cardinality));
    }
    if D::MOVING {
        columns = columns
            .with("moving_estimated", |scan| scan.moving.len())
            .with("movers_in_view", |scan| scan.movers.map(|movers| movers.in_view))
            .with("movers_matched", |scan| scan.movers.map(|movers| movers.matched))
            .with("moving_false", |scan| scan.movers.map(|movers| movers.spurious));
    }
    columns
}

/// `map.csv`, a row for each feature of the final map.
fn map_columns<D: Dimensions>() -> Columns<MapFeature<D>> {
    Columns::new()
        .with("id", |feature: &MapFeature<D>| feature.id as usize)
        .with("weight", |feature| feature.weight)
        .with_coordinates::<D, _>("", D::Position::COUNT, |feature, k| feature.mean.as_ref()[k])
        .with_covariance::<D>(D::Position::COUNT, |feature, i, k| feature.covariance.as_ref()[i].as_ref()[k])
}

/// `moving.csv`, a row for each moving feature and scan, with its time.
fn moving_columns<D: Dimensions>() -> Columns<(f64, MovingFeature<D>)> {
    let mut columns = Columns::new()
        .with("t_s", |(t_s, _): &(f64, MovingFeature<D>)| *t_s)
        .with("id", |(_, feature)| feature.id as usize)
        .with("weight", |(_, feature)| feature.weight)
        .with_coordinates::<D, _>("", D::Position::COUNT, |(_, feature), k| feature.position.as_ref()[k]);
    for (k, (name, unit)) in D::POSE[..D::Position::COUNT].iter().enumerate() {
        columns = columns.with(format!("velocity_{name}_{unit}ps"), move |(_, feature)| feature.velocity.as_ref()[k]);
    }
    columns.with_covariance::<D>(D::Position::COUNT, |(_, feature), i, k| feature.covariance.as_ref()[i].as_ref()[k])
}

/// Writes `scans.csv`, `map.csv` and, if features may move, `moving.csv` into the existing folder `dir`. Returns their paths.
///
/// # Errors
///
/// [`OutputError`] if a file cannot be written; complete files remain.
pub fn write_record<D: Dimensions>(dir: &Path, record: &Record<D>) -> Result<Vec<PathBuf>, OutputError> {
    let mut paths = vec![dir.join("scans.csv"), dir.join("map.csv")];
    scan_columns().write(&paths[0], record.scans.iter())?;
    map_columns().write(&paths[1], record.map.iter())?;
    if D::MOVING {
        let of_scan = |scan: &ScanRecord<D>| scan.moving.iter().map(|feature| (scan.t_s, *feature)).collect::<Vec<_>>();
        let moving: Vec<_> = record.scans.iter().flat_map(of_scan).collect();
        paths.push(dir.join("moving.csv"));
        moving_columns().write(&paths[2], moving.iter())?;
    }
    Ok(paths)
}

/// Writes a header and rows to `path`; the file is complete or not written.
pub(crate) fn write_rows<R: Serialize>(
    path: &Path,
    header: &[&str],
    rows: impl Iterator<Item = R>,
) -> Result<(), OutputError> {
    let csv_error = |source| OutputError::Csv { path: path.into(), source };
    let io_error = |source| OutputError::Io { path: path.into(), source };
    // The header is written directly, because serde would write none without rows.
    let mut writer = ::csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    writer.write_record(header).map_err(csv_error)?;
    for row in rows {
        writer.serialize(row).map_err(csv_error)?;
    }
    let bytes = writer.into_inner().map_err(|error| io_error(error.into_error()))?;
    sink::write(path, &bytes).map_err(io_error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_log::dimensions::Underwater;
    use scphd_shared_data::Folder;

    fn scan(t_s: f64) -> ScanRecord {
        ScanRecord {
            pose_covariance: [[1.0, 0.5, 0.25], [0.5, 2.0, 1.0 / 3.0], [0.25, 1.0 / 3.0, 3.0]],
            dead_reckoning: [1e17, 2.0, 3.0],
            true_position: Some([4.0, 5.0]),
            measurements: 7,
            features_estimated: 8.5,
            n_eff: f64::NAN,
            scan_us: 10.0,
            ..ScanRecord::at(t_s, [0.1 + 0.2, -1e-300, std::f64::consts::PI])
        }
    }

    fn moving_feature() -> MovingFeature {
        MovingFeature {
            id: 9,
            weight: 0.5,
            position: [1.0, 2.0],
            velocity: [1.0 / 3.0, 0.0],
            covariance: [[1.0, 0.0], [0.0, 1.0]],
        }
    }

    #[test]
    fn numbers_are_restored_exactly() {
        let folder = Folder::new("csv");
        let record = Record {
            scans: vec![scan(0.1), ScanRecord { moving: vec![moving_feature()], ..scan(2.0_f64.sqrt()) }],
            map: vec![MapFeature {
                id: 1,
                weight: 0.7,
                mean: [1.0 / 7.0, -2.0],
                covariance: [[0.1, 0.01], [0.01, 0.2]],
            }],
        };
        let paths = write_record(&folder.0, &record).unwrap();
        let [scans, map, moving] = &paths[..] else { panic!("three files") };
        assert_eq!(folder.names(), ["map.csv", "moving.csv", "scans.csv"]);

        let mut reader = ::csv::Reader::from_path(scans).unwrap();
        let header = reader.headers().unwrap().clone();
        let rows: Vec<::csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 2);
        let number = |row: usize, name: &str| -> f64 {
            let column = header.iter().position(|n| n == name).unwrap();
            rows[row][column].parse().unwrap()
        };
        assert_eq!(number(1, "t_s"), 2.0_f64.sqrt());
        assert_eq!(number(0, "x_m"), 0.1 + 0.2);
        assert_eq!(number(0, "y_m"), -1e-300);
        assert_eq!(number(0, "heading_rad"), std::f64::consts::PI);
        assert_eq!(number(0, "cov_y_heading_m_rad"), 1.0 / 3.0);
        assert_eq!(number(0, "dead_reckoning_x_m"), 1e17);
        assert_eq!(number(0, "true_y_m"), 5.0);
        assert_eq!(&rows[0][15], "");
        assert_eq!(&rows[0][16], "7");
        assert!(number(0, "n_eff").is_nan());
        assert_eq!(number(0, "scan_us"), 10.0);

        let mut reader = ::csv::Reader::from_path(map).unwrap();
        let row = reader.records().next().unwrap().unwrap();
        assert_eq!((&row[0], row[2].parse::<f64>().unwrap()), ("1", 1.0 / 7.0));

        let mut reader = ::csv::Reader::from_path(moving).unwrap();
        let row = reader.records().next().unwrap().unwrap();
        assert_eq!((row[0].parse::<f64>().unwrap(), &row[1]), (2.0_f64.sqrt(), "9"));
        assert_eq!(row[5].parse::<f64>().unwrap(), 1.0 / 3.0);
    }

    #[test]
    fn an_empty_record_gives_headers_only() {
        let folder = Folder::new("csv-empty");
        let planar: Record = Record { scans: vec![], map: vec![] };
        let header = |path: &Path| std::fs::read_to_string(path).unwrap().trim_end().to_owned();
        let headers: Vec<String> = write_record(&folder.0, &planar).unwrap().iter().map(|path| header(path)).collect();
        assert!(
            headers[0].starts_with("t_s,x_m,y_m,heading_rad,cov_x_x_m2,cov_x_y_m2,cov_x_heading_m_rad,"),
            "{headers:?}"
        );
        assert!(
            headers[0].ends_with("ospa_c10_cardinality_m,moving_estimated,movers_in_view,movers_matched,moving_false")
        );
        assert_eq!(headers[1], "id,weight,x_m,y_m,cov_x_x_m2,cov_x_y_m2,cov_y_y_m2");
        assert!(
            headers[2].starts_with("t_s,id,weight,x_m,y_m,velocity_x_mps,velocity_y_mps,cov_x_x_m2,"),
            "{headers:?}"
        );
        let space: Record<Underwater> = Record { scans: vec![], map: vec![] };
        let headers: Vec<String> = write_record(&folder.0, &space).unwrap().iter().map(|path| header(path)).collect();
        assert_eq!(headers.len(), 2);
        assert!(headers[0].contains(",cov_yaw_yaw_rad2,cov_yaw_yaw_rate_rad_radps,cov_yaw_rate_yaw_rate_rad2ps2,"));
        assert!(headers[0].contains(",n_eff,in_view,no_birth,pages_used,scan_us,ospa_c1_m,"), "{headers:?}");
    }

    #[test]
    fn a_missing_folder_is_an_error_with_the_name_of_the_file() {
        let record: Record = Record { scans: vec![], map: vec![] };
        let error = write_record(Path::new("/nonexistent/folder"), &record).unwrap_err();
        assert!(error.to_string().contains("scans.csv"), "{error}");
    }
}
