//! Options of the command line.

use crate::{capi, files};
use serde::Serialize;
use std::path::PathBuf;

#[derive(Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// File for the figures of the budget or the bench.
    pub json: Option<PathBuf>,
    /// Whether a step that could not check everything makes the run fail.
    pub strict: bool,
    /// Number of operations and seed for the fuzzer.
    pub numbers: Vec<u64>,
    /// Destination of the C library.
    pub place: capi::Place,
    /// Whether the step `python` also runs the studies, and the step `logs` large packages.
    pub studies: bool,
}

impl Options {
    /// Writes figures to their file, if there is to be one.
    pub fn write(&self, figures: &impl Serialize) -> Result<(), String> {
        let Some(path) = &self.json else { return Ok(()) };
        let text = serde_json::to_string_pretty(figures).map_err(|error| error.to_string())?;
        files::write(path, text + "\n")
    }
}
