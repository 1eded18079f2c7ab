//! How a step ends. What is not there to check with is one thing, what was checked and does not hold is another.

/// How a step ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// Everything it names was checked and held; the note adds what a reader of the summary should know.
    Passed(String),
    /// What was checked held, but something was not checked, for this reason.
    Partly(String),
    /// Nothing was checked, for this reason.
    Skipped(String),
    /// For this reason.
    Failed(String),
}

/// What a step needs is neither here nor to be had.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing(pub String);

/// Why a step did not come to its end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Stop {
    /// It could not be done here.
    Missing(String),
    /// Something is wrong.
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

/// How many steps ended how.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    pub passed: usize,
    /// Steps of which something was not checked.
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

    /// Whether the run as a whole is good; a `strict` one has to check everything.
    pub fn is_good(self, strict: bool) -> bool {
        self.failed == 0 && (!strict || self.skipped == 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_a_skip_and_what_is_broken_a_failure() {
        let missing: Result<(), Stop> = Err(Missing("no emulator".into()).into());
        assert_eq!(Outcome::from(missing), Outcome::Skipped("no emulator".into()));
        let broken: Result<(), Stop> = Err("it differs".into());
        assert_eq!(Outcome::from(broken), Outcome::Failed("it differs".into()));
        assert_eq!(Outcome::from(Ok::<(), Stop>(())), Outcome::Passed(String::new()));
    }

    #[test]
    fn only_a_strict_run_minds_a_skip() {
        let note = String::new;
        let outcomes = [Outcome::Passed(note()), Outcome::Partly(note()), Outcome::Skipped(note())];
        let tally = Tally::of(outcomes.iter());
        assert_eq!(tally, Tally { passed: 1, skipped: 2, failed: 0 });
        assert!(tally.is_good(false) && !tally.is_good(true));
        assert!(!Tally { failed: 1, ..tally }.is_good(false));
        assert!(Tally { passed: 3, ..Tally::default() }.is_good(true));
    }
}
