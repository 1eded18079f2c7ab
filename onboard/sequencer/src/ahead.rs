//! Motion by the controls that are still queued.

use crate::Interval;
use crate::queue::Queue;
use crate::stamp::Key;

/// The control in force, and the time from which it holds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Held<C> {
    pub(crate) control: C,
    pub(crate) since: u64,
}

/// The controls from a time on, each with its duration: see [`Sequencer::ahead`](crate::Sequencer::ahead).
#[derive(Debug, Clone)]
pub struct Ahead<'q, C, const CONTROLS: usize> {
    waiting: &'q Queue<C, CONTROLS>,
    /// The last control from the queue.
    last: Option<Key>,
    held: Option<Held<C>>,
    time: u64,
    until: u64,
    gap_ns: u64,
}

impl<'q, C: Copy, const CONTROLS: usize> Ahead<'q, C, CONTROLS> {
    pub(crate) fn new(
        waiting: &'q Queue<C, CONTROLS>,
        held: Option<Held<C>>,
        time: u64,
        until: u64,
        gap_ns: u64,
    ) -> Self {
        Self { waiting, last: None, held, time, until, gap_ns }
    }
}

impl<C: Copy, const CONTROLS: usize> Iterator for Ahead<'_, C, CONTROLS> {
    type Item = (C, Interval);

    /// At most one iteration for every queued control, and one for the control in force.
    fn next(&mut self) -> Option<Self::Item> {
        for _ in 0..=CONTROLS {
            let Held { control, since } = self.held?;
            let next = self.waiting.after(self.last).filter(|(key, _)| key.time < self.until);
            let end = next.map_or(self.until, |(key, _)| key.time);
            let known = end.min(since.saturating_add(self.gap_ns)).saturating_sub(self.time);
            self.time = self.time.max(end);
            self.last = next.map(|(key, _)| key);
            self.held = next.map(|(key, &control)| Held { control, since: key.time });
            if known > 0 {
                return Some((control, Interval::of_ns(known)));
            }
        }
        None
    }
}
