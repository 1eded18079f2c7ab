//! The position of the recursion between scans: counts, times and the random stream.

use crate::report::watch::Watch;
use crate::{Noise, Real};

/// The time since the last scan, with so much more. Times that no number can hold together stand still.
pub(crate) fn passed<T: Real>(waited_s: T, dt: T) -> T {
    let sum = waited_s + dt;
    if sum.is_finite() { sum } else { waited_s }
}

/// Where the recursion stands.
#[derive(Debug, Clone)]
pub(crate) struct Cursor<T> {
    /// Particles in use; zero before the first reset.
    pub(crate) particles: usize,
    /// Candidates of every particle: M between a prediction and the next scan, otherwise 1.
    pub(crate) children: usize,
    /// Whether the candidates have moved since the last scan.
    pub(crate) predicted: bool,
    /// Summed dt of the predictions since the last scan, s, which the moving features have still to be moved by.
    pub(crate) waited_s: T,
    /// Predictions refused since the last scan.
    pub(crate) refused: u16,
    /// Candidates that the last scan weighed; zero before the first.
    pub(crate) weighed: usize,
    /// The particle whose map is the estimate: the one that continues the heaviest surviving candidate of the last
    /// scan.
    pub(crate) heaviest: usize,
    /// The label that the next feature gets. It wraps after four thousand million.
    pub(crate) next_label: u32,
    /// The random stream; none before the first reset.
    pub(crate) noise: Option<Noise>,
    /// Whether the vehicle is where it is taken to be.
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

    /// So much more time has passed.
    pub(crate) fn wait(&mut self, dt: T) {
        self.waited_s = passed(self.waited_s, dt);
    }

    /// Number of candidates in use.
    pub(crate) fn candidates(&self) -> usize {
        self.particles.saturating_mul(self.children)
    }
}
