//! What a SLAM filter is to the simulator.

use super::stage_times::STAGES;
use crate::threads::Threads;
use scphd::PredictReport;
use scphd::errors::{Implausible, PredictError};
use scphd_log::dimensions::{Covariance, Dimensions, Planar};
use scphd_score::record::{MapFeature, MovingFeature, Usage};

/// A filter that a log can be fed to.
pub trait Slam<D: Dimensions = Planar> {
    /// Moves the vehicle; where no vehicle does that, leaves it where it is and says what is wrong.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn predict(&mut self, control: D::Control, dt_s: f64) -> Result<Option<Implausible>, Refusal>;

    /// Takes in a measurement of the pose itself: whether it was within its gate.
    ///
    /// # Errors
    /// The filter refused, and says why; one that does not know fixes always does.
    fn observe(&mut self, _fix: &D::Fix) -> Result<bool, Refusal> {
        Err(refusal("it takes no fixes of the pose; core, joint and ekf do"))
    }

    /// Puts the vehicle to a pose that fixes have told, with its covariance; the map stays as it is.
    ///
    /// # Errors
    /// The filter refused, and says why; one that does not know fixes always does.
    fn relocate(&mut self, _pose: &D::Pose, _covariance: &Covariance<D::Pose>) -> Result<(), Refusal> {
        Err(refusal("it takes no fixes of the pose; core, joint and ekf do"))
    }

    /// Starts anew at a pose that fixes have told, with its covariance and without a map: what was mapped lies in a wrong frame.
    ///
    /// # Errors
    /// As for [`relocate`](Self::relocate).
    fn restart(&mut self, _pose: &D::Pose, _covariance: &Covariance<D::Pose>) -> Result<(), Refusal> {
        Err(refusal("it takes no fixes of the pose; core, joint and ekf do"))
    }

    /// Takes in a scan of the sensor of this number.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn scan(&mut self, sensor: usize, detections: &[D::Measurement]) -> Result<ScanOutcome, Refusal>;

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

    /// Poses and weights of the particles; none where the filter has no such thing.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn particles(&mut self) -> Result<Vec<(D::Pose, f64)>, Refusal> {
        Ok(Vec::new())
    }

    /// From now on works on these threads, where the filter knows how to; its results do not depend on it.
    fn work_on(&mut self, _threads: &Threads) {}

    /// Starts in a map that [`map_file`](Self::map_file) made: with the pose of the log, or where that is not known, by looking for it.
    ///
    /// # Errors
    /// The filter has no such maps, or the file is none of its own.
    fn start_in(&mut self, _file: &[u8], _pose_is_known: bool) -> Result<(), Refusal> {
        Err(refusal("only a joint map in the plane starts in a map"))
    }

    /// The estimated map as bytes, for the next drive.
    ///
    /// # Errors
    /// The filter has no such maps.
    fn map_file(&mut self) -> Result<Vec<u8>, Refusal> {
        Err(refusal("only a joint map in the plane can be saved"))
    }

    /// How the search for the place in the map went; `None` where there was none.
    fn search(&self) -> Option<Search> {
        None
    }

    /// Hash of the complete state, where the filter has one.
    fn digest(&mut self) -> Option<u64> {
        None
    }

    /// Memory of the state, where it is fixed.
    fn state_bytes(&self) -> Option<u64> {
        None
    }
}

/// How the search for a vehicle's place in a map went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Scans that were taken in while it went on.
    pub scans: usize,
    /// The place, once it is found.
    pub found: Option<FoundPlace>,
    /// The probability that the vehicle is where the map has nothing, at the end of it.
    pub elsewhere: f64,
}

/// A place in a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundPlace {
    /// x and y, m, and heading, rad.
    pub pose: [f64; 3],
    /// The probability that the vehicle is there.
    pub probability: f64,
    /// Landmarks that it had found and the map has.
    pub matched: usize,
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
    /// Wall time of every stage, µs, without those inside it; `None` where the filter has no such stages.
    pub stages_us: Option<[f64; STAGES]>,
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
        stages_us: None,
    };
}

/// A step that a filter refused, or settings it cannot work with.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Refusal(pub String);

/// What was said against it.
pub fn refusal(error: impl core::fmt::Display) -> Refusal {
    Refusal(error.to_string())
}

/// A scan of a sensor that the settings do not know.
pub(crate) fn no_sensor(sensor: usize) -> Refusal {
    Refusal(format!("no settings of sensor {}", sensor + 1))
}
