//! Plan of the learning.

use super::search::Effort;
use crate::session::Filter;
use std::ops::Range;

/// The data to learn from, and the effort.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The filter that will run with the settings.
    pub filter: Filter,
    /// The scans to learn from; the others judge.
    pub learn: Range<usize>,
    /// Number of runs over them; each uses the results of the one before.
    pub rounds: usize,
    pub effort: Effort,
}
