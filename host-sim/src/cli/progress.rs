//! A progress bar for long runs.

use super::failure::is_quiet;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

/// Shorter runs show no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// The bar of one or several runs, on stderr if that is a terminal; removed when dropped.
pub struct Progress {
    bar: ProgressBar,
    start: Instant,
}

impl Progress {
    /// A bar, not shown yet, for `scans` scans altogether.
    pub fn new(label: String, scans: usize) -> Self {
        let bar = ProgressBar::with_draw_target(Some(scans as u64), ProgressDrawTarget::hidden());
        let template = "{msg} {wide_bar} {pos}/{len} scans, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_message(label);
        Self { bar, start: Instant::now() }
    }

    /// Updates the number of finished scans.
    pub fn at(&self, scans: usize) {
        if self.bar.is_hidden() && !is_quiet() && self.start.elapsed() > PATIENCE && io::stderr().is_terminal() {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        self.bar.set_position(scans as u64);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
