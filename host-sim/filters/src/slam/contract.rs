//! The interface of a SLAM filter for the simulator.

use super::stage_times::STAGES;
use crate::threads::Threads;
use scphd::PredictReport;
use scphd::errors::{Implausible, PredictError};
use scphd_log::dimensions::{Covariance, Dimensions, Planar};
use scphd_score::record::{MapFeature, MovingFeature, Usage};

/// A filter that processes logs.
pub trait Slam<D: Dimensions = Planar> {
    /// Predicts the motion. An implausible motion is left out, and the reason returned.
    fn predict(&mut self, control: D::Control, dt_s: f64) -> Result<Option<Implausible>, Refusal>;

    /// Processes a measurement of the pose. Returns whether it was within its gate.
    fn observe(&mut self, _fix: &D::Fix) -> Result<bool, Refusal> {
        Err(refusal("it takes no fixes of the pose; core, joint and ekf do"))
    }

    /// Sets the pose by fixes, with its covariance; the map is not changed.
    fn relocate(&mut self, _pose: &D::Pose, _covariance: &Covariance<D::Pose>) -> Result<(), Refusal> {
        Err(refusal("it takes no fixes of the pose; core, joint and ekf do"))
    }

    /// Starts again at a pose by fixes, with its covariance and an empty map, because the map was in a wrong frame.
    fn restart(&mut self, _pose: &D::Pose, _covariance: &Covariance<D::Pose>) -> Result<(), Refusal> {
        Err(refusal("it takes no fixes of the pose; core, joint and ekf do"))
    }

    /// Processes a scan of the sensor with this index.
    fn scan(&mut self, sensor: usize, detections: &[D::Measurement]) -> Result<ScanOutcome, Refusal>;

    fn pose(&mut self) -> Result<PoseAndCovariance<D>, Refusal>;

    /// N̂ and the estimated features.
    fn map(&mut self) -> Result<(f64, Vec<MapFeature<D>>), Refusal>;

    /// The estimated moving features, at the time of the last prediction; none for a filter without moving features.
    fn moving(&mut self) -> Result<Vec<MovingFeature<D>>, Refusal> {
        Ok(Vec::new())
    }

    /// Poses and weights of the particles; none for a filter without particles.
    fn particles(&mut self) -> Result<Vec<(D::Pose, f64)>, Refusal> {
        Ok(Vec::new())
    }

    /// Uses these threads from now on, if the filter supports it; results do not depend on them.
    fn work_on(&mut self, _threads: &Threads) {}

    /// Starts in a map made by [`map_file`](Self::map_file): with the pose of the log, or with global localisation if it is not
    /// known.
    fn start_in(&mut self, _file: &[u8], _pose_is_known: bool) -> Result<(), Refusal> {
        Err(refusal("only a joint map in the plane starts in a map"))
    }

    /// The estimated map in bytes, for the next drive.
    fn map_file(&mut self) -> Result<Vec<u8>, Refusal> {
        Err(refusal("only a joint map in the plane can be saved"))
    }

    /// Result of the global localisation; `None` if there was none.
    fn search(&self) -> Option<Search> {
        None
    }

    /// Hash of the complete state, if the filter has one.
    fn digest(&mut self) -> Option<u64> {
        None
    }

    /// Size of the state, bytes, if it is fixed.
    fn state_bytes(&self) -> Option<u64> {
        None
    }
}

/// Result of the global localisation of a vehicle in a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Number of scans until its end.
    pub scans: usize,
    /// The place, if it was found.
    pub found: Option<FoundPlace>,
    /// Probability at its end that the vehicle is outside the map.
    pub elsewhere: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundPlace {
    /// x and y, m, and heading, rad.
    pub pose: [f64; 3],
    /// The probability that the vehicle is there.
    pub probability: f64,
    /// Number of its landmarks that are in the map.
    pub matched: usize,
}

/// The reason for which the fixed-capacity filter left out a prediction.
pub(super) fn left_out(outcome: Result<PredictReport, PredictError>) -> Result<Option<Implausible>, Refusal> {
    match outcome {
        Ok(_) => Ok(None),
        Err(PredictError::Implausible(what)) => Ok(Some(what)),
        Err(error) => Err(refusal(error)),
    }
}

pub type PoseAndCovariance<D = Planar> = (<D as Dimensions>::Pose, Covariance<<D as Dimensions>::Pose>);

/// Result of a scan, as far as the filter reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanOutcome {
    /// Effective number of particles before resampling.
    pub n_eff: f64,
    /// Whether the particles were resampled.
    pub resampled: bool,
    /// Log likelihood of the scan given all before, up to a constant; `None` if the filter does not report it.
    pub ln_evidence: Option<f64>,
    /// Mean squared innovation divided by its expected value, 1 if the models are right; `None` without detections, or if the
    /// filter does not report it.
    pub innovation: Option<f64>,
    /// Use of the filter's memory.
    pub usage: Usage,
    /// Reported conditions; always good for the reference.
    pub health: scphd::Health,
    /// Wall time of every stage, µs, without nested stages; `None` if the filter has no stages.
    pub stages_us: Option<[f64; STAGES]>,
}

impl ScanOutcome {
    /// The outcome of a filter that reports nothing.
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

/// Why a filter refused a step or its settings.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Refusal(pub String);

pub fn refusal(error: impl core::fmt::Display) -> Refusal {
    Refusal(error.to_string())
}

/// The refusal of a precision for which the filters are not compiled.
pub fn not_built() -> Refusal {
    Refusal("double precision is not compiled: build the program with `--features f64`".to_owned())
}

/// The refusal of a scan of a sensor without settings.
pub(crate) fn no_sensor(sensor: usize) -> Refusal {
    Refusal(format!("no settings of sensor {}", sensor + 1))
}
