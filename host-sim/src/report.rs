//! A run as one page that needs nothing else: no network, no program but a browser.
//!
//! What is kept of a run while it goes on is a [`Film`].
//!
//! | file | |
//! |---|---|
//! | `data.rs` | the data of a page, as JSON |
//! | `meaning.rs` | what figures and conditions mean, from the documentation |
//! | `page.html`, `page.css`, `page.js` | the page |
//!
//! Figures are those of the JSON output: the page has the same object, and the rows of `scans.csv` that its curves show are the same
//! numbers. What is thinned, and how, the page says.

mod data;
mod meaning;

use crate::film::Film;
use crate::kind::Kind;
use crate::session::Session;

const PAGE: &str = include_str!("report/page.html");
const STYLE: &str = include_str!("report/page.css");
const SCRIPT: &str = include_str!("report/page.js");

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
    // Plain numbers and texts, which JSON has all. A `<` could end the script that holds them.
    let json = serde_json::to_string(&data).unwrap_or_default().replace('<', "\\u003c");
    let title = format!("{}: {} {}", session.summary.log, session.summary.filter, session.summary.precision);
    filled(&[("title", &escaped(&title)), ("style", STYLE), ("script", SCRIPT), ("data", &json)])
}

/// The page with its parts; what stands in a part is never taken for a mark.
fn filled(parts: &[(&str, &str)]) -> String {
    let mut pieces = PAGE.split("{{");
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
