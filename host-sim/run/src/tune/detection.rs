//! Estimates of the detection probability and of the number of false detections.

use super::pairs::Expectation;

/// Sums for a linear regression of the detection probability over the range.
#[derive(Debug, Default)]
pub struct Detections {
    range_max_m: f64,
    expected: usize,
    detected: f64,
    range: f64,
    range_squared: f64,
    detected_range: f64,
}

impl Detections {
    /// No features yet, of a sensor with this greatest range, m.
    pub fn over(range_max_m: f64) -> Self {
        Self { range_max_m, ..Self::default() }
    }

    /// Adds the well known features in view in one scan.
    pub fn scan(&mut self, expected: &[Expectation]) {
        for &Expectation { range_m, detected, .. } in expected.iter().filter(|expected| expected.well_known) {
            let detected = f64::from(u8::from(detected));
            self.expected += 1;
            self.detected += detected;
            self.range += range_m;
            self.range_squared += range_m * range_m;
            self.detected_range += detected * range_m;
        }
    }

    /// The regression line: its values at range 0 and at the greatest range.
    pub fn line(&self) -> Option<[f64; 2]> {
        let count = self.expected as f64;
        let spread = count * self.range_squared - self.range * self.range;
        if self.expected < 2 || spread <= f64::EPSILON * count * self.range_squared {
            return None;
        }
        let slope = (count * self.detected_range - self.range * self.detected) / spread;
        let near = (self.detected - slope * self.range) / count;
        Some([near, near + slope * self.range_max_m])
    }

    /// The detected share of the features.
    pub fn share(&self) -> Option<f64> {
        (self.expected > 0).then(|| self.detected / self.expected as f64)
    }

    /// Number of features in view, summed over the scans.
    pub fn expected(&self) -> usize {
        self.expected
    }
}

/// Detections without a feature, also without one that was initiated later.
#[derive(Debug, Default)]
pub struct Clutter {
    scans: usize,
    measurements: usize,
    unexplained: Option<usize>,
}

impl Clutter {
    pub fn scan(&mut self, detections: usize) {
        self.scans += 1;
        self.measurements += detections;
    }

    /// Sets the number of unexplained detections at the end.
    pub fn conclude(&mut self, unexplained: usize) {
        self.unexplained = Some(unexplained);
    }

    pub fn measurements(&self) -> usize {
        self.measurements
    }

    pub fn per_scan(&self) -> Option<f64> {
        Some(self.unexplained? as f64 / self.scans as f64)
    }
}
