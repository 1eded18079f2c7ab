//! A record as CSV: `scans.csv`, one row a scan, `map.csv`, one row a feature of the final map, and `moving.csv`, one
//! row a moving feature and scan.
//!
//! Numbers are printed with as many digits as bring back the same `f64`; an unknown value is an empty cell.

use super::{OutputError, sink};
use crate::record::{MapFeature, MovingFeature, Record, ScanRecord};
use crate::score::map_error::MapError;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Header and order of `scans.csv`. Of the symmetric covariance only the upper triangle is kept.
#[derive(Serialize)]
struct ScanRow {
    t_s: f64,
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
    cov_x_x_m2: f64,
    cov_x_y_m2: f64,
    cov_x_heading_m_rad: f64,
    cov_y_y_m2: f64,
    cov_y_heading_m_rad: f64,
    cov_heading_heading_rad2: f64,
    dead_reckoning_x_m: f64,
    dead_reckoning_y_m: f64,
    dead_reckoning_heading_rad: f64,
    true_x_m: Option<f64>,
    true_y_m: Option<f64>,
    true_heading_rad: Option<f64>,
    measurements: usize,
    features_estimated: f64,
    n_eff: f64,
    scan_us: f64,
    ospa_c1_m: Option<f64>,
    ospa_c1_localization_m: Option<f64>,
    ospa_c1_cardinality_m: Option<f64>,
    ospa_c10_m: Option<f64>,
    ospa_c10_localization_m: Option<f64>,
    ospa_c10_cardinality_m: Option<f64>,
    moving_estimated: usize,
    movers_in_view: Option<usize>,
    movers_matched: Option<usize>,
    moving_false: Option<usize>,
}

impl From<&ScanRecord> for ScanRow {
    fn from(scan: &ScanRecord) -> Self {
        let p = &scan.pose_covariance;
        let error = |figure: fn(&MapError) -> f64| scan.map_error.as_ref().map(figure);
        Self {
            t_s: scan.t_s,
            x_m: scan.pose[0],
            y_m: scan.pose[1],
            heading_rad: scan.pose[2],
            cov_x_x_m2: p[0][0],
            cov_x_y_m2: p[0][1],
            cov_x_heading_m_rad: p[0][2],
            cov_y_y_m2: p[1][1],
            cov_y_heading_m_rad: p[1][2],
            cov_heading_heading_rad2: p[2][2],
            dead_reckoning_x_m: scan.dead_reckoning[0],
            dead_reckoning_y_m: scan.dead_reckoning[1],
            dead_reckoning_heading_rad: scan.dead_reckoning[2],
            true_x_m: scan.true_position.map(|p| p[0]),
            true_y_m: scan.true_position.map(|p| p[1]),
            true_heading_rad: scan.true_heading_rad,
            measurements: scan.measurements,
            features_estimated: scan.features_estimated,
            n_eff: scan.n_eff,
            scan_us: scan.scan_us,
            ospa_c1_m: error(|error| error.near.distance),
            ospa_c1_localization_m: error(|error| error.near.localization),
            ospa_c1_cardinality_m: error(|error| error.near.cardinality),
            ospa_c10_m: error(|error| error.far.distance),
            ospa_c10_localization_m: error(|error| error.far.localization),
            ospa_c10_cardinality_m: error(|error| error.far.cardinality),
            moving_estimated: scan.moving.len(),
            movers_in_view: scan.movers.map(|movers| movers.in_view),
            movers_matched: scan.movers.map(|movers| movers.matched),
            moving_false: scan.movers.map(|movers| movers.spurious),
        }
    }
}

/// Names of the columns of [`ScanRow`], for a record without rows.
const SCAN_HEADER: [&str; 30] = [
    "t_s",
    "x_m",
    "y_m",
    "heading_rad",
    "cov_x_x_m2",
    "cov_x_y_m2",
    "cov_x_heading_m_rad",
    "cov_y_y_m2",
    "cov_y_heading_m_rad",
    "cov_heading_heading_rad2",
    "dead_reckoning_x_m",
    "dead_reckoning_y_m",
    "dead_reckoning_heading_rad",
    "true_x_m",
    "true_y_m",
    "true_heading_rad",
    "measurements",
    "features_estimated",
    "n_eff",
    "scan_us",
    "ospa_c1_m",
    "ospa_c1_localization_m",
    "ospa_c1_cardinality_m",
    "ospa_c10_m",
    "ospa_c10_localization_m",
    "ospa_c10_cardinality_m",
    "moving_estimated",
    "movers_in_view",
    "movers_matched",
    "moving_false",
];

/// Header and order of `map.csv`.
#[derive(Serialize)]
struct MapRow {
    id: u32,
    weight: f64,
    x_m: f64,
    y_m: f64,
    cov_x_x_m2: f64,
    cov_x_y_m2: f64,
    cov_y_y_m2: f64,
}

impl From<&MapFeature> for MapRow {
    fn from(feature: &MapFeature) -> Self {
        Self {
            id: feature.id,
            weight: feature.weight,
            x_m: feature.mean[0],
            y_m: feature.mean[1],
            cov_x_x_m2: feature.covariance[0][0],
            cov_x_y_m2: feature.covariance[0][1],
            cov_y_y_m2: feature.covariance[1][1],
        }
    }
}

/// Names of the columns of [`MapRow`], for an empty map.
const MAP_HEADER: [&str; 7] = ["id", "weight", "x_m", "y_m", "cov_x_x_m2", "cov_x_y_m2", "cov_y_y_m2"];

/// Header and order of `moving.csv`.
#[derive(Serialize)]
struct MovingRow {
    t_s: f64,
    id: u32,
    weight: f64,
    x_m: f64,
    y_m: f64,
    velocity_x_mps: f64,
    velocity_y_mps: f64,
    cov_x_x_m2: f64,
    cov_x_y_m2: f64,
    cov_y_y_m2: f64,
}

impl MovingRow {
    fn new(t_s: f64, feature: &MovingFeature) -> Self {
        Self {
            t_s,
            id: feature.id,
            weight: feature.weight,
            x_m: feature.position[0],
            y_m: feature.position[1],
            velocity_x_mps: feature.velocity[0],
            velocity_y_mps: feature.velocity[1],
            cov_x_x_m2: feature.covariance[0][0],
            cov_x_y_m2: feature.covariance[0][1],
            cov_y_y_m2: feature.covariance[1][1],
        }
    }
}

/// Names of the columns of [`MovingRow`], for a run without moving features.
const MOVING_HEADER: [&str; 10] =
    ["t_s", "id", "weight", "x_m", "y_m", "velocity_x_mps", "velocity_y_mps", "cov_x_x_m2", "cov_x_y_m2", "cov_y_y_m2"];

/// Writes `scans.csv`, `map.csv` and `moving.csv` into the existing folder `dir` and returns their paths.
///
/// # Errors
///
/// [`OutputError`] where a file cannot be written; files already complete stay.
pub fn write_record(dir: &Path, record: &Record) -> Result<[PathBuf; 3], OutputError> {
    let scans = dir.join("scans.csv");
    let map = dir.join("map.csv");
    write_rows(&scans, &SCAN_HEADER, record.scans.iter().map(ScanRow::from))?;
    write_rows(&map, &MAP_HEADER, record.map.iter().map(MapRow::from))?;
    let moving = dir.join("moving.csv");
    let of_scan =
        |scan: &ScanRecord| scan.moving.iter().map(|feature| MovingRow::new(scan.t_s, feature)).collect::<Vec<_>>();
    write_rows(&moving, &MOVING_HEADER, record.scans.iter().flat_map(of_scan))?;
    Ok([scans, map, moving])
}

/// Writes a header and rows to `path`, all or nothing.
pub(crate) fn write_rows<R: Serialize>(
    path: &Path,
    header: &[&str],
    rows: impl Iterator<Item = R>,
) -> Result<(), OutputError> {
    let csv_error = |source| OutputError::Csv { path: path.into(), source };
    let io_error = |source| OutputError::Io { path: path.into(), source };
    // The header is written by name, not by serde, which would write none where there is no row.
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
    use crate::output::sink::tests::Folder;

    fn scan(t_s: f64) -> ScanRecord {
        ScanRecord {
            t_s,
            pose: [0.1 + 0.2, -1e-300, std::f64::consts::PI],
            pose_covariance: [[1.0, 0.5, 0.25], [0.5, 2.0, 1.0 / 3.0], [0.25, 1.0 / 3.0, 3.0]],
            dead_reckoning: [1e17, 2.0, 3.0],
            true_position: Some([4.0, 5.0]),
            true_heading_rad: None,
            measurements: 7,
            features_estimated: 8.5,
            n_eff: f64::NAN,
            scan_us: 10.0,
            moving: Vec::new(),
            map_error: None,
            movers: None,
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
    fn numbers_come_back_as_they_were() {
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
        let [scans, map, moving] = write_record(&folder.0, &record).unwrap();
        assert_eq!(folder.names(), ["map.csv", "moving.csv", "scans.csv"]);

        let mut reader = ::csv::Reader::from_path(scans).unwrap();
        assert_eq!(reader.headers().unwrap(), &SCAN_HEADER[..]);
        let rows: Vec<::csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 2);
        let number = |row: usize, name: &str| -> f64 {
            let column = SCAN_HEADER.iter().position(|n| *n == name).unwrap();
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
    fn the_header_names_the_fields_of_the_row() {
        let mut writer = ::csv::Writer::from_writer(Vec::new());
        writer.serialize(ScanRow::from(&scan(0.0))).unwrap();
        let text = String::from_utf8(writer.into_inner().unwrap()).unwrap();
        assert_eq!(text.lines().next().unwrap(), SCAN_HEADER.join(","));

        let mut writer = ::csv::Writer::from_writer(Vec::new());
        let feature = MapFeature { id: 1, weight: 1.0, mean: [0.0; 2], covariance: [[0.0; 2]; 2] };
        writer.serialize(MapRow::from(&feature)).unwrap();
        let text = String::from_utf8(writer.into_inner().unwrap()).unwrap();
        assert_eq!(text.lines().next().unwrap(), MAP_HEADER.join(","));

        let mut writer = ::csv::Writer::from_writer(Vec::new());
        writer.serialize(MovingRow::new(0.0, &moving_feature())).unwrap();
        let text = String::from_utf8(writer.into_inner().unwrap()).unwrap();
        assert_eq!(text.lines().next().unwrap(), MOVING_HEADER.join(","));
    }

    #[test]
    fn an_empty_record_leaves_headers() {
        let folder = Folder::new("csv-empty");
        let record = Record { scans: vec![], map: vec![] };
        let [scans, map, moving] = write_record(&folder.0, &record).unwrap();
        let scans = std::fs::read_to_string(scans).unwrap();
        assert_eq!(scans.trim_end(), SCAN_HEADER.join(","));
        let map = std::fs::read_to_string(map).unwrap();
        assert_eq!(map.trim_end(), MAP_HEADER.join(","));
        let moving = std::fs::read_to_string(moving).unwrap();
        assert_eq!(moving.trim_end(), MOVING_HEADER.join(","));
    }

    #[test]
    fn a_missing_folder_is_an_error_that_names_the_file() {
        let record = Record { scans: vec![], map: vec![] };
        let error = write_record(Path::new("/nonexistent/folder"), &record).unwrap_err();
        assert!(error.to_string().contains("scans.csv"), "{error}");
    }
}
