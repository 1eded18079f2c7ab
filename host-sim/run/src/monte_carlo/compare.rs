//! Comparison of two filters over the same inputs.

use super::run::{Curve, RunResult};
use super::statistics::{mean, whole};
use super::study::Study;
use std::fmt;

/// Comparison of two filters, run by run; only runs in which both have the figure count.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    pub filter: String,
    /// The filter that it is compared with.
    pub against: String,
    /// By the mean position error of a run.
    pub position: Option<Versus>,
    /// By the mean map error (OSPA, order 1, cut-off 10 m) of a run.
    pub map: Option<Versus>,
}

/// One figure of two filters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Versus {
    pub runs: usize,
    /// Number of runs in which the filter's figure is smaller.
    pub better: usize,
    /// Mean of the filter's figure divided by that of the other.
    pub ratio: f64,
}

impl Versus {
    fn of(filter: &[&RunResult], against: &[&RunResult], curve: Curve) -> Option<Self> {
        let pairs: Vec<(f64, f64)> = filter
            .iter()
            .filter_map(|result| {
                let other = against.iter().find(|other| other.run == result.run)?;
                whole(result.series.curve(curve)).zip(whole(other.series.curve(curve)))
            })
            .collect();
        Some(Self {
            runs: pairs.len(),
            better: pairs.iter().filter(|(own, other)| own < other).count(),
            ratio: mean(pairs.iter().map(|pair| pair.0))? / mean(pairs.iter().map(|pair| pair.1))?,
        })
    }
}

/// Compares the study's first filter with each other one.
pub fn comparisons(study: &Study) -> Vec<Comparison> {
    let Some((first, others)) = study.plan.filters.split_first() else { return Vec::new() };
    let results = study.of_filter(first);
    let against = |other: &String| {
        let theirs = study.of_filter(other);
        Comparison {
            filter: first.clone(),
            against: other.clone(),
            position: Versus::of(&results, &theirs, Curve::PositionError),
            map: Versus::of(&results, &theirs, Curve::OspaFar),
        }
    };
    others.iter().map(against).collect()
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut lines = Vec::new();
        for (figure, versus) in [("position error", self.position), ("map error (OSPA)", self.map)] {
            if let Some(Versus { runs, better, ratio }) = versus {
                lines.push(format!(
                    "{figure}: {} better than {} in {better} of {runs} runs, ratio of means {ratio:.3}",
                    self.filter, self.against
                ));
            }
        }
        f.write_str(&lines.join("\n"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monte_carlo::made_up::{plan, result};

    #[test]
    fn better_runs_are_counted_and_the_ratio_is_of_the_means() {
        let plan = plan(2, 2);
        let mut results: Vec<RunResult> = (0..2).map(|run| result(&plan.job(run), "scphd", 0.0)).collect();
        results.extend((0..2).map(|run| result(&plan.job(run), "rb-single", if run == 0 { 1.0 } else { -0.5 })));
        let comparison = &comparisons(&Study { plan, results })[0];
        // Means of 1 and 1.1, compared with 2 and 0.6.
        let versus = comparison.position.unwrap();
        assert_eq!((versus.runs, versus.better), (2, 1));
        assert!((versus.ratio - 2.1 / 2.6).abs() < 1e-12);
        assert_eq!((&comparison.filter[..], &comparison.against[..]), ("scphd", "rb-single"));
    }
}
