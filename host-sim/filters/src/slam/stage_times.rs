//! How long each stage of a scan took, by the clock of this machine: the filter itself has none.

use scphd::diagnostics::{Probe, Stage};
use std::time::Instant;

/// The stages in the order of [`Stage::ALL`].
pub const STAGES: usize = Stage::ALL.len();

/// Adds up wall times. A stage inside another one is counted there alone.
#[derive(Debug, Default)]
pub(super) struct StageTimes {
    spent_us: [f64; STAGES],
    /// Those that go on, the innermost last, and since when that one has the clock.
    open: Vec<usize>,
    since: Option<Instant>,
}

impl StageTimes {
    /// Of every stage, µs.
    pub(super) fn us(&self) -> [f64; STAGES] {
        self.spent_us
    }

    /// Gives the time until now to the innermost stage.
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
    fn an_inner_stage_has_its_time_alone() {
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
