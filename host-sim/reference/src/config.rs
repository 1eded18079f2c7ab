//! Parameters of the recursion, and the result of a scan.

use super::resample::Selection;
use serde::{Deserialize, Serialize};

/// The particle likelihood: see `docs/recursion.md`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Likelihood {
    /// Single cluster (4.52).
    SingleCluster,
    /// RB-PHD with the empty map.
    RbEmpty,
    /// RB-PHD with a single feature.
    RbSingle,
    /// RB-PHD with several features.
    RbMulti,
}

/// Parameters of the recursion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    /// N, number of particles.
    pub particles: usize,
    /// M, candidates drawn for each particle between scans.
    pub samples: usize,
    /// w_b, intensity of births on a measurement, 1/(m·rad).
    pub birth_intensity: f64,
    /// κ, intensity of false measurements, 1/(m·rad).
    pub clutter_intensity: f64,
    /// The candidates are resampled if N_eff is below this fraction of their number.
    pub resample_threshold: f64,
    /// Components lighter than this are dropped.
    pub prune_weight: f64,
    /// Squared Mahalanobis distance up to which components are merged.
    pub merge_distance: f64,
    /// Greatest number of components of each kind in view after the reduction, for each particle; births that wait for the next
    /// scan are not counted.
    pub max_components: usize,
    /// Weights of confirmed components after misses.
    pub remembering: Remembering,
    /// Components with less weight are not estimated features.
    pub extraction_weight: f64,
    pub likelihood: Likelihood,
    pub moving: MovingConfig,
}

/// Weights of confirmed static components after misses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Remembering {
    /// Number of measurements: a component is confirmed if its covariance is smaller than after this many.
    pub detections: f64,
    /// Least weight of a confirmed component after misses; 0: no lower bound, as in the thesis.
    pub weight: f64,
}

impl Remembering {
    /// No lower bound.
    pub const NOTHING: Self = Self { detections: 1.0, weight: 0.0 };
}

/// The weights of the candidates after the measurements.
#[derive(Debug, Clone, PartialEq)]
pub struct Weighing {
    /// ln L of each candidate (4.52, or that of the other likelihood), without the clutter rate λ.
    pub ln_likelihoods: Vec<f64>,
    /// ln ζ of each candidate after the scan, normalised (5.23).
    pub ln_weights: Vec<f64>,
    /// N_eff = 1/Σ ζ².
    pub n_eff: f64,
    /// Whether ζ L was zero for every candidate, so that the weights were not changed.
    pub weights_kept: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub struct ScanOutcome {
    pub weighing: Weighing,
    pub selection: Selection,
}

/// Motion, births and survival of moving features.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingConfig {
    /// w_m, intensity of births of moving features on a measurement, 1/(m·rad); 0: no births.
    pub birth_intensity: f64,
    /// σ_v, standard deviation of each coordinate of a new feature's velocity, m/s.
    pub velocity_sigma_mps: f64,
    /// q, spectral density of the acceleration, m²/s³.
    pub acceleration_psd: f64,
    /// τ, mean lifetime, s; infinite: they never disappear.
    pub lifetime_s: f64,
    /// Components are dropped if a coordinate of their position has a greater standard deviation, m.
    pub spread_max_m: f64,
    /// Least weight of an estimated moving feature.
    pub extraction_weight: f64,
}
