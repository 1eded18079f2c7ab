//! A study with the results of its runs.

use super::plan::Plan;
use super::run::RunResult;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;

/// A study with its finished runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// The definition of the whole study.
    pub plan: Plan,
    /// The results, by filter in the plan's order, then by run.
    pub results: Vec<RunResult>,
}

/// Why parts cannot be merged; displays as one line.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    #[error("no study")]
    Nothing,
    #[error("part {0} is of another study")]
    Other(usize),
    #[error("run {run} by {filter} is there twice")]
    Twice { run: usize, filter: String },
    #[error("run {run} by {filter} is not of the study")]
    Stray { run: usize, filter: String },
    #[error("run {run} by {filter} is missing")]
    Missing { run: usize, filter: String },
}

impl Study {
    /// Merges the shards of a study, in any order.
    ///
    /// # Errors
    /// Parts are of different studies, or a run is missing or there twice.
    pub fn merge(parts: Vec<Self>) -> Result<Self, MergeError> {
        let plan = parts.first().ok_or(MergeError::Nothing)?.plan.clone();
        if let Some(place) = parts.iter().position(|part| part.plan != plan) {
            return Err(MergeError::Other(place + 1));
        }
        let mut done: Vec<RunResult> = parts.into_iter().flat_map(|part| part.results).collect();
        let mut seen = HashSet::new();
        if let Some(again) = done.iter().find(|result| !seen.insert((result.run, &result.filter))) {
            return Err(MergeError::Twice { run: again.run, filter: again.filter.clone() });
        }
        let mut results = Vec::with_capacity(done.len());
        for filter in &plan.filters {
            for run in 0..plan.runs {
                let found = done.iter().position(|result| result.run == run && result.filter == *filter);
                let result = found.map(|place| done.swap_remove(place));
                results.push(result.ok_or_else(|| MergeError::Missing { run, filter: filter.clone() })?);
            }
        }
        if let Some(RunResult { run, filter, .. }) = done.pop() {
            return Err(MergeError::Stray { run, filter });
        }
        Ok(Self { plan, results })
    }

    /// The runs of one filter, in order.
    pub fn of_filter(&self, filter: &str) -> Vec<&RunResult> {
        self.results.iter().filter(|result| result.filter == filter).collect()
    }
}
