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
}

/// A requirement of a step is missing and cannot be obtained.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing(pub String);

/// Reason why a step ended early: it is skipped, or it failed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Stop {
    /// A requirement is missing.
    Missing(String),
    /// A check failed.
    Broken(String),
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

/// Numbers of steps by outcome.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    pub passed: usize,
    /// Steps with checks that were not possible.
    pub skipped: usize,
    pub failed: usize,
}

impl Tally {
    /// Counts the outcomes.
    pub fn of<'a>(outcomes: impl Iterator<Item = &'a Result<Outcome, Stop>>) -> Self {
        let mut tally = Self::default();
        for outcome in outcomes {
            match outcome {
                Ok(Outcome::Passed(_)) => tally.passed += 1,
                Ok(Outcome::Partly(_)) | Err(Stop::Missing(_)) => tally.skipped += 1,
                Err(Stop::Broken(_)) => tally.failed += 1,
            }
        }
        tally
    }

    /// Whether the whole run is successful; a `strict` run requires that everything was checked.
    pub fn is_good(self, strict: bool) -> bool {
        self.failed == 0 && (!strict || self.skipped == 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_strict_run_fails_on_a_skip() {
        let missing = Missing("no emulator".into()).into();
        let outcomes = [Ok(Outcome::PASSED), Ok(Outcome::Partly("no logs".into())), Err(missing)];
        let tally = Tally::of(outcomes.iter());
        assert_eq!(tally, Tally { passed: 1, skipped: 2, failed: 0 });
        assert_eq!(Tally::of([Err("it differs".into())].iter()), Tally { failed: 1, ..Tally::default() });
        assert!(tally.is_good(false) && !tally.is_good(true));
        assert!(!Tally { failed: 1, ..tally }.is_good(false));
        assert!(Tally { passed: 3, ..Tally::default() }.is_good(true));
    }
}
