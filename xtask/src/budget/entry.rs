//! An entry of `budgets.toml`.

use crate::firmware::rig::{Precision, Rig};
use crate::firmware::streams::Source;
use serde::Deserialize;

/// The scenario with the greatest cost of a scan: every page in use, every gate open, the maximum number of
/// measurements.
pub const WORST_CASE: &str = "worst-case";
/// The scenario of faults. None of its scans may take longer than the worst case.
pub const FAULTS: &str = "faults";

/// A configuration and scenario to measure, and its limits.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    pub board: String,
    pub configuration: String,
    pub scenario: String,
    pub scans: usize,
    pub flash_bytes: u64,
    pub library_flash_bytes: u64,
    pub state_bytes: u64,
    pub stack_bytes: u64,
    pub instructions_per_predict_worst: u64,
    pub instructions_per_scan_mean: u64,
    pub instructions_per_scan_worst: u64,
}

impl Budget {
    /// The stream to replay, and the number type in the name of the configuration.
    pub fn source(&self) -> Result<(Source<'_>, Precision), String> {
        let Self { scenario: what, configuration, scans, .. } = self;
        let (rig, precision) = Rig::named(configuration, what)
            .ok_or_else(|| format!("budgets.toml: no configuration `{configuration}` of {what}"))?;
        Ok((Source { what, scans: *scans, rig }, precision))
    }

    pub fn what(&self) -> String {
        format!("{} {} {}", self.board, self.configuration, self.scenario)
    }
}
