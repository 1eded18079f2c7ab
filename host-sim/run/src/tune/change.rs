//! Changes of settings by field names.

use scphd_filters::settings::FileProblem;
use scphd_filters::settings::file::{laid_over, lookup};
use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

/// Fields that change in proportion to clutter, if present.
pub(super) const BIRTHS: &[&str] = &["filter.birth_intensity", "moving.birth_intensity"];

/// A field and its new value.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// `section.field`.
    pub field: &'static str,
    pub value: Value,
}

impl Change {
    pub fn new(field: &'static str, value: f64) -> Self {
        Self { field, value: Value::Float(value) }
    }

    /// The size of the value, as in [`Said::now`].
    pub fn size(&self) -> Option<f64> {
        size(&self.value)
    }
}

/// The result of learning for a field.
#[derive(Debug, Clone, PartialEq)]
pub struct Said {
    /// `section.field`.
    pub field: &'static str,
    /// The present value; of several numbers, their root mean square.
    pub now: f64,
    /// The learnt value; `None` with too few observations.
    pub to: Option<f64>,
    /// Whether a bound limited the value.
    pub clamped: bool,
    /// Number of innovations, corrections or measurements.
    pub observations: usize,
}

/// Fields that are proposed together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    Odometry,
    Noise,
    /// p_D.
    Detection,
    /// λ, and births in proportion.
    Clutter,
    Sensor,
    Together,
}

impl Group {
    pub fn name(self) -> &'static str {
        match self {
            Self::Odometry => "odometry",
            Self::Noise => "noise",
            Self::Detection => "detection",
            Self::Clutter => "clutter",
            Self::Sensor => "noise, detection, clutter",
            Self::Together => "together",
        }
    }
}

/// Candidate settings.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The group that changes.
    pub group: Group,
    /// A short description of their origin.
    pub how: String,
    /// The changes; at least one.
    pub changes: Vec<Change>,
}

/// The size of a field's value, as in [`Said::now`]; `None` if the settings do not have the field.
pub(super) fn size_of<S: Serialize>(settings: &S, field: &str) -> Option<f64> {
    size(lookup(&Table::try_from(settings).ok()?, field)?)
}

fn size(value: &Value) -> Option<f64> {
    let Value::Array(numbers) = value else { return value.as_float() };
    let squares: Option<f64> = numbers.iter().map(|number| Some(number.as_float()?.powi(2))).sum();
    Some((squares? / numbers.len() as f64).sqrt())
}

/// Applies changes to `settings`.
pub(super) fn changed<S: Serialize + DeserializeOwned>(settings: &S, changes: &[Change]) -> Result<S, FileProblem> {
    let mut over = Table::new();
    for Change { field, value } in changes {
        let (section, key) = field.split_once('.').unwrap_or((field, ""));
        let section = over.entry(section).or_insert_with(|| Value::Table(Table::new()));
        if let Value::Table(section) = section {
            section.insert(key.to_owned(), value.clone());
        }
    }
    laid_over(settings, over)
}

/// Changes of `fields` by a factor; fields that are 0 or missing are left out.
pub(super) fn scaled<S: Serialize>(settings: &S, fields: &[&'static str], factor: f64) -> Vec<Change> {
    let table = Table::try_from(settings).unwrap_or_default();
    let change = |&field| {
        let value = lookup(&table, field)?;
        size(value).filter(|&size| size != 0.0)?;
        let times = |value: &Value| value.as_float().map(|number| Value::Float(factor * number));
        let value = match value {
            Value::Array(numbers) => Value::Array(numbers.iter().filter_map(times).collect()),
            number => times(number)?,
        };
        Some(Change { field, value })
    };
    fields.iter().filter_map(change).collect()
}
