//! A SLAM filter as the simulator sees it, whichever it is: the fixed-capacity filter in either precision, or the
//! reference.

mod config;
mod core_filter;
mod joint_filter;
mod reference_filter;

pub(crate) use config::{config_of, online_of};
pub(crate) use core_filter::{Ahead, full, range_bearing, refusal};
pub use core_filter::{Precision, core_filter};
pub use joint_filter::joint_filter;
pub use reference_filter::{ReferenceFilter, reference_of};

use crate::record::{MapFeature, MovingFeature};
use crate::reference::{Candidate, Component, Draws};
use crate::threads::Threads;
use scphd::{Implausible, PredictError, PredictReport};

/// A filter that a log can be fed to.
pub trait Slam {
    /// Moves the vehicle; where no vehicle does that, leaves it where it is and says what is wrong.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn predict(&mut self, control: [f64; 2], dt_s: f64) -> Result<Option<Implausible>, Refusal>;

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

    /// The estimated moving features, at the time of the last prediction.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn moving(&mut self) -> Result<Vec<MovingFeature>, Refusal>;

    /// From now on weighs candidates with these threads, where the filter knows how to; its results do not depend on it.
    fn weigh_on(&mut self, _threads: &Threads) {}

    /// Hash of the complete state, where the filter has one.
    fn digest(&mut self) -> Option<u64>;

    /// Memory of the state, where it is fixed.
    fn state_bytes(&self) -> Option<u64>;
}

/// What was wrong with a prediction that the fixed-capacity filter leaves out.
pub(crate) fn left_out(outcome: Result<PredictReport, PredictError>) -> Result<Option<Implausible>, Refusal> {
    match outcome {
        Ok(_) => Ok(None),
        Err(PredictError::Implausible(what)) => Ok(Some(what)),
        Err(error) => Err(Refusal(error.to_string())),
    }
}

/// A filter that shows its whole state, for lockstep with the reference.
pub trait Transparent: Slam {
    /// The state as it stands.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn snapshot(&mut self) -> Result<Snapshot, Refusal>;
}

/// The state of a filter in the reference's terms.
pub struct Snapshot {
    /// Candidates, in order; weights sum to one.
    pub candidates: Vec<Candidate>,
    /// The static map of every particle.
    pub maps: Vec<Vec<Component>>,
    /// The moving part of the map of every particle, as of `waited_s` ago.
    pub moving: Vec<Vec<Component<4>>>,
    /// Summed dt of the predictions since the last scan, s.
    pub waited_s: f64,
    /// The particle whose map is the estimate.
    pub heaviest: usize,
    /// ln L of the candidates that the last scan weighed.
    pub ln_likelihoods: Vec<f64>,
    /// For every particle the candidate of the last scan that it continues.
    pub survivors: Vec<usize>,
    /// A copy of the random stream: gives the numbers that the filter will draw next.
    pub draws: Box<dyn Draws>,
}

impl core::fmt::Debug for Snapshot {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Snapshot")
            .field("candidates", &self.candidates)
            .field("maps", &self.maps)
            .field("moving", &self.moving)
            .field("waited_s", &self.waited_s)
            .field("heaviest", &self.heaviest)
            .finish_non_exhaustive()
    }
}

/// A pose (x m, y m, heading rad) and its covariance.
pub type PoseAndCovariance = ([f64; 3], [[f64; 3]; 3]);

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
    /// Conditions the filter reported; always good for the reference.
    pub health: scphd::Health,
}

/// A step that a filter refused, or settings it cannot work with.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Refusal(pub String);
