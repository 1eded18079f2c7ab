//! The position of the recursion between scans: counts, times and the random stream.

use crate::report::watch::Watch;
use crate::{Noise, Real};

/// Adds `dt` to the time since the last scan. If the sum is not finite, the time is unchanged.
pub(crate) fn passed<T: Real>(waited_s: T, dt: T) -> T {
    let sum = waited_s + dt;
    if sum.is_finite() { sum } else { waited_s }
}

/// Counts, times and other small data of the recursion.
#[derive(Debug, Clone)]
pub(crate) struct Cursor<T> {
    /// Particles in use; zero before the first reset.
    pub(crate) particles: usize,
    /// Candidates of every particle: M between a prediction and the next scan, otherwise 1.
    pub(crate) children: usize,
    /// Whether there was a prediction since the last scan.
    pub(crate) predicted: bool,
    /// Sum of dt of the predictions since the last scan, s, over which the moving features are still to be predicted.
    pub(crate) waited_s: T,
    /// Number of predictions refused since the last scan.
    pub(crate) refused: u16,
    /// Number of candidates weighted by the last scan; zero before the first.
    pub(crate) weighed: usize,
    /// The particle whose map is the estimate: the one that continues the heaviest surviving candidate of the last scan.
    pub(crate) heaviest: usize,
    /// The next free label. Labels wrap around after 2³².
    pub(crate) next_label: u32,
    /// The random stream; `None` before the first reset.
    pub(crate) noise: Option<Noise>,
    /// The divergence monitor.
    pub(crate) watch: Watch<T>,
}

impl<T: Real> Cursor<T> {
    pub(crate) const ZERO: Self = Self {
        particles: 0,
        children: 0,
        predicted: false,
        waited_s: T::ZERO,
        refused: 0,
        weighed: 0,
        heaviest: 0,
        next_label: 0,
        noise: None,
        watch: Watch::ZERO,
    };

    /// Adds to the time since the last scan.
    pub(crate) fn wait(&mut self, dt: T) {
        self.waited_s = passed(self.waited_s, dt);
    }

    /// Number of candidates in use.
    pub(crate) fn candidates(&self) -> usize {
        self.particles.saturating_mul(self.children)
    }
}
