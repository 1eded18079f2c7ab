//! What lies in the buffers that host and device share: numbers of four and eight bytes, without gaps.

use crate::Setup;
use bytemuck::{Pod, Zeroable};

/// One run: its filter, and where its inputs and outputs lie in the buffers of all runs.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Run {
    /// Seed of the filter: its lower half, then its upper one.
    pub seed: [u32; 2],
    /// The place of its first scan, and of that scan's result.
    pub first_scan: u32,
    /// Number of its scans.
    pub scans: u32,
    /// The place of its first prediction.
    pub first_prediction: u32,
    /// Number of its predictions.
    pub predictions: u32,
    /// The place of its first measurement.
    pub first_measurement: u32,
    /// Number of its measurements.
    pub measurements: u32,
    /// Where its estimated features begin.
    pub first_feature: u32,
    /// Room for them, over all scans.
    pub features: u32,
    /// Where its estimated moving features begin.
    pub first_mover: u32,
    /// Room for them, over all scans.
    pub movers: u32,
    /// Models and tuning.
    pub setup: Setup,
}

impl Run {
    /// The seed in one.
    #[must_use]
    pub fn seed(&self) -> u64 {
        let [low, high] = self.seed.map(u64::from);
        high << 32 | low
    }

    /// A seed in halves.
    #[must_use]
    pub fn halves(seed: u64) -> [u32; 2] {
        [seed, seed >> 32].map(|half| half as u32)
    }
}

/// One scan: the predictions before it and its measurements, counted from the first of the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Scan {
    /// The place of the first prediction since the scan before.
    pub first_prediction: u32,
    /// Number of predictions since then.
    pub predictions: u32,
    /// The place of its first measurement.
    pub first_measurement: u32,
    /// Number of its measurements.
    pub measurements: u32,
}

/// One prediction.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Prediction {
    /// Speed, m/s, then steering angle, rad, or turn rate, rad/s.
    pub control: [f32; 2],
    /// For how long, s.
    pub dt_s: f32,
}

/// What is known after a scan.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ScanResult {
    /// The digest of filter and detector; 0 where it was not asked for.
    pub digest: u64,
    /// Estimated x, y, m, and heading, rad.
    pub pose: [f32; 3],
    /// Its covariance, row by row from the diagonal on: xx, xy, xh, yy, yh, hh.
    pub covariance: [f32; 6],
    /// Effective number of particles before resampling.
    pub n_eff: f32,
    /// ln of the likelihood of the scan given all before, up to a constant.
    pub ln_evidence: f32,
    /// Mean squared innovation over what was expected of it; 0 where nothing was detected.
    pub innovation: f32,
    /// N̂ of the static map.
    pub expected_features: f32,
    /// Whether the particles were resampled, 0 or 1.
    pub resampled: u32,
    /// Greatest number of components in view of a candidate.
    pub in_view: u32,
    /// Measurements that could not give birth.
    pub no_birth: u32,
    /// Pages of static features in use.
    pub pages_used: u32,
    /// The most pages of static features that the scan has taken.
    pub peak_pages: u32,
    /// The same of moving features.
    pub peak_moving_pages: u32,
    /// Conditions, as bits of [`scphd::Health`].
    pub health: u32,
    /// The place of the first estimated feature, counted from the first of the run.
    pub first_feature: u32,
    /// Number of estimated features.
    pub features: u32,
    /// The place of the first estimated moving feature, counted likewise.
    pub first_mover: u32,
    /// Number of estimated moving features.
    pub movers: u32,
}

/// An estimated static feature.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Feature {
    /// Its name for life.
    pub label: u32,
    /// ln of its weight.
    pub ln_weight: f32,
    /// Position, m.
    pub mean: [f32; 2],
    /// Covariance of the position, m²: xx, xy, yy.
    pub covariance: [f32; 3],
}

/// An estimated moving feature.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Mover {
    /// Its name for life.
    pub label: u32,
    /// ln of its weight.
    pub ln_weight: f32,
    /// Position, m, and velocity, m/s.
    pub mean: [f32; 4],
    /// Covariance of the position, m²: xx, xy, yy.
    pub covariance: [f32; 3],
}

/// How a run ended, or that it goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Status {
    /// One of the constants.
    pub code: u32,
    /// Scans taken in.
    pub scans: u32,
}

impl Status {
    /// No thread has touched it: a buffer begins as zeros.
    pub const UNTOUCHED: u32 = 0;
    /// All scans that were asked for are taken in.
    pub const DONE: u32 = 1;
    /// The places of the run lie outside its buffers.
    pub const BUFFERS: u32 = 2;
    /// The models or the tuning are out of range, or there is no room for as many particles.
    pub const SETUP: u32 = 3;
    /// The filter refused a prediction.
    pub const PREDICTION: u32 = 4;
    /// The filter refused a scan.
    pub const SCAN: u32 = 5;
    /// There is no room for the estimated features.
    pub const FEATURES: u32 = 6;

    /// What a code says.
    #[must_use]
    pub fn text(code: u32) -> &'static str {
        match code {
            Self::UNTOUCHED => "no thread has worked on it",
            Self::DONE => "done",
            Self::BUFFERS => "its places lie outside its buffers",
            Self::SETUP => "the filter refuses the settings, or has no room for as many particles",
            Self::PREDICTION => "a prediction was refused",
            Self::SCAN => "the scan was refused",
            Self::FEATURES => "no room for the estimated features",
            _ => "an unknown code",
        }
    }
}
