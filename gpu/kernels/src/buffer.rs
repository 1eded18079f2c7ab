//! The elements of the buffers that host and device share: numbers of four and eight bytes, without padding.

use bytemuck::{Pod, Zeroable};
use scphd_vehicle::Setting;

/// The number of every [`Setting`] of a description with one sensor, in the order of the list; NaN for one that it does not have.
pub type Setup = [f32; Setting::COUNT];

/// One run: its filter, and the positions of its inputs and outputs in the buffers of all runs.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Run {
    /// The halves of the filter's seed, the lower one first.
    pub seed: [u32; 2],
    /// Index of its first scan, and of that scan's result.
    pub first_scan: u32,
    pub scans: u32,
    pub first_prediction: u32,
    pub first_measurement: u32,
    pub first_feature: u32,
    /// Capacity for estimated features, moving ones too, over all scans.
    pub features: u32,
    /// Number of particles; 0 of a joint map.
    pub particles: u32,
    pub samples: u32,
    /// Models and tuning.
    pub setup: Setup,
}

/// One scan: the predictions before it and its measurements. Indices count from the first of the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Scan {
    /// Index of the first prediction since the previous scan.
    pub first_prediction: u32,
    pub predictions: u32,
    pub first_measurement: u32,
    pub measurements: u32,
}

/// One prediction.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Prediction {
    /// Controls: speed, m/s, then steering angle, rad, or turn rate, rad/s, then speed to the left, m/s.
    pub control: [f32; 3],
    /// Duration, s.
    pub dt_s: f32,
}

/// The result of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ScanResult {
    /// The halves of the digest of filter and detector; 0 if none was requested.
    pub digest: [u32; 2],
    /// Estimated x, y, m, and heading, rad.
    pub pose: [f32; 3],
    /// The same before the scan, for a mixture only if it was requested.
    pub predicted: [f32; 3],
    /// Its covariance, row by row from the diagonal on: xx, xy, xh, yy, yh, hh.
    pub covariance: [f32; 6],
    /// Effective number of particles before resampling.
    pub n_eff: f32,
    /// ln of the likelihood of the scan given all earlier ones, up to a constant.
    pub ln_evidence: f32,
    /// Mean squared innovation relative to its expectation; 0 if nothing was detected.
    pub innovation: f32,
    /// N̂, the expected number of features of the static map.
    pub expected_features: f32,
    /// 0 or 1.
    pub resampled: u32,
    /// Greatest number of components in view of a candidate.
    pub in_view: u32,
    /// Number of measurements that could not give birth to a feature.
    pub no_birth: u32,
    pub pages_used: u32,
    /// Health conditions, as bits of [`scphd::Health`].
    pub health: u32,
    /// Index of the first estimated feature, from the first of the run.
    pub first_feature: u32,
    pub features: u32,
    /// Number of estimated moving features, which follow them.
    pub movers: u32,
}

/// An estimated feature.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Feature {
    pub label: u32,
    pub ln_weight: f32,
    /// Position, m, and the velocity of a moving one, m/s.
    pub mean: [f32; 4],
    /// Covariance of the position, m²: xx, xy, yy.
    pub covariance: [f32; 3],
}

/// The memory of a filter with certain numbers of particles and samples, as the compiler of the device laid it out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Layout {
    /// Bytes of its part of each buffer.
    pub buffers: [u64; 10],
}

/// How a run ended, or that it continues.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Status {
    pub code: u32,
    pub scans: u32,
}

impl Status {
    /// 0 is a run that no thread has processed.
    pub const DONE: u32 = 1;
    pub const SETUP: u32 = 2;
    pub const PREDICTION: u32 = 3;
    pub const SCAN: u32 = 4;
    pub const FEATURES: u32 = 5;

    /// The meaning of a code.
    pub fn text(code: u32) -> &'static str {
        const TEXTS: [&str; 6] = [
            "no thread has worked on it",
            "done",
            "the filter refuses the settings, or has no room for as many particles",
            "a prediction was refused",
            "the scan was refused",
            "no room for the estimated features",
        ];
        TEXTS.get(code as usize).unwrap_or(&"an unknown code")
    }
}
