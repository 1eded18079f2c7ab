//! Where the tests find the published logs and the oracles. They are not part of this repository;
//! a test that needs them says that it was skipped where they are absent.

use std::path::PathBuf;

/// The path of `name` in the shared data, or a note that the test is skipped.
pub(crate) fn find(name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("SCPHD_DATA")
        .map_or_else(|| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data")), PathBuf::from);
    let path = root.join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: no {}", path.display());
    None
}

/// An oracle file, parsed.
pub(crate) fn oracle(name: &str) -> Option<serde_json::Value> {
    let path = find("oracles")?.join(name);
    let text = std::fs::read_to_string(path).expect("readable oracle");
    Some(serde_json::from_str(&text).expect("valid oracle"))
}

/// Numbers of a JSON array.
pub(crate) fn numbers(value: &serde_json::Value) -> Vec<f64> {
    let list = value.as_array().expect("array");
    list.iter().map(|v| v.as_f64().expect("number")).collect()
}
