//! A SLAM filter as the simulator sees it, whichever it is: the fixed-capacity filter in either precision, or the
//! reference.

mod core_filter;
mod reference_filter;

pub use core_filter::{Precision, core_filter};
pub use reference_filter::{ReferenceFilter, reference_of};

use crate::record::MapFeature;

/// A filter that a log can be fed to.
pub trait Slam {
    /// Moves the vehicle.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn predict(&mut self, control: [f64; 2], dt_s: f64) -> Result<(), Refusal>;

    /// Takes in a scan.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn scan(&mut self, detections: &[[f64; 2]]) -> Result<ScanOutcome, Refusal>;

    /// Estimated pose and its covariance.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn pose(&mut self) -> Result<PoseAndCovariance, Refusal>;

    /// N̂ and the estimated features.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn map(&mut self) -> Result<(f64, Vec<MapFeature>), Refusal>;

    /// Hash of the complete state, where the filter has one.
    fn digest(&mut self) -> Option<u64>;

    /// Memory of the state, where it is fixed.
    fn state_bytes(&self) -> Option<u64>;
}

/// A pose (x m, y m, heading rad) and its covariance.
pub type PoseAndCovariance = ([f64; 3], [[f64; 3]; 3]);

/// What a scan did, as far as every filter can tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanOutcome {
    /// Effective number of particles before resampling.
    pub n_eff: f64,
    /// Conditions the filter reported; always good for the reference.
    pub health: scphd::Health,
}

/// A step that a filter refused, or settings it cannot work with.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Refusal(pub String);
