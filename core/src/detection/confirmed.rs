//! Confirmation of features: their covariance is smaller than the first few measurements alone can make it.

use crate::models::noise_at;
use crate::{Component, Pose, PositionOf, Real, Sensor, Symmetric, TangentOf, Vector};

/// (S / R) in one dimension half way between what so many measurements leave, 1 + 1/k, and what one more does.
fn middle<T: Real>(detections: T) -> T {
    let half = T::from_f64(0.5);
    T::ONE + half / detections + half / (detections + T::ONE)
}

/// Whether a component is better known than from `detections` measurements taken from here, by a pose of that covariance,
/// which blurs them. One measurement leaves H P Hᵀ = R, k leave R/k; the determinant of S = H P Hᵀ + R is compared with what
/// lies between k and k + 1. `None` where that cannot be told, for the sensor expects nothing from there: who forgets and who extracts
/// are then on opposite safe sides.
pub(crate) fn is_confirmed<T: Real, S: Sensor<Pose: Pose<Scalar = T>>, N: Vector<Scalar = T>>(
    sensor: &S,
    frame: &S::Frame,
    pose_covariance: Option<&Symmetric<TangentOf<S::Pose>>>,
    component: &Component<N>,
    detections: T,
) -> Option<bool> {
    let position = component.position::<PositionOf<S::Pose>>();
    let expected = sensor.expect(frame, &position)?;
    let mut noise = noise_at(sensor, &expected.measurement);
    if let Some(pose_covariance) = pose_covariance {
        noise = noise.plus(&pose_covariance.congruence::<S::Measurement>(&sensor.by_pose(frame, &position, &expected)));
    }
    let known = component.covariance.leading::<PositionOf<S::Pose>>();
    let innovation = known.congruence::<S::Measurement>(&expected.jacobian).plus(&noise);
    let (innovation, noise) = (innovation.factor()?, noise.factor()?);
    let known_dimensions = PositionOf::<S::Pose>::DIMENSION.min(S::Measurement::DIMENSION);
    let bound = (0..known_dimensions).fold(noise.determinant(), |det, _| det * middle(detections));
    Some(innovation.determinant() < bound)
}

#[cfg(test)]
mod tests {
    use super::is_confirmed;
    use crate::{Component, PlanarPose, RangeBearing, Sensor, Symmetric};

    /// What k measurements from one certain or uncertain pose leave of R, seen from that pose.
    #[test]
    fn as_many_measurements_as_asked_for_are_not_enough_and_one_more_is() {
        let sensor = RangeBearing::new(0.8_f64, 0.005).unwrap();
        let frame = sensor.frame(&PlanarPose::new(3.0, -4.0, 0.7));
        let blur = Symmetric::from_diagonal([0.04, 0.02, 1e-5]);
        for z in [[5.0, 1.4], [149.0, -0.3]] {
            let inverse = sensor.invert(&frame, &z.into()).unwrap();
            let expected = sensor.expect(&frame, &inverse.feature).unwrap();
            for pose_covariance in [None, Some(&blur)] {
                let by_pose = sensor.by_pose(&frame, &inverse.feature, &expected);
                let noise = sensor.noise().plus(&pose_covariance.unwrap_or(&Symmetric::ZERO).congruence(&by_pose));
                for k in 1..6_u32 {
                    let covariance = noise.congruence(&inverse.jacobian).scaled(1.0 / f64::from(k));
                    let component = Component { mean: inverse.feature, covariance, ..Component::ZERO };
                    let confirmed =
                        |by: u32| is_confirmed(&sensor, &frame, pose_covariance, &component, f64::from(by)).unwrap();
                    assert!(!confirmed(k) && (k == 1 || confirmed(k - 1)), "{z:?} {k}");
                }
            }
        }
    }
}
