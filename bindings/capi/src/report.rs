//! Reports of predictions and scans, with 32-bit numbers.

use crate::pointer::Versioned;
use core::ffi::{CStr, c_char};
use scphd::{JointReport, PredictReport, ScanReport};
use scphd_vehicle::Scanned;

/// No candidate explains the scan: the vehicle is lost, or clutter and birth intensities are both zero.
pub const SCPHD_HEALTH_UNEXPLAINED_SCAN: u32 = 1;
/// The estimated pose depends on a single sample.
pub const SCPHD_HEALTH_DEGENERATE: u32 = 2;
/// A map had so little memory that components above the pruning threshold were removed.
pub const SCPHD_HEALTH_PRUNING_TIGHTENED: u32 = 4;
/// A map remains as predicted because of too little memory.
pub const SCPHD_HEALTH_MAP_NOT_UPDATED: u32 = 8;
/// Components were discarded because of too little memory.
pub const SCPHD_HEALTH_COMPONENTS_LOST: u32 = 16;
/// Rounding errors made a covariance indefinite; it was repaired.
pub const SCPHD_HEALTH_COVARIANCE_REPAIRED: u32 = 32;
/// A predicted pose was out of the range of single precision; it was not changed.
pub const SCPHD_HEALTH_POSE_REJECTED: u32 = 64;
/// The mean squared innovation is more than twice the expected value: the noise is set too low, or the estimated pose is wrong.
pub const SCPHD_HEALTH_INNOVATION_HIGH: u32 = 128;
/// Predictions since the last scan were refused.
pub const SCPHD_HEALTH_PREDICTION_REFUSED: u32 = 256;
/// Known landmarks are missed, and other measurements appear: the odds are a hundred to one that the estimated pose is wrong.
pub const SCPHD_HEALTH_DIVERGENCE_SUSPECTED: u32 = 512;
/// As before, with odds of ten thousand to one. It stays set until the pose is set or made uncertain, or known landmarks are
/// detected again.
pub const SCPHD_HEALTH_LOST: u32 = 1024;
/// There has been no scan for eight times the usual interval, and for at least a second.
pub const SCPHD_HEALTH_INPUT_LOST: u32 = 2048;
/// Memory scrubbing found and repaired damage.
pub const SCPHD_HEALTH_STATE_REPAIRED: u32 = 4096;
/// Far more measurements than usual come from no known landmark.
pub const SCPHD_HEALTH_CLUTTER_HIGH: u32 = 8192;
/// Recently a fifth of the expected detections of known landmarks is missing.
pub const SCPHD_HEALTH_DETECTIONS_LOW: u32 = 16384;

/// The report of a prediction.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_predict_report {
    /// `sizeof(scphd_predict_report)`, set by the caller.
    pub struct_size: u32,
    /// Warnings: bits of `SCPHD_HEALTH_...`; 0 is good.
    pub health: u32,
    /// Candidates after the prediction.
    pub candidates: u32,
    /// Candidates that were not moved because their predicted pose was out of the range of single precision.
    pub rejected: u32,
    /// Predictions that were refused since the last scan.
    pub refused: u32,
}

/// The report of a scan. Fields that do not apply are 0: for example, only mixtures have pages and candidates.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_scan_report {
    /// `sizeof(scphd_scan_report)`, set by the caller.
    pub struct_size: u32,
    /// Warnings: bits of `SCPHD_HEALTH_...`; 0 is good.
    pub health: u32,
    /// Measurements in the scan.
    pub measurements: u32,
    /// Measurements that could not become a feature or component.
    pub no_birth: u32,
    /// Predictions that were refused since the last scan.
    pub refused: u32,
    /// Features in view, or the greatest number of components in view of any candidate.
    pub in_view: u32,
    /// New features or components.
    pub births: u32,
    /// Features or components that were merged into another one.
    pub merged: u32,
    /// Features or components that were discarded because of too little memory.
    pub lost: u32,
    /// Features of a joint map that were removed because their existence probability was too low.
    pub dropped: u32,
    /// Features of a joint map after the scan.
    pub features: u32,
    /// Moving-object tracks of a joint map after the scan.
    pub movers: u32,
    /// Hypotheses of data association of a joint map after the scan.
    pub hypotheses: u32,
    /// Candidates that were weighted.
    pub candidates: u32,
    /// Particles after the scan.
    pub particles: u32,
    /// Whether the particles were resampled: 0 or 1.
    pub resampled: u32,
    /// Pages of static features in use after the scan.
    pub pages_used: u32,
    /// Total number of pages for static features.
    pub pages: u32,
    /// Pages of moving features in use after the scan.
    pub moving_pages_used: u32,
    /// Total number of pages for moving features.
    pub moving_pages: u32,
    /// Effective number of candidates before resampling.
    pub n_eff: f32,
    /// Logarithm of the scan's likelihood, up to a constant; minus infinity if no candidate explains the scan.
    pub ln_evidence: f32,
    /// Expected number of detections of the features in view.
    pub expected_detections: f32,
    /// Expected number of measurements that come from features in view.
    pub detections: f32,
    /// Normalised innovation squared per dimension; about 1 for a consistent filter, 0 without detections.
    pub innovation: f32,
    /// Probability of the likeliest hypothesis, of which the other fields are.
    pub share: f32,
}

/// Converts a count to 32 bits.
pub(crate) fn count(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

impl From<PredictReport> for scphd_predict_report {
    fn from(report: PredictReport) -> Self {
        Self {
            struct_size: Self::STRUCT_SIZE,
            health: u32::from(report.health.bits()),
            candidates: count(report.candidates),
            rejected: count(report.rejected),
            refused: count(report.refused),
        }
    }
}

impl scphd_scan_report {
    const NOTHING: Self = Self {
        struct_size: Self::STRUCT_SIZE,
        health: 0,
        measurements: 0,
        no_birth: 0,
        refused: 0,
        in_view: 0,
        births: 0,
        merged: 0,
        lost: 0,
        dropped: 0,
        features: 0,
        movers: 0,
        hypotheses: 0,
        candidates: 0,
        particles: 0,
        resampled: 0,
        pages_used: 0,
        pages: 0,
        moving_pages_used: 0,
        moving_pages: 0,
        n_eff: 0.0,
        ln_evidence: 0.0,
        expected_detections: 0.0,
        detections: 0.0,
        innovation: 0.0,
        share: 0.0,
    };
}

/// The fields that the reports of both filters have, and further ones.
macro_rules! said {
    ($report:ident, $($field:ident),+) => {
        scphd_scan_report {
            health: u32::from($report.health.bits()),
            measurements: count($report.measurements),
            no_birth: count($report.no_birth),
            refused: count($report.refused),
            in_view: count($report.in_view),
            births: count($report.births),
            merged: count($report.merged),
            lost: count($report.lost),
            ln_evidence: $report.ln_evidence,
            expected_detections: $report.expected_detections,
            detections: $report.detections,
            innovation: $report.innovation,
            $($field: count($report.$field),)+
            ..scphd_scan_report::NOTHING
        }
    };
}

impl From<ScanReport<f32>> for scphd_scan_report {
    fn from(report: ScanReport<f32>) -> Self {
        let (resampled, n_eff) = (u32::from(report.resampled), report.n_eff);
        let said = said!(report, candidates, particles, pages_used, pages, moving_pages_used, moving_pages);
        Self { resampled, n_eff, ..said }
    }
}

impl From<JointReport<f32>> for scphd_scan_report {
    fn from(report: JointReport<f32>) -> Self {
        Self { share: report.share, ..said!(report, dropped, features, movers, hypotheses) }
    }
}

impl From<Scanned<f32>> for scphd_scan_report {
    fn from(scanned: Scanned<f32>) -> Self {
        match scanned {
            Scanned::Mixture(report) => report.into(),
            Scanned::Joint(report) => report.into(),
        }
    }
}

/// The names of the warnings, in the order of their bits.
const NAMES: [&CStr; 15] = [
    c"UNEXPLAINED_SCAN", c"DEGENERATE", c"PRUNING_TIGHTENED", c"MAP_NOT_UPDATED", c"COMPONENTS_LOST",
    c"COVARIANCE_REPAIRED", c"POSE_REJECTED", c"INNOVATION_HIGH", c"PREDICTION_REFUSED", c"DIVERGENCE_SUSPECTED",
    c"LOST", c"INPUT_LOST", c"STATE_REPAIRED", c"CLUTTER_HIGH", c"DETECTIONS_LOW",
];

/// The name of the lowest warning in `health`, as in docs/health.md; call it with each bit separately. "GOOD" if there is none.
/// The text is static.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_health_text(health: u32) -> *const c_char {
    name_of(health).as_ptr()
}

fn name_of(health: u32) -> &'static CStr {
    let none = if health == 0 { c"GOOD" } else { c"not a condition of this library" };
    NAMES.get(health.trailing_zeros() as usize).copied().unwrap_or(none)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd::Health;

    #[test]
    fn warnings_have_the_bits_of_the_library() {
        let of_c = [
            (SCPHD_HEALTH_UNEXPLAINED_SCAN, Health::UNEXPLAINED_SCAN),
            (SCPHD_HEALTH_DEGENERATE, Health::DEGENERATE),
            (SCPHD_HEALTH_PRUNING_TIGHTENED, Health::PRUNING_TIGHTENED),
            (SCPHD_HEALTH_MAP_NOT_UPDATED, Health::MAP_NOT_UPDATED),
            (SCPHD_HEALTH_COMPONENTS_LOST, Health::COMPONENTS_LOST),
            (SCPHD_HEALTH_COVARIANCE_REPAIRED, Health::COVARIANCE_REPAIRED),
            (SCPHD_HEALTH_POSE_REJECTED, Health::POSE_REJECTED),
            (SCPHD_HEALTH_INNOVATION_HIGH, Health::INNOVATION_HIGH),
            (SCPHD_HEALTH_PREDICTION_REFUSED, Health::PREDICTION_REFUSED),
            (SCPHD_HEALTH_DIVERGENCE_SUSPECTED, Health::DIVERGENCE_SUSPECTED),
            (SCPHD_HEALTH_LOST, Health::LOST),
            (SCPHD_HEALTH_INPUT_LOST, Health::INPUT_LOST),
            (SCPHD_HEALTH_STATE_REPAIRED, Health::STATE_REPAIRED),
            (SCPHD_HEALTH_CLUTTER_HIGH, Health::CLUTTER_HIGH),
            (SCPHD_HEALTH_DETECTIONS_LOW, Health::DETECTIONS_LOW),
        ];
        assert!(of_c.iter().all(|(bit, condition)| *bit == u32::from(condition.bits())));
        assert_eq!(of_c.len(), Health::all().count());
        for (bit, condition) in of_c {
            assert_eq!(std::format!("{{{:?}}}", name_of(bit).to_str().unwrap()), std::format!("{condition:?}"));
        }
    }
}
