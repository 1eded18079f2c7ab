//! The order of frames by their numbers.

use crate::frame::{Frame, FrameKind};
use crate::report::Refused;

/// Treatment of a frame after a missing one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Gaps {
    /// Refuses it until the missing frame was sent again: no record is left out.
    Refused,
    /// Accepts it, and counts the missing frames: for data that is useless when it is late.
    Passed,
}

/// The session and the number of the next frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Order {
    pub(crate) gaps: Gaps,
    session: Option<u16>,
    next: u32,
    /// For each of the 64 numbers before the next one, the most recent in the lowest bit, whether it was received.
    there: u64,
}

impl Order {
    pub(crate) const fn new(gaps: Gaps) -> Self {
        Self { gaps, session: None, next: 0, there: 0 }
    }

    /// Waits for number 0 of a session that this side opens.
    pub(crate) const fn within(gaps: Gaps, session: u16) -> Self {
        Self { session: Some(session), ..Self::new(gaps) }
    }

    /// The number of the last accepted frame.
    pub(crate) fn last(&self) -> Option<u32> {
        self.next.checked_sub(1)
    }

    /// Accepts a frame. Returns the number of frames missing before it.
    ///
    /// # Errors
    /// The frame is out of order.
    pub(crate) fn take(&mut self, frame: &Frame<'_>) -> Result<u32, Refused> {
        let is_of_session = self.session == Some(frame.session);
        match frame.kind {
            FrameKind::Head if frame.number != 0 => return Err(Refused::Unknown),
            FrameKind::Head if !is_of_session => *self = Self::within(self.gaps, frame.session),
            _ if !is_of_session => return Err(Refused::Foreign),
            FrameKind::Ask => return Ok(0),
            FrameKind::Head | FrameKind::Record | FrameKind::Answer => {}
        }
        let Some(missing) = frame.number.checked_sub(self.next) else {
            let age = self.next.saturating_sub(1).saturating_sub(frame.number);
            let was_there = self.there.checked_shr(age).is_some_and(|there| there & 1 != 0);
            return Err(if was_there || self.gaps == Gaps::Refused { Refused::Doubled } else { Refused::Late });
        };
        if missing > 0 && self.gaps == Gaps::Refused {
            return Err(Refused::Ahead);
        }
        // A session ends before its numbers wrap.
        self.next = frame.number.checked_add(1).ok_or(Refused::Unknown)?;
        self.there = missing.checked_add(1).and_then(|places| self.there.checked_shl(places)).unwrap_or(0) | 1;
        Ok(missing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(kind: FrameKind, session: u16, number: u32) -> Frame<'static> {
        Frame { kind, session, number, token: None, content: &[] }
    }

    fn record(number: u32) -> Frame<'static> {
        frame(FrameKind::Record, 5, number)
    }

    fn opened(gaps: Gaps) -> Order {
        let mut order = Order::new(gaps);
        assert_eq!(order.take(&record(0)), Err(Refused::Foreign));
        assert_eq!((order.last(), order.take(&frame(FrameKind::Head, 5, 0))), (None, Ok(0)));
        order
    }

    #[test]
    fn skipped_frames_are_late_and_received_ones_duplicate() {
        let mut order = opened(Gaps::Passed);
        assert_eq!([1, 4, 5].map(|number| order.take(&record(number))), [Ok(0), Ok(2), Ok(0)]);
        let expected = [Err(Refused::Doubled), Err(Refused::Late), Err(Refused::Late), Err(Refused::Doubled)];
        assert_eq!([1, 2, 3, 4].map(|number| order.take(&record(number))), expected);
        assert_eq!((order.last(), order.take(&record(70))), (Some(5), Ok(64)));
        // Older than the record of received frames.
        assert_eq!([5, 6, 7, 70].map(|number| order.take(&record(number)).unwrap_err()), {
            [Refused::Late, Refused::Late, Refused::Late, Refused::Doubled]
        });
        assert_eq!(order.take(&record(1000)), Ok(929));
        assert_eq!([70, 999, 1000].map(|number| order.take(&record(number)).unwrap_err()), {
            [Refused::Late, Refused::Late, Refused::Doubled]
        });
    }

    #[test]
    fn no_frame_is_skipped_if_gaps_are_refused() {
        let mut order = opened(Gaps::Refused);
        let expected = [Ok(0), Err(Refused::Ahead), Ok(0), Ok(0), Err(Refused::Doubled)];
        assert_eq!([1, 3, 2, 3, 1].map(|number| order.take(&record(number))), expected);
        assert_eq!(order.last(), Some(3));
    }

    #[test]
    fn a_session_is_opened_once() {
        let mut order = opened(Gaps::Refused);
        assert_eq!(order.take(&record(1)), Ok(0));
        assert_eq!(order.take(&frame(FrameKind::Head, 5, 0)), Err(Refused::Doubled));
        assert_eq!(order.take(&frame(FrameKind::Head, 6, 1)), Err(Refused::Unknown));
        assert_eq!((order.last(), order.take(&frame(FrameKind::Head, 6, 0))), (Some(1), Ok(0)));
        assert_eq!(order.take(&record(2)), Err(Refused::Foreign));
        assert_eq!(order.take(&frame(FrameKind::Ask, 5, 0)), Err(Refused::Foreign));
        assert_eq!((order.take(&frame(FrameKind::Ask, 6, 99)), order.last()), (Ok(0), Some(0)));
        assert_eq!(order.take(&frame(FrameKind::Record, 6, u32::MAX)), Err(Refused::Ahead));
    }

    #[test]
    fn numbers_do_not_wrap() {
        let mut order = opened(Gaps::Passed);
        assert_eq!(order.take(&record(u32::MAX)), Err(Refused::Unknown));
        assert_eq!(order.take(&record(u32::MAX - 1)), Ok(u32::MAX - 2));
        assert_eq!(order.last(), Some(u32::MAX - 1));
    }
}
