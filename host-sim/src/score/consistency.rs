//! Whether the filter is as sure of itself as it may be: evidence, innovations, position errors over their covariance.

use crate::record::ScanRecord;
use crate::score::moving::median;
use crate::settings::Settings;
use crate::slam::ScanOutcome;

/// What the filter said of its own scans.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Consistency {
    scans: usize,
    ln_evidence: Option<f64>,
    innovation_sum: f64,
    innovations: usize,
}

impl Consistency {
    /// Takes one scan in.
    pub fn scan(&mut self, outcome: &ScanOutcome) {
        self.scans += 1;
        if let Some(ln_evidence) = outcome.ln_evidence {
            self.ln_evidence = Some(self.ln_evidence.unwrap_or(0.0) + ln_evidence);
        }
        if let Some(innovation) = outcome.innovation {
            self.innovation_sum += innovation;
            self.innovations += 1;
        }
    }

    /// ln of the likelihood of all scans. The filter leaves out the factor exp(−∫ κ + w_b dz) of every scan, which does not
    /// tell particles apart, but settings.
    #[must_use]
    pub fn ln_evidence(&self, settings: &Settings) -> Option<f64> {
        let births = settings.filter.birth_intensity + settings.moving.birth_intensity;
        let expected = settings.sensor.clutter_per_scan + births * settings.sensor.measure();
        self.ln_evidence.map(|sum| sum - self.scans as f64 * expected)
    }

    /// Mean squared innovation over what was expected of it.
    #[must_use]
    pub fn innovation(&self) -> Option<f64> {
        (self.innovations > 0).then(|| self.innovation_sum / self.innovations as f64)
    }
}

/// Median of eᵀ P⁻¹ e / 2 over the scans with truth, e the error of the position and P its covariance; `None` where there are
/// none of them, or P is singular in all. Not the mean: after a scan that leaves all weight to one of the particles P is next to
/// nothing, and a few such scans would be all of it.
#[must_use]
pub fn of_position(scans: &[ScanRecord]) -> Option<f64> {
    let of_scan = |scan: &ScanRecord| {
        let truth = scan.true_position?;
        let (ex, ey) = (scan.pose[0] - truth[0], scan.pose[1] - truth[1]);
        let [[a, b, _], [_, c, _], _] = scan.pose_covariance;
        let determinant = a * c - b * b;
        (determinant > 0.0).then(|| (c * ex * ex - 2.0 * b * ex * ey + a * ey * ey) / determinant / 2.0)
    };
    median(&scans.iter().filter_map(of_scan).collect::<Vec<_>>())
}
