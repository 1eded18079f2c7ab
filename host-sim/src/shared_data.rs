//! What the tests read of the published logs, which are not part of this repository, and of the oracles, which are.

pub(crate) use scphd_shared_data::find;

/// An oracle file, parsed.
pub(crate) fn oracle(name: &str) -> serde_json::Value {
    serde_json::from_str(&scphd_shared_data::oracle(name)).expect("valid oracle")
}

/// Numbers of a JSON array.
pub(crate) fn numbers(value: &serde_json::Value) -> Vec<f64> {
    let list = value.as_array().expect("array");
    list.iter().map(|v| v.as_f64().expect("number")).collect()
}
