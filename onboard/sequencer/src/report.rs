//! Problems with the times of the inputs.

use core::fmt;
use core::ops::{BitOr, BitOrAssign};

/// A set of warnings, each with one cause. `docs/time.md` says what to do about each.
///
/// ```
/// use scphd_sequencer::Flags;
///
/// let flags = Flags::LATE | Flags::GAP;
/// assert!(flags.contains(Flags::GAP) && !flags.contains(Flags::FROZEN) && !flags.is_empty());
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Default)]
pub struct Flags(u16);

impl Flags {
    /// No warning.
    pub const NONE: Self = Self(0);
    /// An input arrived after its reordering window: it was refused.
    pub const LATE: Self = Self(1);
    /// An input had the time, source and number of one that is still queued: it was refused.
    pub const DUPLICATE: Self = Self(1 << 1);
    /// The queue of controls was full: an input was refused.
    pub const CONTROLS_FULL: Self = Self(1 << 2);
    /// The queue of events was full: an input was refused.
    pub const EVENTS_FULL: Self = Self(1 << 3);
    /// There was no control for longer than [`gap_ns`](crate::Settings::gap_ns).
    pub const GAP: Self = Self(1 << 4);
    /// A time stamp, or the time of a tick, was ahead of the newest time by more than [`jump_ns`](crate::Settings::jump_ns): it was
    /// refused, unless the clock was set to it. Or it was ahead by more than the window, and the next input contradicted it: it was
    /// dropped.
    pub const JUMP_FORWARD: Self = Self(1 << 5);
    /// A time stamp was behind the newest time by more than [`jump_ns`](crate::Settings::jump_ns): it was refused, unless the clock
    /// was set to it.
    pub const JUMP_BACK: Self = Self(1 << 6);
    /// [`jumps_believed`](crate::Settings::jumps_believed) inputs in a row came from beyond a jump: the clock was set to their
    /// time, and the sequencer continues with the new time.
    pub const CLOCK_SET: Self = Self(1 << 7);
    /// [`frozen_inputs`](crate::Settings::frozen_inputs) inputs in a row were not newer than the previous ones: the clock of the
    /// time stamps stands still.
    pub const FROZEN: Self = Self(1 << 8);
    /// The time of a tick was behind the newest time by more than the window: the clock of the ticks stands still, was set back, or
    /// is not the clock of the time stamps. The tick was ignored.
    pub const TICK_BEHIND: Self = Self(1 << 9);

    const NAMES: [(Self, &'static str); CONDITIONS] = [
        (Self::LATE, "LATE"),
        (Self::DUPLICATE, "DUPLICATE"),
        (Self::CONTROLS_FULL, "CONTROLS_FULL"),
        (Self::EVENTS_FULL, "EVENTS_FULL"),
        (Self::GAP, "GAP"),
        (Self::JUMP_FORWARD, "JUMP_FORWARD"),
        (Self::JUMP_BACK, "JUMP_BACK"),
        (Self::CLOCK_SET, "CLOCK_SET"),
        (Self::FROZEN, "FROZEN"),
        (Self::TICK_BEHIND, "TICK_BEHIND"),
    ];

    /// All warnings, in the order of the bits.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::NAMES.iter().map(|(condition, _)| *condition)
    }

    /// Whether there is no warning.
    pub fn is_empty(self) -> bool {
        self == Self::NONE
    }

    /// Whether all warnings of `other` are set.
    #[must_use]
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The set as bits, for a telemetry field. The bit of a warning is the same in every release.
    pub fn bits(self) -> u16 {
        self.0
    }
}

impl BitOr for Flags {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for Flags {
    fn bitor_assign(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

impl fmt::Debug for Flags {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set()
            .entries(Self::NAMES.iter().filter(|(flag, _)| self.contains(*flag)).map(|(_, name)| name))
            .finish()
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Flags {
    fn format(&self, f: defmt::Formatter<'_>) {
        let mut separator = "";
        defmt::write!(f, "{{");
        for (_, name) in Self::NAMES.iter().filter(|(flag, _)| self.contains(*flag)) {
            defmt::write!(f, "{=str}{=str}", separator, name);
            separator = ", ";
        }
        defmt::write!(f, "}}");
    }
}

const CONDITIONS: usize = 10;

/// Warnings since the report was last taken, and their counts since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Report {
    /// Warnings since the last call of [`take_report`](crate::Sequencer::take_report).
    pub flags: Flags,
    counts: [u32; CONDITIONS],
}

impl Report {
    pub(crate) const NONE: Self = Self { flags: Flags::NONE, counts: [0; CONDITIONS] };

    /// Count of a warning since the start; of several warnings, the sum of their counts. Saturates at `u32::MAX`.
    #[must_use]
    pub fn count(&self, of: Flags) -> u32 {
        let counted = Flags::all().zip(self.counts).filter(|(condition, _)| of.contains(*condition));
        counted.fold(0, |sum, (_, count)| sum.saturating_add(count))
    }

    pub(crate) fn raise(&mut self, condition: Flags) {
        self.flags |= condition;
        for (of, count) in Flags::all().zip(&mut self.counts) {
            if condition.contains(of) {
                *count = count.saturating_add(1);
            }
        }
    }
}

/// Errors of an input. All but the first are counted in the [`Report`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PushError {
    /// The sequencer has not been started.
    #[error("the sequencer has not been started")]
    NotStarted,
    /// The input arrived after its reordering window: [`Flags::LATE`].
    #[error("the input arrived after its reordering window")]
    Late,
    /// An input with this time, source and number is already queued: [`Flags::DUPLICATE`].
    #[error("an input with this time, source and number is already queued")]
    Duplicate,
    /// The queue is full: [`Flags::CONTROLS_FULL`] or [`Flags::EVENTS_FULL`].
    #[error("the queue is full")]
    Full,
    /// Its time is too far from the newest: [`Flags::JUMP_FORWARD`] or [`Flags::JUMP_BACK`].
    #[error("the time of the input is too far from the newest time")]
    Jump,
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::{Flags, Report};
    use std::format;

    #[test]
    fn every_flag_has_its_own_bit_name_and_count() {
        let mut report = Report::NONE;
        for (place, condition) in Flags::all().enumerate() {
            assert_eq!(condition.bits(), 1 << place);
            (0..=place).for_each(|_| report.raise(condition));
            assert_eq!(report.count(condition) as usize, place + 1);
        }
        assert_eq!(report.count(Flags::LATE | Flags::GAP), 1 + 5);
        assert_eq!(format!("{:?}", Flags::LATE | Flags::TICK_BEHIND), r#"{"LATE", "TICK_BEHIND"}"#);
    }
}
