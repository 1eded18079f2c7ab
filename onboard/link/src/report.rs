//! Frames that a receiver has refused.

/// Why a frame was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Refused {
    /// Its checksum or its byte stuffing is wrong, or a part of it is missing.
    #[error("the frame is damaged")]
    Damaged,
    /// It has more bytes than the receiver has memory for.
    #[error("the frame is too long")]
    TooLong,
    /// It has another version, or an unknown type.
    #[error("the frame has another version or an unknown type")]
    Unknown,
    /// It belongs to a session that is not open.
    #[error("the frame belongs to a session that is not open")]
    Foreign,
    /// It was received before.
    #[error("the frame was received before")]
    Doubled,
    /// Later frames were received before it.
    #[error("later frames were received before this one")]
    Late,
    /// A frame before it is missing, with [`Gaps::Refused`](crate::Gaps::Refused).
    #[error("a frame before this one is missing")]
    Ahead,
}

/// Counts of the accepted and refused frames of a receiver. Damage is counted between zeros: a damaged zero joins two frames to one
/// damaged frame, and a byte that becomes zero splits one frame in two.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Report {
    /// Accepted frames, without requests for an answer.
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
    /// Frame numbers that were skipped, with [`Gaps::Passed`](crate::Gaps::Passed).
    pub lost: u32,
}

impl Report {
    /// Number of counts.
    pub(crate) const COUNTS: usize = 9;

    /// No frame yet.
    pub(crate) const NONE: Self = Self::of([0; Self::COUNTS]);

    /// Frames that were refused, for any reason.
    #[must_use]
    pub fn refused(&self) -> u32 {
        let [_, refused @ .., _] = self.counts();
        refused.iter().fold(0, |sum, &count| sum.saturating_add(count))
    }

    /// All counts, in the order of the fields.
    pub(crate) const fn counts(&self) -> [u32; Self::COUNTS] {
        let &Self { accepted, damaged, too_long, unknown, foreign, doubled, late, ahead, lost } = self;
        [accepted, damaged, too_long, unknown, foreign, doubled, late, ahead, lost]
    }

    /// The report with these counts.
    pub(crate) const fn of(counts: [u32; Self::COUNTS]) -> Self {
        let [accepted, damaged, too_long, unknown, foreign, doubled, late, ahead, lost] = counts;
        Self { accepted, damaged, too_long, unknown, foreign, doubled, late, ahead, lost }
    }

    /// Counts a refused frame.
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
