//! Wall times of the stages of a scan, because the filter itself has no clock.

use scphd::diagnostics::{Probe, Stage};
use std::time::Instant;

/// Number of stages, in the order of [`Stage::ALL`].
pub const STAGES: usize = Stage::ALL.len();

/// Sums of wall times. A nested stage is not counted in the outer one.
#[derive(Debug, Default)]
pub(super) struct StageTimes {
    spent_us: [f64; STAGES],
    /// The open stages, the innermost last, and the time since when the innermost one is counted.
    open: Vec<usize>,
    since: Option<Instant>,
}

impl StageTimes {
    /// Times of all stages, µs.
    pub(super) fn us(&self) -> [f64; STAGES] {
        self.spent_us
    }

    /// Adds the time until now to the innermost stage.
    fn charge(&mut self) {
        let now = Instant::now();
        if let (Some(&stage), Some(since)) = (self.open.last(), self.since) {
            self.spent_us[stage] += (now - since).as_secs_f64() * 1e6;
        }
        self.since = Some(now);
    }
}

impl Probe for StageTimes {
    fn enter(&mut self, stage: Stage) {
        self.charge();
        self.open.extend(Stage::ALL.iter().position(|one| *one == stage));
    }

    fn leave(&mut self, _stage: Stage) {
        self.charge();
        self.open.pop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread::sleep;
    use std::time::Duration;

    #[test]
    fn the_time_of_a_nested_stage_is_counted_once() {
        let mut times = StageTimes::default();
        let nap = || sleep(Duration::from_millis(5));
        nap();
        let begun = Instant::now();
        times.enter(Stage::Update);
        nap();
        times.enter(Stage::Reduce);
        (0..4).for_each(|_| nap());
        times.leave(Stage::Reduce);
        times.leave(Stage::Update);
        let all_us = begun.elapsed().as_secs_f64() * 1e6;
        nap();
        let [predict, weigh, resample, update, reduce] = times.us();
        assert_eq!([predict, weigh, resample], [0.0; 3]);
        assert!(update >= 5e3 && reduce >= 20e3 && update + reduce <= all_us, "{:?} of {all_us}", times.us());
    }
}
