//! What the tests read of the published logs and the oracles, which are not part of this repository.

pub(crate) use scphd_shared_data::find;

/// An oracle file, parsed.
pub(crate) fn oracle(name: &str) -> Option<serde_json::Value> {
    let path = find(&format!("oracles/{name}"))?;
    let text = std::fs::read_to_string(path).expect("readable oracle");
    Some(serde_json::from_str(&text).expect("valid oracle"))
}

/// Numbers of a JSON array.
pub(crate) fn numbers(value: &serde_json::Value) -> Vec<f64> {
    let list = value.as_array().expect("array");
    list.iter().map(|v| v.as_f64().expect("number")).collect()
}
