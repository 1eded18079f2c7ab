//! A run as one HTML page without external parts, for any browser, offline.
//!
//! The data recorded during a run are a [`Film`].
//!
//! | file | |
//! |---|---|
//! | `data.rs` | the data of a page, as JSON |
//! | `page.html`, `page.css`, `page.js` | the page |
//! | `pair.rs`, `pair.html`, `pair.js` | the page for two runs |
//! | `common.js` | common parts: colours, axes, curves, touch input |
//!
//! The figures are those of the JSON output: the page has the same object, and its curves have the numbers of `scans.csv`. The
//! page states how they are thinned.

mod data;
mod pair;

use crate::difference::{Difference, Written};
use scphd_filters::kind::Kind;
use scphd_run::film::Film;
use scphd_run::session::Session;
use serde::Serialize;

const PAGE: &str = include_str!("report/page.html");
const STYLE: &str = include_str!("report/page.css");
const COMMON: &str = include_str!("report/common.js");
const SCRIPT: &str = include_str!("report/page.js");
const PAIR: &str = include_str!("report/pair.html");
const PAIR_SCRIPT: &str = include_str!("report/pair.js");

/// The page of a recorded run; `settings_text` are its settings as a file, with their origins.
pub fn page<K: Kind>(
    log: &K::Log,
    settings: &K::Settings,
    session: &Session<K>,
    film: &Film<K>,
    settings_text: &str,
) -> String {
    let data = data::Data::of::<K>(log, settings, session, film, settings_text);
    let json = embedded(&data);
    let title = format!("{}: {} {}", session.summary.log, session.summary.filter, session.summary.precision);
    let title = escaped(&title);
    filled(PAGE, &[("title", &title), ("style", STYLE), ("common", COMMON), ("script", SCRIPT), ("data", &json)])
}

/// The page for two runs that both have pages.
///
/// # Errors
/// The name of the run without a page, which has no curves.
pub fn pair_page(difference: &Difference, runs: [&Written; 2]) -> Result<String, String> {
    let page = |run: &'_ Written| -> Result<(), String> {
        run.page().map(drop).ok_or_else(|| format!("{}: no curves; a page that --html wrote has them", run.name()))
    };
    runs.into_iter().try_for_each(page)?;
    let json = embedded(&pair::Data::of(difference, runs));
    let title = escaped(&format!("{}: {} and {}", runs[0].log(), runs[0].name(), runs[1].name()));
    Ok(filled(
        PAIR,
        &[("title", &title), ("style", STYLE), ("common", COMMON), ("script", PAIR_SCRIPT), ("data", &json)],
    ))
}

/// Data for a script element: plain numbers and texts, which JSON can express. A `<` could end the script.
fn embedded(data: &impl Serialize) -> String {
    serde_json::to_string(data).unwrap_or_default().replace('<', "\\u003c")
}

/// Fills the marks of a page with parts; marks inside the parts are not replaced.
fn filled(page: &str, parts: &[(&str, &str)]) -> String {
    let mut pieces = page.split("{{");
    let mut text = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (name, rest) = piece.split_once("}}").unwrap_or(("", piece));
        text += parts.iter().find(|(part, _)| *part == name).map_or("", |(_, content)| content);
        text += rest;
    }
    text
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
