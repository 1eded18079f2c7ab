//! How often features in view are detected, and how many detections belong to none.

use super::pairs::Expectation;

/// Sums for a straight line of the detection probability over the range.
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
    /// None yet, of a sensor of that greatest range, m.
    pub fn over(range_max_m: f64) -> Self {
        Self { range_max_m, ..Self::default() }
    }

    /// Adds the well known features in view of one scan.
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

    /// The line of least squares through "detected" over range: its values at range 0 and at the greatest.
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

    /// The share of them that was detected.
    pub fn share(&self) -> Option<f64> {
        (self.expected > 0).then(|| self.detected / self.expected as f64)
    }

    /// Features that were in view, counted in every scan anew.
    pub fn expected(&self) -> usize {
        self.expected
    }
}

/// Detections that belong to no feature, not even to one that was found later.
#[derive(Debug, Default)]
pub struct Clutter {
    scans: usize,
    measurements: usize,
    unexplained: Option<usize>,
}

impl Clutter {
    /// Counts a scan of so many detections.
    pub fn scan(&mut self, detections: usize) {
        self.scans += 1;
        self.measurements += detections;
    }

    /// At the end: so many were left unexplained.
    pub fn conclude(&mut self, unexplained: usize) {
        self.unexplained = Some(unexplained);
    }

    /// Detections in all.
    pub fn measurements(&self) -> usize {
        self.measurements
    }

    /// Unexplained ones a scan.
    pub fn per_scan(&self) -> Option<f64> {
        Some(self.unexplained? as f64 / self.scans as f64)
    }
}
