//! A study with the results of its runs.

use super::plan::Plan;
use super::run::RunResult;

/// A study with its finished runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// The definition of the whole study.
    pub plan: Plan,
    /// The results, by filter in the plan's order, then by run.
    pub results: Vec<RunResult>,
}

impl Study {
    /// The runs of one filter, in order.
    pub fn of_filter(&self, filter: &str) -> Vec<&RunResult> {
        self.results.iter().filter(|result| result.filter == filter).collect()
    }
}
