//! Outcomes of steps, which distinguish missing tools from failed checks.

/// Outcome of a step that came to its end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// All checks passed; the note is for the summary.
    Passed(String),
    /// All checks that were possible passed, but some were not possible, for this reason.
    Partly(String),
}

impl Outcome {
    /// All checks passed, of which there is nothing to say.
    pub const PASSED: Self = Self::Passed(String::new());

    /// All checks passed, except those that this leaves out.
    pub fn without(missing: &str, note: String) -> Self {
        if missing.is_empty() { Self::Passed(note) } else { Self::Partly(format!("{note}; NOT CHECKED: {missing}")) }
    }
}

/// A requirement of a step is missing and cannot be obtained.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing(pub String);

/// Reason why a step ended early: it is skipped, or it failed.
pub enum Stop {
    Missing(String),
    Broken(String),
}

impl From<Missing> for String {
    fn from(Missing(reason): Missing) -> Self {
        reason
    }
}

impl From<Missing> for Stop {
    fn from(Missing(reason): Missing) -> Self {
        Self::Missing(reason)
    }
}

impl From<String> for Stop {
    fn from(reason: String) -> Self {
        Self::Broken(reason)
    }
}

impl From<&str> for Stop {
    fn from(reason: &str) -> Self {
        Self::Broken(reason.to_owned())
    }
}
