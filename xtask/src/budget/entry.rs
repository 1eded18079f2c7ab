//! An entry of `budgets.toml`.

use serde::Deserialize;

use crate::firmware::precision::Precision;
use crate::firmware::streams::{Source, Variant};

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
    /// The stream to replay.
    pub fn source(&self) -> Source<'_> {
        Source { what: &self.scenario, scans: self.scans, variant: self.variant() }
    }

    fn variant(&self) -> Variant {
        let named = Variant::NAMED.into_iter().filter(|variant| self.configuration.contains(variant.mark()));
        // A mark may be part of another one, so that the longest is taken.
        named.max_by_key(|variant| variant.mark().len()).unwrap_or(Variant::Plain)
    }

    /// The number type in the name of the configuration.
    pub fn precision(&self) -> Result<Precision, String> {
        let rig = self.source().rig();
        let configuration = self.configuration.replace(self.variant().mark(), "");
        let found = rig.precisions.iter().find(|&&precision| configuration == rig.configuration(precision));
        found
            .copied()
            .ok_or_else(|| format!("budgets.toml: no configuration `{}` of {}", self.configuration, self.scenario))
    }

    /// The name of the entry in messages.
    pub fn what(&self) -> String {
        format!("{} {} {}", self.board, self.configuration, self.scenario)
    }
}
