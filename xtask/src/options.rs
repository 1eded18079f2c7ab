//! What the command line says beside the steps.

use std::path::PathBuf;

use crate::capi;

/// Each option, as it was given.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Where the budget or the bench writes its figures.
    pub json: Option<PathBuf>,
    /// Whether a step that could not check everything makes the run a failure.
    pub strict: bool,
    /// Operations and seed of the fuzzer, in the place of its own.
    pub numbers: Vec<u64>,
    /// Where the C library is installed.
    pub place: capi::Place,
    /// Whether the step `python` runs the studies too, and the step `logs` what is large.
    pub studies: bool,
}
