//! TIMESYNC: the offset between a flight stack's clock and ours.

use crate::bytes::Reader;
use crate::frame::{Outgoing, Payload};

/// A request for the time, or its answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimeSync {
    /// Time of the answering clock, ns; 0 in a request.
    pub answered_ns: i64,
    /// Time of the requesting clock when the request was sent, ns.
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
    /// A request at this time of our clock.
    pub const fn question(now_ns: i64) -> Self {
        Self { answered_ns: 0, asked_ns: now_ns }
    }

    /// The answer if this is a request: PX4 sends requests, and then accepts our time stamps.
    #[must_use]
    pub fn answer(&self, now_ns: i64) -> Option<Self> {
        (self.answered_ns == 0).then_some(Self { answered_ns: now_ns, ..*self })
    }

    pub(crate) fn read(mut payload: Reader<'_>) -> Self {
        Self { answered_ns: payload.i64(), asked_ns: payload.i64() }
    }
}

/// Estimates the other clock from the answers to our requests, with the offset of the answer that had the shortest delay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Clock {
    /// Their clock minus ours, ns, and the delay of that answer.
    best: Option<(i64, i64)>,
}

impl Clock {
    /// Adds an answer that was received at this time of our clock. Returns whether it is an answer, with a delay below 1 s.
    pub fn take(&mut self, answer: &TimeSync, now_ns: i64) -> bool {
        let took = now_ns.saturating_sub(answer.asked_ns);
        if answer.answered_ns == 0 || !(0..1_000_000_000).contains(&took) {
            return false;
        }
        let offset = answer.answered_ns.saturating_sub(answer.asked_ns.saturating_add(took / 2));
        self.best = match self.best {
            // The stored delay increases by a twentieth each time, so that a drift of the clocks is followed.
            Some((best, least)) if took > least => Some((best, least + least / 20 + 1)),
            _ => Some((offset, took)),
        };
        true
    }

    /// Converts a time stamp of theirs, µs, to our clock, ns; `None` before the first answer.
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
    fn the_answer_with_the_shortest_delay_counts() {
        let mut clock = Clock::default();
        assert_eq!(clock.ours_ns(1), None);
        // Their clock is 5 s ahead; the delays of the answers are longer than those of the requests.
        let answer = |asked_ns: i64| TimeSync { answered_ns: asked_ns + 5_000_001_000, asked_ns };
        assert!(clock.take(&answer(1_000_000), 1_021_000));
        assert!(clock.take(&answer(2_000_000), 2_002_000));
        assert!(clock.take(&answer(3_000_000), 3_600_000));
        assert_eq!(clock.ours_ns(5_000_003), Some(3_000));
        // A request, an answer to one more than a second old, and an answer to a future one.
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
