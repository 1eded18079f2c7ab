//! What a SLAM filter is to the simulator.

use crate::dimensions::{Covariance, Dimensions, Planar};
use crate::record::{MapFeature, MovingFeature, Usage};
use crate::threads::Threads;
use scphd::{Implausible, PredictError, PredictReport};

/// A filter that a log can be fed to.
pub trait Slam<D: Dimensions = Planar> {
    /// Moves the vehicle; where no vehicle does that, leaves it where it is and says what is wrong.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn predict(&mut self, control: D::Control, dt_s: f64) -> Result<Option<Implausible>, Refusal>;

    /// Takes in a scan.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn scan(&mut self, detections: &[D::Measurement]) -> Result<ScanOutcome, Refusal>;

    /// Estimated pose and its covariance.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn pose(&mut self) -> Result<PoseAndCovariance<D>, Refusal>;

    /// N̂ and the estimated features.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn map(&mut self) -> Result<(f64, Vec<MapFeature<D>>), Refusal>;

    /// The estimated moving features, at the time of the last prediction; none where the filter takes everything for static.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn moving(&mut self) -> Result<Vec<MovingFeature<D>>, Refusal> {
        Ok(Vec::new())
    }

    /// From now on weighs candidates with these threads, where the filter knows how to; its results do not depend on it.
    fn weigh_on(&mut self, _threads: &Threads) {}

    /// Hash of the complete state, where the filter has one.
    fn digest(&mut self) -> Option<u64> {
        None
    }

    /// Memory of the state, where it is fixed.
    fn state_bytes(&self) -> Option<u64> {
        None
    }
}

/// What was wrong with a prediction that the fixed-capacity filter leaves out.
pub(super) fn left_out(outcome: Result<PredictReport, PredictError>) -> Result<Option<Implausible>, Refusal> {
    match outcome {
        Ok(_) => Ok(None),
        Err(PredictError::Implausible(what)) => Ok(Some(what)),
        Err(error) => Err(refusal(error)),
    }
}

/// A pose and its covariance.
pub type PoseAndCovariance<D = Planar> = (<D as Dimensions>::Pose, Covariance<<D as Dimensions>::Pose>);

/// What a scan did, as far as every filter can tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanOutcome {
    /// Effective number of particles before resampling.
    pub n_eff: f64,
    /// Whether the particles were resampled.
    pub resampled: bool,
    /// ln of the likelihood of the scan given all before, up to a constant; `None` where the filter does not report it.
    pub ln_evidence: Option<f64>,
    /// Mean squared innovation over what was expected of it, 1 where the models are right; `None` where nothing was
    /// detected or the filter does not report it.
    pub innovation: Option<f64>,
    /// What the filter did with its memory.
    pub usage: Usage,
    /// Conditions the filter reported; always good for the reference.
    pub health: scphd::Health,
}

impl ScanOutcome {
    /// Of a filter that says nothing of itself.
    pub const SILENT: Self = Self {
        n_eff: 1.0,
        resampled: false,
        ln_evidence: None,
        innovation: None,
        usage: Usage { in_view: 0, no_birth: 0, pages_used: None },
        health: scphd::Health::GOOD,
    };
}

/// A step that a filter refused, or settings it cannot work with.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Refusal(pub String);

/// What was said against it.
pub(crate) fn refusal(error: impl core::fmt::Display) -> Refusal {
    Refusal(error.to_string())
}
