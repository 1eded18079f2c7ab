//! Figures of one entry, from a replay and its image.

use super::entry::{Budget, WORST_CASE};
use crate::firmware::board::Board;
use crate::firmware::image::Sizes;
use crate::firmware::output::{Replay, STAGES, Scan};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::array;

/// Figures of a configuration that follow from its code, without a run.
#[derive(Debug, Clone, Copy)]
pub struct Code {
    /// Sizes of the image that runs.
    pub image: Sizes,
    /// Bound of its stack, bytes.
    pub stack_bound: u64,
    /// Flash of the library in the image that only runs the filter, bytes.
    pub library: u64,
}

/// The figures of one entry of `budgets.toml`.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Figures {
    pub board: String,
    pub core: String,
    pub configuration: String,
    pub scenario: String,
    pub scans: usize,
    pub scans_per_second: f64,
    /// Code and constants of the whole image, with startup code and output.
    pub flash_bytes: u64,
    pub text_bytes: u64,
    pub rodata_bytes: u64,
    /// Code and constants of the library alone, and of the crates that it computes with.
    pub library_flash_bytes: u64,
    /// All RAM of the filter.
    pub state_bytes: u64,
    pub state_parts: Vec<(String, u64)>,
    /// Deepest stack of the run, from the stack paint.
    pub stack_bytes: u64,
    /// Bound of the stack, from the code.
    pub stack_bound_bytes: u64,
    pub instructions_per_predict_mean: u64,
    pub instructions_per_predict_worst: u64,
    pub instructions_per_scan_mean: u64,
    pub instructions_per_scan_p99: u64,
    pub instructions_per_scan_worst: u64,
    #[serde(flatten)]
    pub stages: Stages,
    pub instructions_per_estimate_mean: u64,
    /// A scan with the predictions before it and the estimate after it: the mean and the worst.
    pub instructions_per_cycle_mean: u64,
    pub instructions_per_cycle_worst: u64,
    /// Pairs of a component and a measurement in the costliest scan: upper bounds, from the number in view and from the
    /// capacities.
    pub pairs_in_worst_scan: u64,
    pub pairs_by_capacity: u64,
    /// For the worst case: instructions of the costliest scan per pair, times the number of pairs by capacity.
    pub instructions_per_scan_bound: Option<u64>,
    /// Hash of the state after the last scan.
    pub digest: String,
}

/// Instructions of the stages of a scan, in the order of [`STAGES`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stages {
    pub mean: [u64; STAGES.len()],
    /// The greatest cost of each stage; the scans may differ.
    pub worst: [u64; STAGES.len()],
}

/// Serialised as `instructions_weigh_mean`, `instructions_weigh_worst` and so on.
impl Serialize for Stages {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(2 * STAGES.len()))?;
        for (statistic, values) in [("mean", &self.mean), ("worst", &self.worst)] {
            for (stage, value) in STAGES.iter().zip(values) {
                map.serialize_entry(&format!("instructions_{stage}_{statistic}"), value)?;
            }
        }
        map.end()
    }
}

impl Figures {
    pub fn of(
        budget: &Budget,
        board: &Board,
        code: Code,
        replay: &Replay,
        scan_interval_s: f64,
    ) -> Result<Self, String> {
        let scans = &replay.scans;
        let last = scans.last().ok_or("a replay without a scan")?;
        // A clock that does not advance would be within every limit.
        if !(1.0..=1000.0).contains(&replay.instructions_per_tick) || scans.iter().any(|scan| scan.update == 0) {
            return Err(format!("no instructions were counted on {}", board.name));
        }
        let instructions = |ticks: u64| (ticks as f64 * replay.instructions_per_tick).round() as u64;
        let each = |cost: fn(&Scan) -> u64| -> Vec<u64> { scans.iter().map(|scan| instructions(cost(scan))).collect() };
        let updates = each(|scan| scan.update);
        let cycles = each(|scan| scan.predict + scan.update + scan.estimate);
        let stages: [Vec<u64>; STAGES.len()] =
            array::from_fn(|stage| scans.iter().map(|scan| instructions(scan.stages[stage])).collect());
        let predictions: u64 = scans.iter().map(|scan| scan.predictions).sum();
        let costliest = scans.iter().max_by_key(|scan| scan.update).unwrap_or(last);
        let pairs = replay.capacities.looks() * costliest.in_view * costliest.measurements;
        let most_pairs = replay.capacities.most_pairs();
        Ok(Self {
            board: board.name.into(),
            core: board.core.into(),
            configuration: budget.configuration.clone(),
            scenario: budget.scenario.clone(),
            scans: scans.len(),
            scans_per_second: 1.0 / scan_interval_s,
            flash_bytes: code.image.text + code.image.rodata,
            text_bytes: code.image.text,
            rodata_bytes: code.image.rodata,
            library_flash_bytes: code.library,
            stack_bound_bytes: code.stack_bound,
            state_bytes: replay.ram,
            state_parts: replay.ram_parts.clone(),
            stack_bytes: replay.stack,
            instructions_per_predict_mean: each(|scan| scan.predict).iter().sum::<u64>() / predictions.max(1),
            instructions_per_predict_worst: greatest(&each(|scan| scan.predict_worst)),
            instructions_per_scan_mean: mean(&updates),
            instructions_per_scan_p99: percentile(&updates, 99),
            instructions_per_scan_worst: greatest(&updates),
            stages: Stages {
                mean: stages.each_ref().map(|each| mean(each)),
                worst: stages.each_ref().map(|each| greatest(each)),
            },
            instructions_per_estimate_mean: mean(&each(|scan| scan.estimate)),
            instructions_per_cycle_mean: mean(&cycles),
            instructions_per_cycle_worst: greatest(&cycles),
            pairs_in_worst_scan: pairs,
            pairs_by_capacity: most_pairs,
            instructions_per_scan_bound: (budget.scenario == WORST_CASE)
                .then(|| scaled(instructions(costliest.update), most_pairs, pairs)),
            digest: last.digest.clone(),
        })
    }
}

/// `instructions` for `pairs` pairs, scaled to `most` pairs; never less than `instructions`.
fn scaled(instructions: u64, most: u64, pairs: u64) -> u64 {
    let ratio = (most as f64 / pairs.max(1) as f64).max(1.0);
    (instructions as f64 * ratio).ceil() as u64
}

fn mean(values: &[u64]) -> u64 {
    values.iter().sum::<u64>() / (values.len() as u64).max(1)
}

fn greatest(values: &[u64]) -> u64 {
    values.iter().copied().max().unwrap_or(0)
}

/// The least value that `percent` percent of the values do not exceed.
fn percentile(values: &[u64], percent: usize) -> u64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable();
    let rank = (percent * sorted.len()).div_ceil(100);
    rank.checked_sub(1).and_then(|index| sorted.get(index)).copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_is_never_below_what_was_measured() {
        assert_eq!((scaled(100, 30, 10), scaled(100, 10, 30), scaled(7, 1, 0)), (300, 100, 7));
    }

    #[test]
    fn percentiles_are_ranks() {
        let hundred: Vec<u64> = (1..=100).rev().collect();
        assert_eq!((percentile(&hundred, 99), mean(&hundred), greatest(&hundred)), (99, 50, 100));
        assert_eq!((percentile(&[7], 99), percentile(&[], 99)), (7, 0));
    }
}
