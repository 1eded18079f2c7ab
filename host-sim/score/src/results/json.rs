//! The figures of a run as a JSON object, and of several runs as a list. `docs/results.md` describes each key.

use super::{OutputError, sink};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use serde_json::Value;
use std::path::Path;

/// The format of all JSON files of the program, key `format`. It is increased when a key is removed or changes its meaning;
/// format 1 had no such key.
const FORMAT: u32 = 2;

/// The key of the present format: serialised as its number; another number is an error when read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Format;

impl Serialize for Format {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u32(FORMAT)
    }
}

impl<'de> Deserialize<'de> for Format {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let found = u32::deserialize(deserializer)?;
        let other = || de::Error::custom(format_args!("format {found}: this program reads format {FORMAT} only"));
        if found == FORMAT { Ok(Self) } else { Err(other()) }
    }
}

/// The figures of one run of one filter over one log, in the plane or in space; every key has the same meaning in both.
///
/// Serialised with exactly these keys in this order. Values that are unknown or not finite become `null`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    pub format: Format,
    pub log: String,
    pub filter: String,
    pub precision: String,
    pub particles: u64,
    pub seed: u64,
    pub scans: u64,
    pub position_rmse_m: Option<f64>,
    pub position_rmse_aligned_m: Option<f64>,
    pub heading_rmse_deg: Option<f64>,
    pub dead_reckoning_rmse_m: Option<f64>,
    pub final_position_error_m: Option<f64>,
    pub ospa_m: Option<f64>,
    pub ospa_localization_m: Option<f64>,
    pub ospa_cardinality_m: Option<f64>,
    pub gospa_m: Option<f64>,
    pub ospa_seen_m: Option<f64>,
    pub gospa_seen_m: Option<f64>,
    pub features_estimated: Option<f64>,
    pub scan_us_mean: Option<f64>,
    pub scan_us_p99: Option<f64>,
    pub state_bytes: Option<u64>,
    #[serde(serialize_with = "hexadecimal")]
    pub digest: Option<u64>,
    pub moving_hit_rate: Option<f64>,
    pub moving_settled_rate: Option<f64>,
    pub moving_position_error_median_m: Option<f64>,
    pub false_moving_tracks_per_scan: Option<f64>,
    pub static_features_matched: Option<u64>,
    pub static_features_false: Option<u64>,
    pub static_position_error_median_m: Option<f64>,
    pub ln_evidence: Option<f64>,
    pub nis_mean: Option<f64>,
    pub nis_within_95: Option<f64>,
    pub nees_median: Option<f64>,
    pub nees_within_95: Option<f64>,
    pub nees_final: Option<f64>,
    pub nees_pose_median: Option<f64>,
    pub nees_pose_within_95: Option<f64>,
    pub worse_than_dead_reckoning: Option<bool>,
    pub fixes: u64,
    pub fixes_left_out: u64,
    pub fix_relocations: u64,
    pub settings: Value,
}

/// Settings as a JSON object.
pub fn settings<S: Serialize>(settings: &S) -> Value {
    // They are plain numbers and names, all of which JSON can express.
    serde_json::to_value(settings).unwrap_or_default()
}

/// Whether an estimate with this position RMSE is worse than dead reckoning with that one. NaN is worse than any.
pub fn worse(estimate_m: Option<f64>, dead_reckoning_m: Option<f64>) -> Option<bool> {
    Some(!(estimate_m? <= dead_reckoning_m?))
}

/// Many readers of JSON lose bits of numbers above 2⁵³; therefore a string of digits.
fn hexadecimal<S: Serializer>(digest: &Option<u64>, serializer: S) -> Result<S::Ok, S::Error> {
    match digest {
        Some(digest) => serializer.collect_str(&format_args!("{digest:#018x}")),
        None => serializer.serialize_none(),
    }
}

/// Writes one summary to `path` as a JSON object; the file is complete or not written.
pub fn write_summary(path: &Path, summary: &Summary) -> Result<(), OutputError> {
    write(path, summary)
}

/// Writes summaries to `path` as a JSON list of objects; the file is complete or not written.
pub fn write_summaries(path: &Path, summaries: &[Summary]) -> Result<(), OutputError> {
    write(path, summaries)
}

/// Writes `value` indented, with a newline at the end.
pub fn write<T: Serialize + ?Sized>(path: &Path, value: &T) -> Result<(), OutputError> {
    // serde_json writes `null` for a number that is not finite.
    let mut bytes =
        serde_json::to_vec_pretty(value).map_err(|source| OutputError::Json { path: path.into(), source })?;
    bytes.push(b'\n');
    sink::write(path, &bytes).map_err(|source| OutputError::Io { path: path.into(), source })
}

/// An artificial summary, for tests of its display.
pub fn made_up() -> Summary {
    Summary {
        format: Format,
        log: "circle".into(),
        filter: "scphd".into(),
        precision: "f32".into(),
        particles: 40,
        seed: 1,
        scans: 300,
        position_rmse_m: Some(0.1 + 0.2),
        position_rmse_aligned_m: Some(0.25),
        heading_rmse_deg: None,
        dead_reckoning_rmse_m: Some(12.5),
        final_position_error_m: Some(f64::NAN),
        ospa_m: Some(1.25),
        ospa_localization_m: Some(f64::INFINITY),
        ospa_cardinality_m: Some(0.0),
        gospa_m: Some(3.0),
        ospa_seen_m: Some(1.0),
        gospa_seen_m: None,
        features_estimated: Some(11.9),
        scan_us_mean: Some(812.3),
        scan_us_p99: Some(1201.0),
        state_bytes: Some(262_144),
        digest: Some(0x0123_4567_89ab_cdef),
        moving_hit_rate: Some(0.95),
        moving_settled_rate: Some(0.9),
        moving_position_error_median_m: None,
        false_moving_tracks_per_scan: Some(0.125),
        static_features_matched: Some(14),
        static_features_false: Some(1),
        static_position_error_median_m: Some(0.11),
        ln_evidence: Some(-1234.5),
        nis_mean: Some(1.02),
        nis_within_95: Some(0.9),
        nees_median: Some(1.5),
        nees_within_95: Some(0.8),
        nees_final: Some(2.0),
        nees_pose_median: Some(1.2),
        nees_pose_within_95: None,
        worse_than_dead_reckoning: Some(false),
        fixes: 6,
        fixes_left_out: 1,
        fix_relocations: 0,
        settings: serde_json::json!({ "filter": { "samples": 2 } }),
    }
}

#[cfg(test)]
mod tests {
    use super::made_up as summary;
    use super::*;
    use scphd_shared_data::Folder;

    #[test]
    fn a_summary_is_one_object_with_null_for_unknown_values() {
        let folder = Folder::new("json");
        let path = folder.0.join("summary.json");
        write_summary(&path, &summary()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let value: Value = serde_json::from_str(&text).unwrap();
        assert_eq!((&value["format"], &value["settings"]["filter"]["samples"]), (&2.into(), &2.into()));
        assert_eq!(value["particles"], 40);
        assert_eq!(value["position_rmse_m"].as_f64().unwrap(), 0.1 + 0.2);
        assert!(value["heading_rmse_deg"].is_null());
        assert!(value["final_position_error_m"].is_null());
        assert!(value["ospa_localization_m"].is_null());
        assert_eq!(value["digest"], "0x0123456789abcdef");
        assert_eq!(folder.names(), ["summary.json"]);
    }

    #[test]
    fn another_format_is_not_read() {
        assert_eq!(serde_json::from_str::<Format>(&serde_json::to_string(&Format).unwrap()).unwrap(), Format);
        let error = serde_json::from_str::<Format>("1").unwrap_err().to_string();
        assert!(error.contains("format 1") && error.contains("format 2"), "{error}");
    }

    #[test]
    fn worse_than_dead_reckoning() {
        assert_eq!(worse(Some(1.0), Some(2.0)), Some(false));
        assert_eq!(worse(Some(2.0), Some(1.0)), Some(true));
        assert_eq!(worse(Some(1.0), Some(1.0)), Some(false));
        assert_eq!(worse(Some(f64::NAN), Some(1.0)), Some(true));
        assert_eq!((worse(None, Some(1.0)), worse(Some(1.0), None)), (None, None));
    }

    #[test]
    fn a_list_of_objects_and_a_missing_digest() {
        let folder = Folder::new("json-list");
        let path = folder.0.join("summaries.json");
        let reference = Summary { digest: None, state_bytes: None, ..summary() };
        let short = Summary { digest: Some(0xf), ..summary() };
        write_summaries(&path, &[reference, short]).unwrap();
        let value: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        assert_eq!(value.as_array().unwrap().len(), 2);
        assert!(value[0]["digest"].is_null());
        assert!(value[0]["state_bytes"].is_null());
        assert_eq!(value[1]["digest"], "0x000000000000000f");
    }
}
