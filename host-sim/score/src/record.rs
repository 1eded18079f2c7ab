//! The record of a run: a row for each scan and the final map, for scores, tables and plots.

use crate::map_error::MapError;
use crate::moving::ScanMatch;
use scphd_log::dimensions::{Coordinates, Covariance, Dimensions, Planar, distance};

/// A static feature of an estimated map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapFeature<D: Dimensions = Planar> {
    /// Label, the same from scan to scan.
    pub id: u32,
    /// Weight of its component: expected number of features.
    pub weight: f64,
    pub mean: D::Position,
    pub covariance: Covariance<D::Position>,
}

/// A moving feature of an estimated map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingFeature<D: Dimensions = Planar> {
    /// Label, the same from scan to scan; separate from those of static features.
    pub id: u32,
    /// Weight of its component: expected number of features.
    pub weight: f64,
    pub position: D::Position,
    pub velocity: D::Position,
    pub covariance: Covariance<D::Position>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct ScanRecord<D: Dimensions = Planar> {
    pub t_s: f64,
    pub pose: D::Pose,
    /// Covariance of the estimated pose, in the same order and units.
    pub pose_covariance: Covariance<D::Pose>,
    /// Pose by dead reckoning, with odometry or instruments.
    pub dead_reckoning: D::Reckoned,
    /// True position, if the truth covers this time.
    pub true_position: Option<D::Position>,
    /// Standard deviation of each coordinate of the true position, m.
    pub truth_sigma_m: f64,
    /// True heading, rad, if the truth has it.
    pub true_heading_rad: Option<f64>,
    pub measurements: usize,
    /// N̂, mass of the estimated map.
    pub features_estimated: f64,
    /// Effective number of particles before resampling.
    pub n_eff: f64,
    /// Use of the filter's memory, as far as it is reported.
    pub usage: Usage,
    /// Wall time of the scan step, µs.
    pub scan_us: f64,
    pub moving: Vec<MovingFeature<D>>,
    /// Distance of the estimated map, with moving features, to the true one; `None` without true landmarks or the true pose, and
    /// at scans for which it is not computed.
    pub map_error: Option<MapError>,
    /// Number of true static landmarks that have been in view so far; `None` likewise.
    pub landmarks_seen: Option<usize>,
    /// Match of the true moving landmarks in view; `None` without true tracks or the true pose.
    pub movers: Option<ScanMatch>,
}

/// Use of a filter's memory in a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Usage {
    /// Greatest number of components in view of a particle.
    pub in_view: usize,
    /// Measurements without an inverse in view, summed over all distinct particles.
    pub no_birth: usize,
    /// Number of pages of the map in use, if the filter has pages.
    pub pages_used: Option<usize>,
}

impl<D: Dimensions> ScanRecord<D> {
    pub fn position_error_m(&self) -> Option<f64> {
        Some(distance(&self.true_position?, &self.pose))
    }

    /// The root mean square position error that the filter expects, by the covariance of the estimate and the noise of the truth,
    /// m.
    pub fn expected_error_m(&self) -> f64 {
        let variances = self.pose_covariance.as_ref().iter().enumerate().take(D::Position::COUNT);
        let of_truth = self.truth_sigma_m * self.truth_sigma_m;
        variances.map(|(k, row)| row.as_ref()[k] + of_truth).sum::<f64>().sqrt()
    }

    pub fn dead_reckoning_error_m(&self) -> Option<f64> {
        Some(distance(&self.true_position?, &self.dead_reckoning))
    }
}

/// A whole run of one filter over one log.
#[derive(Debug, Clone, PartialEq)]
pub struct Record<D: Dimensions = Planar> {
    pub scans: Vec<ScanRecord<D>>,
    /// The estimated features after the last scan.
    pub map: Vec<MapFeature<D>>,
}

impl ScanRecord {
    /// A scan in the plane with only the estimated pose.
    pub fn at(t_s: f64, pose: [f64; 3]) -> Self {
        Self {
            t_s,
            pose,
            pose_covariance: [[0.0; 3]; 3],
            dead_reckoning: [0.0; 3],
            true_position: None,
            truth_sigma_m: 0.0,
            true_heading_rad: None,
            measurements: 0,
            features_estimated: 0.0,
            n_eff: 1.0,
            usage: Usage::default(),
            scan_us: 0.0,
            moving: Vec::new(),
            map_error: None,
            landmarks_seen: None,
            movers: None,
        }
    }
}
