//! What a run leaves behind: one row a scan and the final map, for scores, tables and plots.

use crate::score::map_error::MapError;
use crate::score::moving::ScanMatch;

/// A static feature of an estimated map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapFeature {
    /// Its name from scan to scan.
    pub id: u32,
    /// Weight of its component: expected number of features there.
    pub weight: f64,
    /// Position, m.
    pub mean: [f64; 2],
    /// Covariance, m².
    pub covariance: [[f64; 2]; 2],
}

/// A moving feature of an estimated map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingFeature {
    /// Its name from scan to scan, apart from those of static features.
    pub id: u32,
    /// Weight of its component: expected number of features there.
    pub weight: f64,
    /// Position, m.
    pub position: [f64; 2],
    /// Velocity, m/s.
    pub velocity: [f64; 2],
    /// Covariance of the position, m².
    pub covariance: [[f64; 2]; 2],
}

/// One scan of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanRecord {
    /// Time, s.
    pub t_s: f64,
    /// Estimated pose: x m, y m, heading rad.
    pub pose: [f64; 3],
    /// Covariance of the estimated pose, in the same order and units.
    pub pose_covariance: [[f64; 3]; 3],
    /// Pose by odometry alone.
    pub dead_reckoning: [f64; 3],
    /// True position, where the truth covers this time.
    pub true_position: Option<[f64; 2]>,
    /// True heading, rad, where the truth has it.
    pub true_heading_rad: Option<f64>,
    /// Number of measurements.
    pub measurements: usize,
    /// N̂: mass of the estimated map.
    pub features_estimated: f64,
    /// Effective number of particles before resampling.
    pub n_eff: f64,
    /// Wall time of the scan step, µs.
    pub scan_us: f64,
    /// The estimated moving features.
    pub moving: Vec<MovingFeature>,
    /// Distance of the estimated map, moving features included, to the true one; unknown without true landmarks or
    /// the true pose.
    pub map_error: Option<MapError>,
    /// Which true movers in view were found; unknown without true tracks or the true pose.
    pub movers: Option<ScanMatch>,
}

/// A whole run of one filter over one log.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// One row a scan.
    pub scans: Vec<ScanRecord>,
    /// The estimated features after the last scan.
    pub map: Vec<MapFeature>,
}
