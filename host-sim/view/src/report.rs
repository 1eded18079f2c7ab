//! A run as one page that needs nothing else: no network, no program but a browser.
//!
//! What is kept of a run while it goes on is a [`Film`].
//!
//! | file | |
//! |---|---|
//! | `data.rs` | the data of a page, as JSON |
//! | `page.html`, `page.css`, `page.js` | the page |
//! | `pair.rs`, `pair.html`, `pair.js` | the page of two runs |
//! | `common.js` | what both have: colours, axes, curves, fingers |
//!
//! Figures are those of the JSON output: the page has the same object, and the rows of `scans.csv` that its curves show are the same
//! numbers. What is thinned, and how, the page says.

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

/// The page of a run that was filmed; `settings_text` are its settings as a file, with where each is from.
#[must_use]
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

/// The page of two runs, of which both have left one.
///
/// # Errors
/// Names the run without a page: it has no curves.
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

/// Data as a script holds them: plain numbers and texts, which JSON has all. A `<` could end the script.
fn embedded(data: &impl Serialize) -> String {
    serde_json::to_string(data).unwrap_or_default().replace('<', "\\u003c")
}

/// The page with its parts; what stands in a part is never taken for a mark.
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
