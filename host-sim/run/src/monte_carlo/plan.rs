//! Runs of a study.

/// Definition of a study, before any run.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Name of the scenario, or of the logs.
    pub scenario: String,
    /// The filters, which all get the same inputs and seeds.
    pub filters: Vec<String>,
    pub runs: usize,
    /// Number of different inputs; divides the number of runs.
    pub input_sets: usize,
    /// Added to all seeds.
    pub seed: u64,
    /// Settings with the first input.
    pub settings: String,
    /// Settings of each filter with the first input, if they differ in more than the likelihood.
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

    /// All runs.
    pub fn jobs(&self) -> Vec<Job> {
        (0..self.runs).map(|run| self.job(run)).collect()
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
    }
}
