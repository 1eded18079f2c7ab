//! What a receiver has refused.

use core::fmt;

/// Why a frame was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Refused {
    /// Its check fails, or its stuffing; or it is a part of one.
    Damaged,
    /// It has more bytes than the receiver has room for.
    TooLong,
    /// It is of another version, or of a kind that there is none of.
    Unknown,
    /// It belongs to a session that is not open.
    Foreign,
    /// It was there before.
    Doubled,
    /// Later ones were there before, and it was not.
    Late,
    /// One before it is missing, and [`Gaps::Refused`](crate::Gaps::Refused) is asked for.
    Ahead,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Damaged => "the frame is damaged",
            Self::TooLong => "the frame is too long",
            Self::Unknown => "the frame is of another version or of an unknown kind",
            Self::Foreign => "the frame belongs to a session that is not open",
            Self::Doubled => "the frame was there before",
            Self::Late => "the frame comes behind later ones",
            Self::Ahead => "a frame before this one is missing",
        })
    }
}

impl core::error::Error for Refused {}

/// How many frames a receiver has taken and refused. A damaged zero makes one damaged frame of two, a byte that becomes zero two of
/// one: damage is counted between zeros.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Report {
    /// Frames that were taken, but for those that ask.
    pub accepted: u32,
    /// [`Refused::Damaged`].
    pub damaged: u32,
    /// [`Refused::TooLong`].
    pub too_long: u32,
    /// [`Refused::Unknown`].
    pub unknown: u32,
    /// [`Refused::Foreign`].
    pub foreign: u32,
    /// [`Refused::Doubled`].
    pub doubled: u32,
    /// [`Refused::Late`].
    pub late: u32,
    /// [`Refused::Ahead`].
    pub ahead: u32,
    /// Numbers that were passed over, where [`Gaps::Passed`](crate::Gaps::Passed) is asked for.
    pub lost: u32,
}

impl Report {
    /// How many counts there are.
    pub(crate) const COUNTS: usize = 9;

    /// No frame yet.
    pub(crate) const NONE: Self = Self::of([0; Self::COUNTS]);

    /// Frames that were refused, whyever.
    #[must_use]
    pub fn refused(&self) -> u32 {
        let [_, refused @ .., _] = self.counts();
        refused.iter().fold(0, |sum, &count| sum.saturating_add(count))
    }

    /// All counts, in their order here.
    pub(crate) const fn counts(&self) -> [u32; Self::COUNTS] {
        let &Self { accepted, damaged, too_long, unknown, foreign, doubled, late, ahead, lost } = self;
        [accepted, damaged, too_long, unknown, foreign, doubled, late, ahead, lost]
    }

    /// The report with these counts.
    pub(crate) const fn of(counts: [u32; Self::COUNTS]) -> Self {
        let [accepted, damaged, too_long, unknown, foreign, doubled, late, ahead, lost] = counts;
        Self { accepted, damaged, too_long, unknown, foreign, doubled, late, ahead, lost }
    }

    /// Counts one that was refused.
    pub(crate) fn count(&mut self, why: Refused) {
        let count = match why {
            Refused::Damaged => &mut self.damaged,
            Refused::TooLong => &mut self.too_long,
            Refused::Unknown => &mut self.unknown,
            Refused::Foreign => &mut self.foreign,
            Refused::Doubled => &mut self.doubled,
            Refused::Late => &mut self.late,
            Refused::Ahead => &mut self.ahead,
        };
        *count = count.saturating_add(1);
    }
}
