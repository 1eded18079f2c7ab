//! Range and bearing in the plane (5.28).

use super::{Expected, ExpectedOf, Inverse, InverseOf, ModelError, PlanarPose, Sensor, require};
use crate::{Real, Symmetric, wrap};
use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

/// A detection occludes a landmark if it is nearer by more than this many standard deviations of the range, and within as many of
/// the bearing in direction.
const OCCLUSION_SIGMAS: f64 = 3.0;

/// A sensor that measures range (m) and bearing (rad, 0 ahead, positive to the left) of a feature in the plane.
///
/// ```
/// use scphd::models::{PlanarPose, RangeBearing, Sensor};
/// use nalgebra::Vector2;
///
/// let laser = RangeBearing::new(0.25_f32, 0.01)?;
/// let frame = laser.frame(&PlanarPose::new(1.0, 0.0, 0.0));
/// let seen = laser.expect(&frame, &Vector2::new(1.0, 2.0)).unwrap();
/// assert_eq!(seen.measurement, Vector2::new(2.0, core::f32::consts::FRAC_PI_2));
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeBearing<T: Real> {
    noise: Symmetric<Vector2<T>>,
}

/// A planar pose with the sine and cosine of its heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanarFrame<T> {
    /// Position, m.
    pub position: Vector2<T>,
    /// Heading, rad.
    pub heading_rad: T,
    /// Sine of the heading.
    pub sine: T,
    /// Cosine of the heading.
    pub cosine: T,
}

impl<T: Real> PlanarFrame<T> {
    /// ∂h/∂x of any sensor fixed to the vehicle, from H = ∂h/∂m: a translation of the vehicle has the effect of the opposite
    /// translation of the feature, and a rotation of the vehicle that of the opposite rotation of the feature about the vehicle.
    #[inline]
    #[must_use]
    pub fn by_pose<const Z: usize>(&self, by_feature: &SMatrix<T, Z, 2>, feature: &SVector<T, 2>) -> SMatrix<T, Z, 3> {
        let [[dx, dy]] = (feature - self.position).data.0;
        let moves = SMatrix::<T, 2, 3>::new(-T::ONE, T::ZERO, dy, T::ZERO, -T::ONE, -dx);
        by_feature * moves
    }

    /// The frame of a pose.
    pub fn of(pose: &PlanarPose<T>) -> Self {
        let (sine, cosine) = pose.heading_rad.sin_cos();
        Self { position: Vector2::new(pose.x_m, pose.y_m), heading_rad: pose.heading_rad, sine, cosine }
    }
}

impl<T: Real> RangeBearing<T> {
    /// A sensor with independent noise of these standard deviations, m and rad.
    ///
    /// # Errors
    /// Both must lie between 1e-6 and 1e6: beyond, their squares leave the range of single precision.
    pub fn new(range_sigma_m: T, bearing_sigma_rad: T) -> Result<Self, ModelError> {
        let usable = |sigma: T| sigma >= T::from_f64(1e-6) && sigma <= T::from_f64(1e6);
        require(usable(range_sigma_m), "range_sigma_m", "between 1e-6 and 1e6 m")?;
        require(usable(bearing_sigma_rad), "bearing_sigma_rad", "between 1e-6 and 1e6 rad")?;
        let variances = [range_sigma_m * range_sigma_m, bearing_sigma_rad * bearing_sigma_rad];
        Ok(Self { noise: Symmetric::from_diagonal(variances) })
    }
}

impl<T: Real> Sensor for RangeBearing<T> {
    type Pose = PlanarPose<T>;
    type Measurement = Vector2<T>;
    type Frame = PlanarFrame<T>;

    const SORTED_BY: usize = 1;
    const SORTED_BY_ANGLE: bool = true;
    const SIFTED_BY: Option<usize> = Some(0);

    fn frame(&self, pose: &Self::Pose) -> Self::Frame {
        PlanarFrame::of(pose)
    }

    /// The prediction ẑ of (5.28), with the bearing relative to the heading. The Jacobian is that with respect to the feature.
    #[inline(always)]
    fn expect(&self, frame: &Self::Frame, feature: &SVector<T, 2>) -> Option<ExpectedOf<Self>> {
        let [[dx, dy]] = (feature - frame.position).data.0;
        let squared = dx * dx + dy * dy;
        // At the sensor itself the bearing has no derivative. The comparison is written so that NaN gives `None` too. A feature
        // at infinity is out of every field of view.
        if !(squared > T::ZERO) {
            return None;
        }
        let per_range = squared.inverse_sqrt();
        let bearing = wrap(dy.atan2(dx) - frame.heading_rad);
        let (along, across) = (dx * per_range, dy * per_range);
        Some(Expected {
            measurement: Vector2::new(squared * per_range, bearing),
            jacobian: Matrix2::new(along, across, -across * per_range, along * per_range),
        })
    }

    #[inline(always)]
    fn innovation(&self, measured: &SVector<T, 2>, expected: &SVector<T, 2>) -> SVector<T, 2> {
        let [[range, bearing]] = (measured - expected).data.0;
        Vector2::new(range, wrap(bearing))
    }

    /// Whether a detection is nearer than the prediction by more than three standard deviations of the range, and in the same
    /// direction within three standard deviations of the bearing.
    fn occludes(&self, measured: &SVector<T, 2>, expected: &SVector<T, 2>) -> bool {
        let [[range, bearing]] = self.innovation(measured, expected).data.0;
        let sigmas = T::from_f64(OCCLUSION_SIGMAS * OCCLUSION_SIGMAS);
        range < T::ZERO
            && range * range > sigmas * self.noise.get(0, 0)
            && bearing * bearing < sigmas * self.noise.get(1, 1)
    }

    fn noise(&self) -> &Symmetric<Vector2<T>> {
        &self.noise
    }

    /// h⁻¹ and H* of (5.9), (5.10). A measurement with a range of zero or less has no inverse.
    fn invert(&self, frame: &Self::Frame, measured: &SVector<T, 2>) -> Option<InverseOf<Self>> {
        let [[range, bearing]] = measured.data.0;
        if !(range > T::ZERO) {
            return None;
        }
        let (s, c) = bearing.sin_cos();
        let sine = frame.sine * c + frame.cosine * s;
        let cosine = frame.cosine * c - frame.sine * s;
        Some(Inverse {
            feature: frame.position + Vector2::new(range * cosine, range * sine),
            jacobian: Matrix2::new(cosine, -range * sine, sine, range * cosine),
        })
    }

    #[inline]
    fn by_pose(&self, frame: &Self::Frame, feature: &SVector<T, 2>, expected: &ExpectedOf<Self>) -> SMatrix<T, 2, 3> {
        frame.by_pose(&expected.jacobian, feature)
    }
}

#[cfg(test)]
mod tests {
    use super::{PlanarPose, RangeBearing, Sensor};
    use crate::models::testing::check_sensor;
    use nalgebra::{Matrix2, Vector2};

    #[test]
    fn derivatives_agree_with_differences_and_the_inverse_inverts() {
        let sensor = RangeBearing::new(0.2, 0.01).unwrap();
        for heading in [-3.1, -0.7, 0.0, 1.3, 3.1] {
            let pose = PlanarPose::new(3.0, -2.0, heading);
            let frame = sensor.frame(&pose);
            for range in [0.3, 2.0, 40.0] {
                for turn in -6..=6 {
                    let angle = f64::from(turn) * 0.5;
                    let feature = Vector2::new(3.0 + range * angle.cos(), -2.0 + range * angle.sin());
                    check_sensor(&sensor, &pose, &feature, 1e-7);
                    let seen = sensor.expect(&frame, &feature).unwrap();
                    let back = sensor.invert(&frame, &seen.measurement).unwrap();
                    assert!((back.feature - feature).norm() < 1e-12 * range.max(1.0));
                    assert!((back.jacobian * seen.jacobian - Matrix2::identity()).norm() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn bearings_wrap() {
        let sensor = RangeBearing::new(0.2, 0.01).unwrap();
        let innovation = sensor.innovation(&Vector2::new(5.0, 3.1), &Vector2::new(4.0, -3.1));
        assert!((innovation - Vector2::new(1.0, 6.2 - core::f64::consts::TAU)).norm() < 1e-14);
    }

    #[test]
    fn features_and_measurements_without_a_result_give_none() {
        let sensor = RangeBearing::new(0.2_f32, 0.01).unwrap();
        let frame = sensor.frame(&PlanarPose::new(1.0, 1.0, 0.0));
        assert!(sensor.expect(&frame, &Vector2::new(1.0, 1.0)).is_none());
        assert!(sensor.expect(&frame, &Vector2::new(f32::NAN, 1.0)).is_none());
        assert!(sensor.invert(&frame, &Vector2::new(0.0, 1.0)).is_none());
        assert_eq!(RangeBearing::new(0.0_f32, 0.01).unwrap_err().field, "range_sigma_m");
        assert_eq!(RangeBearing::new(0.2_f32, f32::NAN).unwrap_err().field, "bearing_sigma_rad");
    }
}
