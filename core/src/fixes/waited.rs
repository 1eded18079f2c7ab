//! Number and duration of the fixes rejected in a row.

use super::FixRule;
use crate::Real;

/// Fixes that were refused in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Waited<T> {
    /// How many; stops at a number that does not matter.
    pub(super) refused: u16,
    /// From the first to the last, s.
    pub(super) lasted_s: T,
}

impl<T: Real> Waited<T> {
    pub(super) const NONE: Self = Self { refused: 0, lasted_s: T::ZERO };

    /// One more, so long after the fix before; a time that is none counts as none.
    pub(super) fn refuse(&mut self, elapsed_s: T) {
        if self.refused > 0 && elapsed_s > T::ZERO {
            self.lasted_s += elapsed_s;
        }
        self.refused = self.refused.saturating_add(1);
    }

    /// Whether they have lasted as long as the rule says.
    pub(super) fn is_over(&self, rule: &FixRule<T>) -> bool {
        self.refused >= rule.fewest && self.lasted_s >= rule.patience_s
    }
}
