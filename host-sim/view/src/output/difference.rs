//! The comparison of two runs on a terminal, and as JSON.

use super::table::{decimals, ruled};
use crate::difference::{Difference, plain};
use comfy_table::Row;
use scphd_score::results::{OutputError, json};
use serde_json::Value;
use std::path::Path;

/// The different settings and all figures as text, without a newline at the end.
pub fn render(difference: &Difference) -> String {
    let [a, b] = &difference.runs;
    let mut parts = vec![format!("A: {a}\nB: {b}")];
    if difference.settings.is_empty() {
        parts.push("no setting differs".into());
    } else {
        let rows =
            difference.settings.iter().map(|one| Row::from(vec![one.setting.clone(), plain(&one.a), plain(&one.b)]));
        parts.push(ruled(Row::from(vec!["setting", "A", "B"]), rows));
    }
    let rows = difference.figures.iter().map(|one| {
        // Equal figures have an empty difference.
        let digits = if one.a.is_f64() || one.b.is_f64() { 3 } else { 0 };
        let off = one.difference.filter(|off| *off != 0.0).map_or_else(String::new, |off| decimals(Some(off), digits));
        Row::from(vec![one.key.clone(), short(&one.a), short(&one.b), off])
    });
    parts.push(ruled(Row::from(vec!["figure", "A", "B", "B - A"]), rows));
    parts.join("\n\n")
}

/// Whole numbers and names as they are, other numbers with three decimals.
fn short(value: &Value) -> String {
    match value.as_f64() {
        Some(number) if value.is_f64() => decimals(Some(number), 3),
        _ => plain(value),
    }
}

/// Writes the comparison to `path` as a JSON object; the file is complete or not written.
pub fn write(path: &Path, difference: &Difference) -> Result<(), OutputError> {
    json::write(path, difference)
}
