//! Inputs of a vehicle's filter in the order of time.

use scphd::models::Reading;
use scphd_log::underwater::{Instruments, Log};
use scphd_stream::underwater::Navigation;

/// Position in a log's instruments.
#[derive(Debug)]
pub struct Timeline<'a> {
    instruments: &'a [Instruments],
    next: usize,
    now_s: f64,
    yaw_rate_sigma_radps: f64,
}

/// An input of a filter, and its row of the log.
#[derive(Debug, Clone, Copy)]
pub struct Step<'a> {
    pub navigation: Navigation,
    /// The row at the end of the step, if there is one.
    pub row: Option<&'a Instruments>,
}

impl<'a> Timeline<'a> {
    /// Starts at the first row of the instruments. The yaw rate has this standard deviation, rad/s, if the log does not state
    /// one.
    pub fn new(log: &'a Log, yaw_rate_sigma_radps: f64) -> Self {
        let now_s = log.instruments.first().map_or(0.0, |row| row.t_s);
        Self { instruments: &log.instruments, next: 0, now_s, yaw_rate_sigma_radps }
    }

    /// Index of the last row that was read.
    pub fn row(&self) -> usize {
        self.next.saturating_sub(1)
    }

    /// The steps from the present time to `t_s`: one to every row of the instruments until then, and one after the last of them.
    /// The first row is read at the start.
    pub fn steps_to(&mut self, t_s: f64) -> Vec<Step<'a>> {
        let mut steps = Vec::new();
        while let Some(row) = self.instruments.get(self.next).filter(|row| self.next == 0 || row.t_s <= t_s) {
            steps.push(self.step(row.t_s, Some(row)));
            self.next += 1;
        }
        if t_s > self.now_s {
            steps.push(self.step(t_s, None));
        }
        steps
    }

    fn step(&mut self, t_s: f64, row: Option<&'a Instruments>) -> Step<'a> {
        let dt_s = t_s - self.now_s;
        self.now_s = t_s;
        let instruments = row.map(|row| scphd::navigation::Instruments {
            roll_rad: row.roll_rad,
            pitch_rad: row.pitch_rad,
            yaw_rate_radps: Reading {
                value: row.yaw_rate_radps,
                sigma: row.yaw_rate_sigma_radps.unwrap_or(self.yaw_rate_sigma_radps),
            },
            velocity_mps: row.velocity_mps,
            z_m: row.z_m,
        });
        Step { navigation: Navigation { dt_s, instruments }, row }
    }
}

#[cfg(test)]
mod tests {
    use super::Timeline;
    use scphd_worlds::underwater::tank::girona_tank;

    #[test]
    fn every_row_occurs_once_and_the_durations_add_up() {
        let mut log = girona_tank(1);
        log.instruments.truncate(4);
        let mut timeline = Timeline::new(&log, 0.02);
        let (rows, start) = (&log.instruments, log.instruments[0].t_s);
        let half = 0.5 * (rows[1].t_s + rows[2].t_s);
        let mut passed = 0.0;
        // Before the first row, at it, between two rows, there again, at the last row, after it.
        let ends = [start - 1.0, start, half, half, rows[3].t_s, rows[3].t_s + 0.25];
        let found = ends.map(|t_s| {
            let steps = timeline.steps_to(t_s);
            passed += steps.iter().map(|step| step.navigation.dt_s).sum::<f64>();
            assert!((passed - (t_s - start).max(0.0)).abs() < 1e-12, "{t_s}");
            (steps.len(), steps.iter().filter(|step| step.row.is_some()).count())
        });
        assert_eq!(found, [(1, 1), (0, 0), (2, 1), (0, 0), (2, 2), (1, 0)]);
        assert_eq!(log.instruments[0].yaw_rate_sigma_radps, None);
    }
}
