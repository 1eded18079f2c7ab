//! Which detection belongs to which feature, as seen from the predicted pose.

use super::variances;
use crate::angle::wrap;
use crate::record::MapFeature;
use crate::settings::SensorSettings;
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2};
use std::f64::consts::PI;

/// Squared Mahalanobis distance within which a detection may belong to a feature: wide, for the noise is what is sought.
const GATE: f64 = 25.0;
/// A feature is well known where it adds no more than this share of the measurement's variance.
const WELL_KNOWN: f64 = 0.25;

/// A detection and the feature it belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Place of the detection in the scan.
    pub detection: usize,
    /// z ⊖ ẑ, m and rad.
    pub innovation: Vector2<f64>,
    /// ∂ẑ/∂x.
    pub by_pose: Matrix2x3<f64>,
    /// The feature itself hardly adds to the innovation.
    pub well_known: bool,
}

/// A feature in view: how far away, and whether it was detected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expectation {
    /// Expected range, m.
    pub range_m: f64,
    /// Seen often enough not to be a false measurement that was taken for a feature.
    pub well_known: bool,
    /// Whether a detection belongs to it.
    pub detected: bool,
}

/// Pairs, the nearest first, and what was to be expected well inside of the view.
pub fn pairs(
    map: &[MapFeature],
    pose: [f64; 3],
    pose_covariance: &[[f64; 3]; 3],
    sensor: &SensorSettings,
    detections: &[[f64; 2]],
) -> (Vec<Pair>, Vec<Expectation>) {
    let noise = Matrix2::from_diagonal(&Vector2::from(variances(sensor)));
    let pose_covariance = Matrix3::from_fn(|row, column| pose_covariance[row][column]);
    let mut candidates = Vec::new();
    let mut expected = Vec::new();
    for feature in map {
        let (dx, dy) = (feature.mean[0] - pose[0], feature.mean[1] - pose[1]);
        let squared = dx * dx + dy * dy;
        let range = squared.sqrt();
        let bearing = wrap(dy.atan2(dx) - pose[2]);
        if !inside(sensor, range, bearing) {
            continue;
        }
        let by_feature = Matrix2::new(dx / range, dy / range, -dy / squared, dx / squared);
        let by_pose = Matrix2x3::new(-dx / range, -dy / range, 0.0, dy / squared, -dx / squared, -1.0);
        let covariance = Matrix2::from_fn(|row, column| feature.covariance[row][column]);
        let of_feature = by_feature * covariance * by_feature.transpose();
        let innovation_covariance = noise + of_feature + by_pose * pose_covariance * by_pose.transpose();
        let well_known = (0..2).all(|k| of_feature[(k, k)] <= WELL_KNOWN * noise[(k, k)]);
        let place = expected.len();
        expected.push(Expectation { range_m: range, well_known, detected: false });
        let Some(inverse) = innovation_covariance.try_inverse() else { continue };
        for (detection, z) in detections.iter().enumerate() {
            let innovation = Vector2::new(z[0] - range, wrap(z[1] - bearing));
            let distance = innovation.dot(&(inverse * innovation));
            if distance <= GATE {
                candidates.push((distance, place, Pair { detection, innovation, by_pose, well_known }));
            }
        }
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut found: Vec<Pair> = Vec::new();
    for (_, place, pair) in candidates {
        if !expected[place].detected && found.iter().all(|other| other.detection != pair.detection) {
            expected[place].detected = true;
            found.push(pair);
        }
    }
    (found, expected)
}

/// Whether a feature there is so far inside of the view that its soft edges do not matter.
fn inside(sensor: &SensorSettings, range: f64, bearing: f64) -> bool {
    let edge = sensor.range_edge_m.max(2.0 * sensor.range_sigma_m);
    let full_circle = sensor.bearing_half_width_rad() >= PI;
    let aside = wrap(bearing - sensor.bearing_center_rad()).abs();
    range > sensor.range_min_m + edge
        && range < sensor.range_max_m - edge
        && (full_circle || aside < sensor.bearing_half_width_rad() - sensor.bearing_edge_rad)
}

/// Where a detection was seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    position: Vector2<f64>,
    /// ∂position/∂z.
    jacobian: Matrix2<f64>,
}

impl Place {
    /// The place of a detection from that pose.
    pub fn of(z: [f64; 2], pose: [f64; 3]) -> Self {
        let (sin, cos) = (pose[2] + z[1]).sin_cos();
        Self {
            position: Vector2::new(pose[0] + z[0] * cos, pose[1] + z[0] * sin),
            jacobian: Matrix2::new(cos, -z[0] * sin, sin, z[0] * cos),
        }
    }

    /// Whether a feature of the map may have caused it.
    pub fn explained_by(&self, map: &[MapFeature], sensor: &SensorSettings) -> bool {
        let noise = Matrix2::from_diagonal(&Vector2::from(variances(sensor)));
        let own = self.jacobian * noise * self.jacobian.transpose();
        map.iter().any(|feature| {
            let covariance = own + Matrix2::from_fn(|row, column| feature.covariance[row][column]);
            let offset = self.position - Vector2::from(feature.mean);
            covariance.try_inverse().is_some_and(|inverse| offset.dot(&(inverse * offset)) <= GATE)
        })
    }
}
