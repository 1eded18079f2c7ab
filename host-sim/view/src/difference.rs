//! Comparison of two runs: differences of their settings and of their figures.

use crate::meaning;
use scphd_score::results::json::Format;
use serde::Serialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The element of a page with its data.
const BEGIN: &str = "<script type=\"application/json\" id=\"data\">";
const END: &str = "</script>";

/// The output of a run: its page, or its JSON file.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    name: String,
    summary: Map<String, Value>,
    /// The data of the page, if it is one.
    page: Option<Value>,
}

/// The comparison of two runs. Serialised with exactly these keys in this order.
/// `docs/results.md` defines the keys.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    pub format: Format,
    pub runs: [String; 2],
    pub other_inputs: Vec<String>,
    pub settings: Vec<Setting>,
    pub figures: Vec<Figure>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Setting {
    pub setting: String,
    pub a: Value,
    pub b: Value,
}

/// A figure of both runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    pub key: String,
    pub a: Value,
    pub b: Value,
    pub difference: Option<f64>,
}

impl Written {
    /// Reads a page of `--html`, or a file of `--json` of a single run.
    ///
    /// # Errors
    /// The reason in one line.
    pub fn read(path: &Path) -> Result<Self, String> {
        let name = path.display().to_string();
        let text = fs::read_to_string(path).map_err(|error| format!("{name}: {error}"))?;
        Self::of(name, &text)
    }

    fn of(name: String, text: &str) -> Result<Self, String> {
        let said = |what: &str| format!("{name}: {what}");
        let neither = "neither a page of --html nor the JSON output of a run";
        let parsed =
            |json: &str| serde_json::from_str::<Value>(json).map_err(|error| said(&format!("{neither}: {error}")));
        let page = match text.split_once(BEGIN) {
            None => None,
            Some((_, rest)) => Some(parsed(rest.split_once(END).map_or(rest, |(data, _)| data))?),
        };
        let summary = match &page {
            None => parsed(text)?,
            Some(page) => page.get("summary").cloned().ok_or_else(|| said("a page, but not one of a run"))?,
        };
        let summary = match summary {
            Value::Object(summary) => summary,
            Value::Array(runs) => {
                return Err(said(&format!("a list of {} runs; one run is compared with one", runs.len())));
            }
            _ => return Err(said(neither)),
        };
        let format = summary.get("format").cloned().ok_or_else(|| said(neither))?;
        serde_json::from_value::<Format>(format).map_err(|error| said(&error.to_string()))?;
        if !(summary.get("settings").is_some_and(Value::is_object) && summary.get("log").is_some_and(Value::is_string))
        {
            return Err(said("JSON of this program, but not of a run"));
        }
        Ok(Self { name, summary, page })
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub(crate) fn log(&self) -> &str {
        self.summary.get("log").and_then(Value::as_str).unwrap_or_default()
    }

    pub(crate) fn page(&self) -> Option<&Value> {
        self.page.as_ref()
    }

    /// A curve by scan.
    fn by_scan(&self, key: &str) -> BTreeMap<u64, &Value> {
        let list = |key: &str| self.page.as_ref().and_then(|page| page["series"][key].as_array());
        let (Some(scans), Some(values)) = (list("scan"), list(key)) else { return BTreeMap::new() };
        scans.iter().filter_map(Value::as_u64).zip(values).collect()
    }
}

impl Difference {
    pub fn of([a, b]: [&Written; 2]) -> Self {
        let (mut of_a, mut of_b) = (BTreeMap::new(), BTreeMap::new());
        flatten("", &a.summary["settings"], &mut of_a);
        flatten("", &b.summary["settings"], &mut of_b);
        let mut names: Vec<&String> = of_a.keys().chain(of_b.keys()).collect();
        names.sort_unstable();
        names.dedup();
        let value = |of: &BTreeMap<String, Value>, name: &String| of.get(name).cloned().unwrap_or_default();
        let settings = names
            .into_iter()
            .map(|name| Setting { setting: name.clone(), a: value(&of_a, name), b: value(&of_b, name) })
            .filter(|setting| setting.a != setting.b)
            .collect();
        let known = |run: &Written, key: &str| run.summary.get(key).cloned().unwrap_or_default();
        // In the order of the documentation, which has all figures.
        let figures = meaning::of_figures()
            .into_iter()
            .map(|(key, _)| key)
            .filter(|key| !matches!(key.as_str(), "format" | "log" | "settings"))
            .map(|key| {
                let (a, b) = (known(a, &key), known(b, &key));
                // Seeds are not quantities.
                let numbers = a.as_f64().zip(b.as_f64()).filter(|_| key != "seed");
                Figure { difference: numbers.map(|(a, b)| b - a), key, a, b }
            })
            .filter(|figure| !(figure.a.is_null() && figure.b.is_null()))
            .collect();
        Self {
            format: Format,
            runs: [a, b].map(|run| run.name.clone()),
            other_inputs: other_inputs(a, b),
            settings,
            figures,
        }
    }
}

/// Reasons why two runs do not have the same inputs: names and counts for JSON files; for pages also times, truth and
/// measurements.
fn other_inputs(a: &Written, b: &Written) -> Vec<String> {
    let mut reasons = Vec::new();
    for key in ["log", "scans"] {
        let [of_a, of_b] = [a, b].map(|run| run.summary.get(key).cloned().unwrap_or_default());
        if of_a != of_b {
            reasons.push(format!("{key}: {} and {}", plain(&of_a), plain(&of_b)));
        }
    }
    if !reasons.is_empty() {
        return reasons;
    }
    for (key, what) in [("t_s", "times"), ("truth", "true positions"), ("measurements", "numbers of measurements")] {
        let (of_a, of_b) = (a.by_scan(key), b.by_scan(key));
        let other = of_a.iter().find(|(scan, value)| of_b.get(scan).is_some_and(|other| other != *value));
        if let Some((scan, _)) = other {
            reasons.push(format!("{what} differ, first at scan {scan}"));
        }
    }
    reasons
}

/// Settings by `section.name`.
fn flatten(prefix: &str, value: &Value, into: &mut BTreeMap<String, Value>) {
    let inner = |name: &str| if prefix.is_empty() { name.to_owned() } else { format!("{prefix}.{name}") };
    match value {
        Value::Object(fields) => fields.iter().for_each(|(name, value)| flatten(&inner(name), value, into)),
        Value::Array(items) if items.iter().any(Value::is_object) => {
            items.iter().enumerate().for_each(|(place, value)| flatten(&inner(&place.to_string()), value, into));
        }
        other => drop(into.insert(prefix.to_owned(), other.clone())),
    }
}

pub fn plain(value: &Value) -> String {
    match value {
        Value::Null => "-".into(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(log: &str, rmse: f64, sigma: f64) -> String {
        format!(
            r#"{{"format":2,"log":"{log}","filter":"scphd","seed":1,"scans":3,"position_rmse_m":{rmse},"ospa_m":null,
               "settings":{{"sensor":{{"range_sigma_m":{sigma}}},"filter":{{"particles":4}}}}}}"#
        )
    }

    fn written(text: &str) -> Written {
        Written::of("x".into(), text).unwrap()
    }

    #[test]
    fn differences_are_listed() {
        let (a, b) = (written(&run("circle", 1.5, 0.1)), written(&run("circle", 1.0, 0.2)));
        let difference = Difference::of([&a, &b]);
        assert_eq!(difference.other_inputs, Vec::<String>::new());
        let settings: Vec<&str> = difference.settings.iter().map(|setting| &*setting.setting).collect();
        assert_eq!(settings, ["sensor.range_sigma_m"]);
        let figure = |key: &str| difference.figures.iter().find(|figure| figure.key == key);
        assert_eq!(figure("position_rmse_m").unwrap().difference, Some(-0.5));
        assert_eq!(figure("seed").unwrap().difference, None);
        assert!(figure("ospa_m").is_none() && figure("log").is_none() && figure("settings").is_none());
    }

    #[test]
    fn different_logs_are_reported() {
        let (a, b) = (written(&run("circle", 1.0, 0.1)), written(&run("square", 1.0, 0.1)));
        assert_eq!(Difference::of([&a, &b]).other_inputs, ["log: circle and square"]);
    }

    #[test]
    fn a_file_that_is_not_a_run_is_refused() {
        let of = |text: &str| Written::of("x".into(), text).unwrap_err();
        assert!(of("nonsense").contains("neither"));
        assert!(of(&format!("[{0},{0}]", run("circle", 1.0, 0.1))).contains("a list of 2 runs"));
        assert!(of(r#"{"format":1,"log":"x","settings":{}}"#).contains("format 1"));
        assert!(of("{}").contains("neither"));
        assert!(of(r#"{"format":2,"differences":3}"#).contains("not of a run"));
        assert!(of("<html><script type=\"application/json\" id=\"data\">{}</script>").contains("not one of a run"));
    }
}
