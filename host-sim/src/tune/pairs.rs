//! Which detection belongs to which feature, as seen from the predicted pose.

use crate::angle::wrap;
use crate::record::MapFeature;
use crate::settings::SensorSettings;
use nalgebra::{Matrix2x3, Matrix3, Vector2, Vector3};
use scphd::{PlanarPose, RangeBearing, Sensor, Symmetric};
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
    [x, y, heading]: [f64; 3],
    pose_covariance: &[[f64; 3]; 3],
    sensor: &RangeBearing<f64>,
    view: &SensorSettings,
    detections: &[[f64; 2]],
) -> (Vec<Pair>, Vec<Expectation>) {
    let (seat, by_vehicle) = seat([x, y, heading], view);
    let frame = sensor.frame(&seat);
    let noise = sensor.noise();
    let pose_covariance = Symmetric::<Vector3<f64>>::from_fn(|row, column| pose_covariance[row][column]);
    let mut candidates = Vec::new();
    let mut expected = Vec::new();
    for feature in map {
        let position = Vector2::from(feature.mean);
        let Some(seen) = sensor.expect(&frame, &position) else { continue };
        let [range, bearing] = seen.measurement.into();
        if !inside(view, range, bearing) {
            continue;
        }
        let by_pose = sensor.by_pose(&frame, &position, &seen) * by_vehicle;
        let of_feature = covariance(feature).congruence::<Vector2<f64>>(&seen.jacobian);
        let well_known = (0..2).all(|k| of_feature.get(k, k) <= WELL_KNOWN * noise.get(k, k));
        let place = expected.len();
        expected.push(Expectation { range_m: range, well_known, detected: false });
        let Some(spread) = noise.plus(&of_feature).plus(&pose_covariance.congruence(&by_pose)).factor() else {
            continue;
        };
        for (detection, &z) in detections.iter().enumerate() {
            let innovation = sensor.innovation(&z.into(), &seen.measurement);
            let distance = spread.mahalanobis(&innovation);
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

/// The pose of the sensor of a vehicle there, and its derivatives by the vehicle's.
fn seat([x, y, heading]: [f64; 3], view: &SensorSettings) -> (PlanarPose<f64>, Matrix3<f64>) {
    let [seat_x, seat_y, seat_heading] = view.mounting().seat([x, y, heading]);
    let by_heading = [y - seat_y, seat_x - x];
    let by_vehicle = Matrix3::new(1.0, 0.0, by_heading[0], 0.0, 1.0, by_heading[1], 0.0, 0.0, 1.0);
    (PlanarPose::new(seat_x, seat_y, seat_heading), by_vehicle)
}

fn covariance(feature: &MapFeature) -> Symmetric<Vector2<f64>> {
    Symmetric::from_fn(|row, column| feature.covariance[row][column])
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
    /// Covariance that the measurement's noise gives it, m².
    covariance: Symmetric<Vector2<f64>>,
}

impl Place {
    /// The place of a detection from that pose; none for one of no range.
    pub fn of(z: [f64; 2], pose: [f64; 3], sensor: &RangeBearing<f64>, view: &SensorSettings) -> Option<Self> {
        let inverse = sensor.invert(&sensor.frame(&seat(pose, view).0), &z.into())?;
        Some(Self { position: inverse.feature, covariance: sensor.noise().congruence(&inverse.jacobian) })
    }

    /// Whether a feature of the map may have caused it.
    pub fn explained_by(&self, map: &[MapFeature]) -> bool {
        map.iter().any(|feature| {
            let spread = self.covariance.plus(&covariance(feature)).factor();
            spread.is_some_and(|spread| spread.mahalanobis(&(self.position - Vector2::from(feature.mean))) <= GATE)
        })
    }
}
