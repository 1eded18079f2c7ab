//! Odometry noise, from the corrections of the pose by the scans.

use super::learn::Added;
use scphd_log::angle::wrap;
use scphd_log::dimensions::Dimensions;

/// Sums over all scans: in a filter with the right noise, the corrections by scans have the variance that the motion between them
/// has added.
#[derive(Debug, Default)]
pub struct OdometryNoise {
    added: Added,
    /// Σ of the squared corrections along the vehicle (m²) and of its heading (rad²).
    corrected: [f64; 2],
    corrections: usize,
}

impl OdometryNoise {
    pub fn predict(&mut self, added: Added) {
        self.added.along += added.along;
        self.added.turned[0] += added.turned[0];
        self.added.turned[1] += added.turned[1];
    }

    pub fn correct<D: Dimensions>(&mut self, before: &D::Pose, after: &D::Pose) {
        let (sin, cos) = D::heading(before).sin_cos();
        let moved = |k: usize| after.as_ref()[k] - before.as_ref()[k];
        let along = cos * moved(0) + sin * moved(1);
        self.corrected[0] += along * along;
        self.corrected[1] += wrap(D::heading(after) - D::heading(before)).powi(2);
        self.corrections += 1;
    }

    /// Factors by which the standard deviations of the first and of the second noise are too small.
    pub fn ratios(&self) -> [Option<f64>; 2] {
        let Added { along, turned: [by_first, by_second] } = self.added;
        let first = (along > 0.0).then(|| self.corrected[0] / along);
        let rest = (self.corrected[1] - first.unwrap_or(0.0) * by_first).max(0.0);
        [first, (by_second > 0.0).then(|| rest / by_second)].map(|squared| squared.map(f64::sqrt))
    }

    pub fn corrections(&self) -> usize {
        self.corrections
    }
}
