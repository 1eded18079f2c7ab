//! Fixes: the pose itself is measured.

use crate::pointer::Versioned;
use scphd::FixReport;
use scphd::models::{HeadingFix, HeightFix, ModelError, Pose};
use scphd_vehicle::Watched;

/// How a height or a heading under water is measured.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_fix {
    /// `sizeof(scphd_fix)`, set by the caller.
    pub struct_size: u32,
    /// Standard deviation of its noise, m of a height, rad of a heading.
    pub sigma: f32,
    /// Squared Mahalanobis distance beyond which it is an outlier; 0: none is.
    pub gate: f32,
}

/// What a fix did.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_fix_report {
    /// `sizeof(scphd_fix_report)`, set by the caller.
    pub struct_size: u32,
    /// Whether it was taken in: 0 or 1. It is not where it lies beyond the gate.
    pub accepted: u32,
    /// Whether its watch has moved the vehicle to where such fixes say: 0 or 1.
    pub relocated: u32,
    /// Its squared Mahalanobis distance from what the filter expected.
    pub distance: f32,
    /// Logarithm of its likelihood; 0 where it was not taken in.
    pub ln_evidence: f32,
    /// Effective number of candidates after it.
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
