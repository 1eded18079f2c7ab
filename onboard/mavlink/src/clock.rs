//! TIMESYNC: what a flight stack's clock shows, by ours.

use crate::bytes::Reader;
use crate::frame::{Outgoing, Payload};

/// A question for the time, or its answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimeSync {
    /// The clock of who answers, ns; 0 in a question.
    pub answered_ns: i64,
    /// The clock of who asks, ns, when it asked.
    pub asked_ns: i64,
}

impl Outgoing for TimeSync {
    const NUMBER: u32 = 111;
    const EXTRA: u8 = 34;

    fn write(&self, payload: &mut Payload) {
        payload.0.bytes(&self.answered_ns.to_le_bytes()).bytes(&self.asked_ns.to_le_bytes());
    }
}

impl TimeSync {
    /// A question, at this time of ours.
    #[must_use]
    pub const fn question(now_ns: i64) -> Self {
        Self { answered_ns: 0, asked_ns: now_ns }
    }

    /// What is to be sent where this is a question: PX4 asks, and takes our stamps by its clock then.
    #[must_use]
    pub fn answer(&self, now_ns: i64) -> Option<Self> {
        (self.answered_ns == 0).then_some(Self { answered_ns: now_ns, ..*self })
    }

    pub(crate) fn read(mut payload: Reader<'_>) -> Self {
        Self { answered_ns: payload.i64(), asked_ns: payload.i64() }
    }
}

/// The other's clock, from the answers to our questions. It goes by those that came back soonest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Clock {
    /// Theirs less ours, ns, and how long its answer took.
    best: Option<(i64, i64)>,
}

impl Clock {
    /// Takes an answer that came at this time of ours; whether it was one, and not older than 1 s.
    pub fn take(&mut self, answer: &TimeSync, now_ns: i64) -> bool {
        let took = now_ns.saturating_sub(answer.asked_ns);
        if answer.answered_ns == 0 || !(0..1_000_000_000).contains(&took) {
            return false;
        }
        let offset = answer.answered_ns.saturating_sub(answer.asked_ns.saturating_add(took / 2));
        self.best = match self.best {
            // A twentieth longer each time, so that a drift of the clocks is followed.
            Some((best, least)) if took > least => Some((best, least + least / 20 + 1)),
            _ => Some((offset, took)),
        };
        true
    }

    /// A stamp of theirs, µs, by our clock, ns; `None` before the first answer.
    #[must_use]
    pub fn ours_ns(&self, theirs_us: u64) -> Option<i64> {
        let theirs_ns = i64::try_from(theirs_us).ok()?.checked_mul(1000)?;
        self.best.and_then(|(offset, _)| theirs_ns.checked_sub(offset))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_that_came_back_soonest_counts() {
        let mut clock = Clock::default();
        assert_eq!(clock.ours_ns(1), None);
        // Theirs is 5 s ahead; the way back takes longer.
        let answer = |asked_ns: i64| TimeSync { answered_ns: asked_ns + 5_000_001_000, asked_ns };
        assert!(clock.take(&answer(1_000_000), 1_021_000));
        assert!(clock.take(&answer(2_000_000), 2_002_000));
        assert!(clock.take(&answer(3_000_000), 3_600_000));
        assert_eq!(clock.ours_ns(5_000_003), Some(3_000));
        // A question, and an answer to one that was asked too long ago, or is still to be asked.
        assert!(!clock.take(&TimeSync::question(1), 2) && !clock.take(&answer(0), 2_000_000_000));
        assert!(!clock.take(&answer(10), 9));
        assert_eq!(TimeSync::question(7).answer(9), Some(TimeSync { answered_ns: 9, asked_ns: 7 }));
        assert_eq!(answer(7).answer(9), None);
    }

    #[test]
    fn a_drift_is_followed() {
        let mut clock = Clock::default();
        for second in 0..1000_i64 {
            let (asked_ns, took) = (second * 1_000_000_000, if second == 0 { 1_000_000 } else { 2_000_000 });
            let answer = TimeSync { answered_ns: asked_ns + took / 2 + 1000 * second + 1, asked_ns };
            assert!(clock.take(&answer, asked_ns + took));
        }
        let error = clock.ours_ns(0).unwrap() + 1_000_000;
        assert!(error.abs() < 25_000, "{error}");
    }
}
