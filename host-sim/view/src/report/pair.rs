//! The data of a page of two runs.

use crate::difference::{Difference, Written};
use crate::meaning;
use serde::Serialize;
use serde_json::Value;

/// All data of a page; `pair.js` uses these names.
#[derive(Debug, Serialize)]
pub(super) struct Data<'a> {
    difference: &'a Difference,
    meanings: Vec<(String, String)>,
    runs: [Run<'a>; 2],
}

/// The parts of a run's page that this page shows.
#[derive(Debug, Serialize)]
struct Run<'a> {
    looks: &'a Value,
    axes: &'a Value,
    series: &'a Value,
    landmarks: &'a Value,
    /// The last frame: the final map.
    last: Option<&'a Value>,
}

impl<'a> Data<'a> {
    pub(super) fn of(difference: &'a Difference, runs: [&'a Written; 2]) -> Self {
        let run = |page: &'a Value| Run {
            looks: &page["looks"],
            axes: &page["axes"],
            series: &page["series"],
            landmarks: &page["landmarks"],
            last: page["frames"].as_array().and_then(|frames| frames.last()),
        };
        Self {
            difference,
            meanings: meaning::of_figures(),
            runs: runs.map(|written| run(written.page().unwrap_or(&Value::Null))),
        }
    }
}
