//! Fixes: measurements of the pose.

use crate::pointer::Versioned;
use scphd::fixes::FixReport;
use scphd::models::{HeadingFix, HeightFix, ModelError, Pose};
use scphd_vehicle::Watched;

/// The model of a height or heading measurement under water.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_fix {
    /// `sizeof(scphd_fix)`, set by the caller.
    pub struct_size: u32,
    /// Standard deviation of the noise, m for a height, rad for a heading.
    pub sigma: f32,
    /// Squared Mahalanobis distance beyond which the fix is an outlier; 0: no gate.
    pub gate: f32,
}

/// The report of a fix.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_fix_report {
    /// `sizeof(scphd_fix_report)`, set by the caller.
    pub struct_size: u32,
    /// Whether the fix was used: 0 or 1. One beyond the gate is not.
    pub accepted: u32,
    /// Whether the filter was moved because rejected fixes agree with each other: 0 or 1.
    pub relocated: u32,
    /// Squared Mahalanobis distance of the innovation.
    pub distance: f32,
    /// Logarithm of the likelihood of the fix; 0 if it was not used.
    pub ln_evidence: f32,
    /// Effective number of candidates after the fix.
    pub n_eff: f32,
}

impl scphd_fix {
    fn gate(&self) -> f32 {
        if self.gate == 0.0 { f32::INFINITY } else { self.gate }
    }

    pub(crate) fn heading<P: Pose<Scalar = f32>>(&self) -> Result<HeadingFix<P>, ModelError> {
        HeadingFix::new(self.sigma)?.gated(self.gate())
    }

    pub(crate) fn height(&self) -> Result<HeightFix<f32>, ModelError> {
        HeightFix::new(self.sigma)?.gated(self.gate())
    }
}

impl From<FixReport<f32>> for scphd_fix_report {
    fn from(report: FixReport<f32>) -> Self {
        Self {
            struct_size: Self::STRUCT_SIZE,
            accepted: u32::from(report.accepted),
            relocated: 0,
            distance: report.distance,
            ln_evidence: report.ln_evidence,
            n_eff: report.n_eff,
        }
    }
}

impl From<Watched<f32>> for scphd_fix_report {
    fn from(Watched { report, relocated }: Watched<f32>) -> Self {
        Self { relocated: u32::from(relocated), ..report.into() }
    }
}
