//! What a run over an underwater log leaves behind: one row a frame and the final map.

use crate::score::map_error::MapError;

/// A feature of an estimated map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapFeature {
    /// Its name from frame to frame.
    pub id: u32,
    /// Weight of its component: expected number of features there.
    pub weight: f64,
    /// Position, m.
    pub mean: [f64; 3],
    /// Covariance, m².
    pub covariance: [[f64; 3]; 3],
}

/// One frame of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameRecord {
    /// Time, s.
    pub t_s: f64,
    /// Estimated pose: x m, y m, z m, yaw rad, yaw rate rad/s.
    pub pose: [f64; 5],
    /// Covariance of the estimated pose, in the same order and units.
    pub pose_covariance: [[f64; 5]; 5],
    /// Position by dead reckoning, m.
    pub dead_reckoning: [f64; 3],
    /// True position, m, where the truth covers this time.
    pub true_position: Option<[f64; 3]>,
    /// True yaw, rad.
    pub true_yaw_rad: Option<f64>,
    /// Number of measurements.
    pub measurements: usize,
    /// N̂: mass of the estimated map.
    pub features_estimated: f64,
    /// Effective number of particles before resampling.
    pub n_eff: f64,
    /// Greatest number of components in view of a particle.
    pub in_view: usize,
    /// Measurements without an inverse in view, over all distinct particles.
    pub no_birth: usize,
    /// Pages of the map in use, where the filter has pages.
    pub pages_used: Option<usize>,
    /// Wall time of the scan step, µs.
    pub scan_us: f64,
    /// Distance of the estimated map to the true features seen so far; at some frames only.
    pub map_error: Option<MapError>,
}

/// A whole run of one filter over one log.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// One row a frame.
    pub frames: Vec<FrameRecord>,
    /// The estimated features after the last frame.
    pub map: Vec<MapFeature>,
}

/// Distance between two positions, m.
#[must_use]
pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum::<f64>().sqrt()
}

/// Position of a frame's estimate, m.
#[must_use]
pub fn position(frame: &FrameRecord) -> [f64; 3] {
    [frame.pose[0], frame.pose[1], frame.pose[2]]
}
