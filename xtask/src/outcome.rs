//! Outcomes of steps, which distinguish missing tools from failed checks.

/// Outcome of a step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// All checks passed; the note is for the summary.
    Passed(String),
    /// All checks that were possible passed, but some were not possible, for this reason.
    Partly(String),
    /// No check was possible, for this reason.
    Skipped(String),
    /// A check failed, for this reason.
    Failed(String),
}

/// A requirement of a step is missing and cannot be obtained.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing(pub String);

/// Reason why a step ended early.
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

impl From<Stop> for Outcome {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::Missing(reason) => Self::Skipped(reason),
            Stop::Broken(reason) => Self::Failed(reason),
        }
    }
}

impl<E: Into<Stop>> From<Result<Outcome, E>> for Outcome {
    fn from(result: Result<Outcome, E>) -> Self {
        result.unwrap_or_else(|stop| stop.into().into())
    }
}

impl<E: Into<Stop>> From<Result<(), E>> for Outcome {
    fn from(result: Result<(), E>) -> Self {
        result.map(|()| Self::Passed(String::new())).into()
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
    pub fn of<'a>(outcomes: impl Iterator<Item = &'a Outcome>) -> Self {
        let mut tally = Self::default();
        for outcome in outcomes {
            match outcome {
                Outcome::Passed(_) => tally.passed += 1,
                Outcome::Partly(_) | Outcome::Skipped(_) => tally.skipped += 1,
                Outcome::Failed(_) => tally.failed += 1,
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
    fn missing_requirements_are_skips_and_failed_checks_are_failures() {
        let missing: Result<(), Stop> = Err(Missing("no emulator".into()).into());
        assert_eq!(Outcome::from(missing), Outcome::Skipped("no emulator".into()));
        let broken: Result<(), Stop> = Err("it differs".into());
        assert_eq!(Outcome::from(broken), Outcome::Failed("it differs".into()));
        assert_eq!(Outcome::from(Ok::<(), Stop>(())), Outcome::Passed(String::new()));
    }

    #[test]
    fn only_a_strict_run_fails_on_a_skip() {
        let note = String::new;
        let outcomes = [Outcome::Passed(note()), Outcome::Partly(note()), Outcome::Skipped(note())];
        let tally = Tally::of(outcomes.iter());
        assert_eq!(tally, Tally { passed: 1, skipped: 2, failed: 0 });
        assert!(tally.is_good(false) && !tally.is_good(true));
        assert!(!Tally { failed: 1, ..tally }.is_good(false));
        assert!(Tally { passed: 3, ..Tally::default() }.is_good(true));
    }
}
