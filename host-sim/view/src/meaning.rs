//! Meanings of figures and conditions, from the tables of the documentation, so that a page has the same text.

use serde::Serialize;

/// Columns `key` and `meaning` of a run.
const RESULTS: &str = include_str!("../../../docs/results.md");
/// Columns `condition`, `cause` and `what to do`.
const HEALTH: &str = include_str!("../../../docs/health.md");

#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(crate) struct Condition {
    pub(crate) cause: String,
    pub(crate) action: String,
}

/// The meaning of every key of a run, in order.
pub(crate) fn of_figures() -> Vec<(String, String)> {
    let section = RESULTS.split("\n## ").find(|section| section.starts_with("A run\n")).unwrap_or_default();
    let row = |line: &str| {
        let (key, meaning) = line.strip_prefix("| `")?.split_once("` | ")?;
        Some((key.to_owned(), plain(meaning.strip_suffix(" |")?)))
    };
    section.lines().filter_map(row).collect()
}

/// The cause of a condition, and what to do.
pub(crate) fn of_condition(name: &str) -> Option<Condition> {
    let mark = format!("| `{name}` | ");
    let row = HEALTH.lines().find(|line| line.contains(&mark))?;
    let (cause, action) = row.split_once(&mark)?.1.strip_suffix(" |")?.split_once(" | ")?;
    Some(Condition { cause: plain(cause), action: plain(action) })
}

/// A cell without markup: a link becomes its text.
fn plain(cell: &str) -> String {
    let mut text = String::new();
    let mut rest = cell;
    while let Some((before, after)) = rest.split_once('[') {
        text += before;
        match after.split_once("](").and_then(|(words, link)| Some((words, link.split_once(')')?.1))) {
            Some((words, behind)) => {
                text += words;
                rest = behind;
            }
            None => {
                text.push('[');
                rest = after;
            }
        }
    }
    (text + rest).replace('`', "")
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd::Health;
    use scphd_run::session::condition_name;

    #[test]
    fn every_condition_and_every_figure_has_its_meaning() {
        for condition in Health::all() {
            let name = condition_name(condition);
            let meaning = of_condition(&name).unwrap_or_else(|| panic!("{name} is not in docs/health.md"));
            assert!(!meaning.cause.is_empty() && !meaning.action.is_empty(), "{name}");
        }
        let figures = of_figures();
        assert!(figures.iter().any(|(key, _)| key == "position_rmse_m") && figures.len() > 40, "{}", figures.len());
    }

    #[test]
    fn links_become_their_text() {
        assert_eq!(
            plain("more `pages` ([choosing.md](choosing.md)), of [x] too"),
            "more pages (choosing.md), of [x] too"
        );
    }
}
