//! Number and duration of the fixes rejected in a row.

use super::FixRule;
use crate::Real;

/// The fixes rejected in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Waited<T> {
    /// Their number; saturates.
    pub(super) refused: u16,
    /// Time from the first to the last, s.
    pub(super) lasted_s: T,
}

impl<T: Real> Waited<T> {
    pub(super) const NONE: Self = Self { refused: 0, lasted_s: T::ZERO };

    /// Adds a fix, with the time since the previous one, s; NaN counts as zero.
    pub(super) fn refuse(&mut self, elapsed_s: T) {
        if self.refused > 0 && elapsed_s > T::ZERO {
            self.lasted_s += elapsed_s;
        }
        self.refused = self.refused.saturating_add(1);
    }

    /// Whether number and time reach those of the rule.
    pub(super) fn is_over(&self, rule: &FixRule<T>) -> bool {
        self.refused >= rule.fewest && self.lasted_s >= rule.patience_s
    }
}
