//! What there is to do.

use super::search::Effort;
use crate::session::Filter;
use std::ops::Range;

/// What is learnt from, and how hard it is tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The filter that is to run with the settings.
    pub filter: Filter,
    /// The scans that are learnt from; the others judge.
    pub learn: Range<usize>,
    /// Runs over them, each with what the one before said.
    pub rounds: usize,
    /// Trials.
    pub effort: Effort,
}
