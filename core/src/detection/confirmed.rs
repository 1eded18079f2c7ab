//! Confirmation of features: their covariance is smaller than the first few measurements alone can make it.

use crate::models::noise_at;
use crate::{Component, CovarianceOf, Pose, PositionOf, Real, Sensor, Vector};

/// The threshold for det S / det R in one dimension: half way between the values after k measurements, 1 + 1/k, and after k + 1.
fn middle<T: Real>(detections: T) -> T {
    let half = T::from_f64(0.5);
    T::ONE + half / detections + half / (detections + T::ONE)
}

/// Whether the covariance of a component is smaller than `detections` measurements from this pose would leave it; the covariance
/// of the pose adds to the noise R. One measurement leaves H P Hᵀ = R, k leave R/k: det S, with S = H P Hᵀ + R, is compared with
/// a threshold between the values for k and k + 1. `None` if the sensor cannot measure the component from here: callers that
/// remove components then keep it, and callers that extract it do not.
pub(crate) fn is_confirmed<T: Real, S: Sensor<Pose: Pose<Scalar = T>>, N: Vector<Scalar = T>>(
    sensor: &S,
    frame: &S::Frame,
    pose_covariance: Option<&CovarianceOf<S::Pose>>,
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

    /// The covariance R/k that k measurements from one pose leave, with and without a covariance of the pose.
    #[test]
    fn confirmation_needs_more_than_k_measurements() {
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
