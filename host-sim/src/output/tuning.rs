//! Proposed settings as a table.

use super::table::{decimals, grouped, ruled};
use crate::tune::Proposed;
use comfy_table::Row;

/// One row a setting: what it was, what is proposed, and how many observations say so.
#[must_use]
pub fn render(log: &str, proposed: &[Proposed]) -> String {
    let header = Row::from([log, "now", "proposed", "observations"]);
    let rows = proposed.iter().map(|proposed| {
        let value = |value| decimals(Some(value), 4);
        Row::from([
            proposed.name.to_owned(),
            value(proposed.before),
            value(proposed.after),
            grouped(proposed.observations as u64),
        ])
    });
    ruled(header, rows)
}
