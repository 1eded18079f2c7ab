//! Association of detections with features, as seen from the predicted pose.

use super::learn::Eye;
use nalgebra::{DMatrix, DVector};
use scphd_log::dimensions::{Coordinates, Covariance, Dimensions};
use scphd_score::record::MapFeature;

/// Squared Mahalanobis distance of the gate: wide, because the noise is to be estimated.
const GATE: f64 = 25.0;
/// Greatest share of the measurement's variance that the covariance of a well known feature adds.
const WELL_KNOWN: f64 = 0.25;

/// A detection and its feature.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// Index of the detection in the scan.
    pub detection: usize,
    /// z ⊖ ẑ.
    pub innovation: DVector<f64>,
    /// ∂ẑ/∂x.
    pub by_pose: DMatrix<f64>,
    /// R.
    pub noise: DMatrix<f64>,
    /// Whether the covariance of the feature is negligible.
    pub well_known: bool,
}

/// A feature in view, and whether it was detected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expectation {
    /// Expected range, m.
    pub range_m: f64,
    /// Whether its covariance is negligible, as after many detections; then it is not clutter.
    pub well_known: bool,
    /// Whether a detection is associated with it.
    pub detected: bool,
}

pub(super) fn matrix<C: Coordinates>(covariance: &Covariance<C>) -> DMatrix<f64> {
    DMatrix::from_fn(C::COUNT, C::COUNT, |row, column| covariance.as_ref()[row].as_ref()[column])
}

/// The pairs, the nearest first, and the features that were expected well inside the view.
pub fn pairs<D: Dimensions>(
    eye: &dyn Eye<D>,
    scan: usize,
    map: &[MapFeature<D>],
    (pose, pose_covariance): &(D::Pose, Covariance<D::Pose>),
    detections: &[D::Measurement],
) -> (Vec<Pair>, Vec<Expectation>) {
    let pose_covariance = matrix::<D::Pose>(pose_covariance);
    let mut candidates = Vec::new();
    let mut expected = Vec::new();
    for feature in map {
        let Some(seen) = eye.expect(scan, pose, &feature.mean) else { continue };
        let Some(range_m) = eye.inside(&seen.measurement) else { continue };
        let noise = eye.noise(&seen.measurement);
        let of_feature = &seen.by_place * matrix::<D::Position>(&feature.covariance) * seen.by_place.transpose();
        let well_known = (0..noise.nrows()).all(|k| of_feature[(k, k)] <= WELL_KNOWN * noise[(k, k)]);
        let place = expected.len();
        expected.push(Expectation { range_m, well_known, detected: false });
        let spread = &noise + of_feature + &seen.by_pose * &pose_covariance * seen.by_pose.transpose();
        let Some(precision) = spread.cholesky().map(|spread| spread.inverse()) else { continue };
        for (detection, z) in detections.iter().enumerate() {
            let innovation = eye.innovation(z, &seen.measurement);
            let distance = innovation.dot(&(&precision * &innovation));
            if distance <= GATE {
                let pair =
                    Pair { detection, innovation, by_pose: seen.by_pose.clone(), noise: noise.clone(), well_known };
                candidates.push((distance, place, pair));
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

/// Whether a feature of the map may have caused a detection at this position, with this covariance by its noise.
pub fn is_explained<D: Dimensions>((place, covariance): &(D::Position, DMatrix<f64>), map: &[MapFeature<D>]) -> bool {
    map.iter().any(|feature| {
        let apart = DVector::from_fn(D::Position::COUNT, |k, _| place.as_ref()[k] - feature.mean.as_ref()[k]);
        let spread = (covariance + matrix::<D::Position>(&feature.covariance)).cholesky();
        spread.is_some_and(|spread| apart.dot(&spread.solve(&apart)) <= GATE)
    })
}
