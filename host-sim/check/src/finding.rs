//! Findings, and the format of their figures.

use serde::Serialize;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Nothing has to be done.
    Note,
    /// The log can be run, but the result is probably wrong.
    Warning,
    /// The log cannot be read.
    Error,
}

impl Severity {
    pub fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// An observation about a log that its author should know.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    pub severity: Severity,
    /// A name that does not change between releases.
    pub code: &'static str,
    /// File and, if there is one, row, column or key.
    pub place: String,
    /// The observation, with its figures.
    pub what: String,
    pub advice: String,
}

/// The findings in the order in which they were added.
#[derive(Debug, Default)]
pub(super) struct Findings(pub(super) Vec<Finding>);

impl Findings {
    pub(super) fn add(
        &mut self,
        severity: Severity,
        code: &'static str,
        place: impl Into<String>,
        what: String,
        advice: impl Into<String>,
    ) {
        self.0.push(Finding { severity, code, place: place.into(), what, advice: advice.into() });
    }

    pub(super) fn warn(&mut self, code: &'static str, place: &str, what: String, advice: impl Into<String>) {
        self.add(Severity::Warning, code, place, what, advice);
    }

    pub(super) fn note(&mut self, code: &'static str, place: &str, what: String, advice: impl Into<String>) {
        self.add(Severity::Note, code, place, what, advice);
    }
}

/// Motion from a time on, for any vehicle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    pub(super) t_s: f64,
    /// Absolute value, m/s; `None` if it was not measured.
    pub(super) speed_mps: Option<f64>,
    pub(super) turn_radps: f64,
}

/// Quantile of the numbers at this share; `None` for an empty list.
pub(super) fn quantile(mut numbers: Vec<f64>, share: f64) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    let last = numbers.len().checked_sub(1)?;
    numbers.get(((last as f64) * share).round() as usize).copied()
}

/// A number with three significant digits.
pub(super) fn short(number: f64) -> String {
    let size = if number == 0.0 { 0.0 } else { number.abs().log10().floor() };
    if !(-4.0..6.0).contains(&size) {
        return format!("{number:.2e}");
    }
    format!("{number:.*}", (2.0 - size).max(0.0) as usize)
}

pub(super) fn percent(share: f64) -> String {
    format!("{} %", short(100.0 * share))
}
