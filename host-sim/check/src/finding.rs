//! Findings, and how their figures are told.

use serde::Serialize;

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Read as it is; nothing has to be done.
    Note,
    /// The log can be run, and what comes of it is probably wrong.
    Warning,
    /// The log cannot be read.
    Error,
}

impl Severity {
    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// Something about a log that its author should know.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// A name that stays from release to release.
    pub code: &'static str,
    /// File, and row, column or key where there is one.
    pub place: String,
    /// What is found, with its figures.
    pub what: String,
    /// What to do.
    pub advice: String,
}

/// Findings as they come up.
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

/// Motion in force from a time on, whatever the vehicle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    pub(super) t_s: f64,
    /// Without sign, m/s; `None` where nothing was measured.
    pub(super) speed_mps: Option<f64>,
    pub(super) turn_radps: f64,
}

/// The number that a share of all numbers stays under; `None` of none.
pub(super) fn quantile(mut numbers: Vec<f64>, share: f64) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    let last = numbers.len().checked_sub(1)?;
    numbers.get(((last as f64) * share).round() as usize).copied()
}

/// A number with three digits that count.
pub(super) fn short(number: f64) -> String {
    let size = if number == 0.0 { 0.0 } else { number.abs().log10().floor() };
    if !(-4.0..6.0).contains(&size) {
        return format!("{number:.2e}");
    }
    format!("{number:.*}", (2.0 - size).max(0.0) as usize)
}

/// A share as a percentage.
pub(super) fn percent(share: f64) -> String {
    format!("{} %", short(100.0 * share))
}
