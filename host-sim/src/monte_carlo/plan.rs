//! Which runs a study has, and which of them are done.

use super::run::RunResult;
use crate::output::json::Format;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::str::FromStr;

/// What a study is, before any run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The format of the file that it is written to.
    pub format: Format,
    /// Name of the scenario, or of the logs.
    pub scenario: String,
    /// The filters, which all get the same inputs and seeds.
    pub filters: Vec<String>,
    /// Runs of each filter.
    pub runs: usize,
    /// Different inputs; divides the runs.
    pub input_sets: usize,
    /// Added to all seeds.
    pub seed: u64,
    /// Settings of the first input, so that parts made with others are told.
    pub settings: String,
    /// Settings of each filter for the first input, where they differ in more than the likelihood.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub variants: Vec<String>,
}

/// One run of a study, apart from the filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Job {
    /// Which run, from 0.
    pub run: usize,
    /// Which input set, from 0.
    pub input: usize,
    /// Seed of the scenario.
    pub scenario_seed: u64,
    /// Seed of the filter.
    pub filter_seed: u64,
}

/// Part `place` (from 1) of `of`: every run whose number leaves the remainder `place` − 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Which part, 1 … `of`.
    pub place: usize,
    /// Number of parts.
    pub of: usize,
}

impl FromStr for Shard {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let numbers = text.split_once('/').and_then(|(place, of)| Some((place.parse().ok()?, of.parse().ok()?)));
        match numbers {
            Some((place, of)) if (1..=of).contains(&place) => Ok(Self { place, of }),
            _ => Err("must be K/N with K from 1 to N"),
        }
    }
}

impl Plan {
    /// Run number `run`.
    #[must_use]
    pub fn job(&self, run: usize) -> Job {
        let input = run / (self.runs / self.input_sets.max(1)).max(1);
        Job {
            run,
            input,
            scenario_seed: self.seed.wrapping_add(input as u64),
            filter_seed: self.seed.wrapping_add(run as u64),
        }
    }

    /// All runs, or those of one part.
    #[must_use]
    pub fn jobs(&self, shard: Option<Shard>) -> Vec<Job> {
        let Shard { place, of } = shard.unwrap_or(Shard { place: 1, of: 1 });
        (place - 1..self.runs).step_by(of).map(|run| self.job(run)).collect()
    }
}

/// A study with the runs that are done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// All of it.
    pub plan: Plan,
    /// What is done, by filter in the plan's order, then by run.
    pub results: Vec<RunResult>,
}

/// Why parts do not make a study; displays as one line.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// Nothing to merge.
    #[error("no study")]
    Nothing,
    /// Another plan than the first part's.
    #[error("part {0} is of another study")]
    Other(usize),
    /// A run is in two parts.
    #[error("run {run} by {filter} is there twice")]
    Twice {
        /// Number of the run.
        run: usize,
        /// Its filter.
        filter: String,
    },
    /// A run that the plan does not have.
    #[error("run {run} by {filter} is not of the study")]
    Stray {
        /// Number of the run.
        run: usize,
        /// Its filter.
        filter: String,
    },
    /// A run is in no part.
    #[error("run {run} by {filter} is missing")]
    Missing {
        /// Number of the run.
        run: usize,
        /// Its filter.
        filter: String,
    },
}

impl Study {
    /// The study that `parts` are the shards of, in any order.
    ///
    /// # Errors
    /// Parts of different studies, a run twice or not at all.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monte_carlo::tests::plan;

    #[test]
    fn seeds_follow_from_the_number_of_the_run() {
        let plan = plan(100, 25);
        assert_eq!(plan.job(0), Job { run: 0, input: 0, scenario_seed: 5, filter_seed: 5 });
        assert_eq!(plan.job(7), Job { run: 7, input: 1, scenario_seed: 6, filter_seed: 12 });
        assert_eq!(plan.job(99), Job { run: 99, input: 24, scenario_seed: 29, filter_seed: 104 });
        let runs = |place| plan.jobs(Some(Shard { place, of: 30 })).iter().map(|job| job.run).collect::<Vec<_>>();
        assert_eq!((runs(1), runs(30)), (vec![0, 30, 60, 90], vec![29, 59, 89]));
    }

    #[test]
    fn parts_are_written_as_fractions() {
        assert_eq!("2/5".parse(), Ok(Shard { place: 2, of: 5 }));
        for bad in ["0/5", "6/5", "1", "a/b", "1/0", "-1/3"] {
            assert!(bad.parse::<Shard>().is_err(), "{bad}");
        }
    }
}
