//! Runs of a study.

use scphd_score::results::json::Format;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// Definition of a study, before any run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    pub format: Format,
    /// Name of the scenario, or of the logs.
    pub scenario: String,
    /// The filters, which all get the same inputs and seeds.
    pub filters: Vec<String>,
    /// Number of runs of each filter.
    pub runs: usize,
    /// Number of different inputs; divides the number of runs.
    pub input_sets: usize,
    /// Added to all seeds.
    pub seed: u64,
    /// Settings with the first input; parts with other settings are recognised by them.
    pub settings: String,
    /// Settings of each filter with the first input, if they differ in more than the likelihood.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub variants: Vec<String>,
}

/// One run of a study, without the filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Job {
    /// Number of the run, from 0.
    pub run: usize,
    /// Number of the input set, from 0.
    pub input: usize,
    pub scenario_seed: u64,
    pub filter_seed: u64,
}

/// Part `place` (from 1) of `of`: the runs whose number modulo `of` is `place` − 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Number of the part, 1 … `of`.
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
    pub fn jobs(&self, shard: Option<Shard>) -> Vec<Job> {
        let Shard { place, of } = shard.unwrap_or(Shard { place: 1, of: 1 });
        (place - 1..self.runs).step_by(of).map(|run| self.job(run)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monte_carlo::made_up::plan;

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
