//! A sonar in space: range, bearing and elevation.

use super::range_bearing_window::ramp;
use super::{AuvPose, BodyFrame, Expected, ExpectedOf, FieldOfView, Inverse, InverseOf, ModelError, Sensor, require};
use crate::{Bounds, Real, Symmetric, Vector, wrap};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// A sensor that measures range (m), bearing (rad, 0 ahead, positive to the left) and elevation (rad, positive upwards) of a
/// feature in space, in the vehicle's frame.
///
/// ```
/// use scphd::models::{AuvPose, RangeBearingElevation, Sensor};
/// use nalgebra::Vector3;
///
/// let sonar = RangeBearingElevation::new(0.05_f64, 0.02, 0.02)?;
/// let frame = sonar.frame(&AuvPose::new(1.0, 0.0, -2.0, 0.0));
/// let seen = sonar.expect(&frame, &Vector3::new(1.0, 3.0, -2.0)).unwrap();
/// assert_eq!(seen.measurement, Vector3::new(3.0, core::f64::consts::FRAC_PI_2, 0.0));
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeBearingElevation<T: Real> {
    noise: Symmetric<Vector3<T>>,
}

impl<T: Real> RangeBearingElevation<T> {
    /// A sensor with independent noise of these standard deviations, m, rad and rad.
    ///
    /// # Errors
    /// Each must lie between 1e-6 and 1e6.
    pub fn new(range_sigma_m: T, bearing_sigma_rad: T, elevation_sigma_rad: T) -> Result<Self, ModelError> {
        let check = |sigma, field| {
            let usable = sigma >= T::from_f64(1e-6) && sigma <= T::from_f64(1e6);
            require(usable, field, "between 1e-6 and 1e6")
        };
        check(range_sigma_m, "range_sigma_m")?;
        check(bearing_sigma_rad, "bearing_sigma_rad")?;
        check(elevation_sigma_rad, "elevation_sigma_rad")?;
        let sigmas = [range_sigma_m, bearing_sigma_rad, elevation_sigma_rad];
        Ok(Self { noise: Symmetric::from_diagonal(sigmas.map(|sigma| sigma * sigma)) })
    }
}

/// Range, bearing and elevation of a feature, with their derivatives; `None` exactly above and below the vehicle and at its
/// position, where the bearing is not defined. The comparison is written so that NaN gives `None` too.
#[inline]
fn polar<T: Real>(frame: &BodyFrame<T>, feature: &Vector3<T>) -> Option<(Vector3<T>, Matrix3<T>)> {
    let [[x, y, z]] = frame.to_body(feature).data.0;
    let across_squared = x * x + y * y;
    let squared = across_squared + z * z;
    if !(across_squared > T::ZERO && squared.is_finite()) {
        return None;
    }
    let (across, range) = (across_squared.sqrt(), squared.sqrt());
    let by_body = Matrix3::new(
        x / range,
        y / range,
        z / range,
        -y / across_squared,
        x / across_squared,
        T::ZERO,
        -x * z / (squared * across),
        -y * z / (squared * across),
        across / squared,
    );
    let measurement = Vector3::new(range, y.atan2(x), z.atan2(across));
    Some((measurement, by_body * frame.rotation.transpose()))
}

impl<T: Real> Sensor for RangeBearingElevation<T> {
    type Pose = AuvPose<T>;
    type Measurement = Vector3<T>;
    type Frame = BodyFrame<T>;

    const SORTED_BY: usize = 1;
    const SORTED_BY_ANGLE: bool = true;
    const SIFTED_BY: Option<usize> = Some(0);

    fn frame(&self, pose: &Self::Pose) -> Self::Frame {
        BodyFrame::of(pose)
    }

    #[inline]
    fn expect(&self, frame: &Self::Frame, feature: &SVector<T, 3>) -> Option<ExpectedOf<Self>> {
        polar(frame, feature).map(|(measurement, jacobian)| Expected { measurement, jacobian })
    }

    #[inline]
    fn innovation(&self, measured: &SVector<T, 3>, expected: &SVector<T, 3>) -> SVector<T, 3> {
        let [[range, bearing, elevation]] = (measured - expected).data.0;
        Vector3::new(range, wrap(bearing), elevation)
    }

    fn noise(&self) -> &Symmetric<Vector3<T>> {
        &self.noise
    }

    /// A measurement with a range of zero or less, or an elevation of ±π/2 or beyond, has no inverse.
    fn invert(&self, frame: &Self::Frame, measured: &SVector<T, 3>) -> Option<InverseOf<Self>> {
        let [[range, bearing, elevation]] = measured.data.0;
        let ((sb, cb), (se, ce)) = (bearing.sin_cos(), elevation.sin_cos());
        if !(range > T::ZERO && ce > T::ZERO) {
            return None;
        }
        let direction = Vector3::new(ce * cb, ce * sb, se);
        let by_bearing = Vector3::new(-ce * sb, ce * cb, T::ZERO);
        let by_elevation = Vector3::new(-se * cb, -se * sb, ce);
        let by_measurement = Matrix3::from_columns(&[direction, by_bearing * range, by_elevation * range]);
        Some(Inverse { feature: frame.to_map(&(direction * range)), jacobian: frame.rotation * by_measurement })
    }

    #[inline]
    fn by_pose(&self, frame: &Self::Frame, feature: &SVector<T, 3>, expected: &ExpectedOf<Self>) -> SMatrix<T, 3, 5> {
        frame.by_pose(&expected.jacobian, feature)
    }
}

/// Limits of the field of view of a sonar in range, bearing and elevation.
///
/// p_D is constant inside, and falls to zero over a cubic ramp of half width `range_edge_m` or `angle_edge_rad` at the edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SonarLimits<T> {
    /// Greatest range, m.
    pub range_max_m: T,
    /// Half width of the soft edge at the greatest range, m.
    pub range_edge_m: T,
    /// Half width of the field of view in bearing, centred ahead, rad; π or more for all around.
    pub bearing_half_width_rad: T,
    /// Half width of the field of view in elevation, rad; π/2 or more for all elevations.
    pub elevation_half_width_rad: T,
    /// Half width of the soft edges in bearing and elevation, rad.
    pub angle_edge_rad: T,
    /// Probability of detection p_D inside the field of view.
    pub probability: T,
}

/// The field of view of a sonar: checked [`SonarLimits`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SonarWindow<T> {
    limits: SonarLimits<T>,
}

impl<T: Real> SonarLimits<T> {
    /// Checks all fields, and returns the first that is out of range.
    ///
    /// # Errors
    /// The range must be finite and positive, half widths positive, edges finite and not negative, and the probability in [0, 1).
    pub fn check(&self) -> Result<(), ModelError> {
        let zero = T::ZERO;
        let edge = |x: T| x >= zero && x.is_finite();
        require(self.range_max_m > zero && self.range_max_m.is_finite(), "range_max_m", "finite and positive")?;
        require(edge(self.range_edge_m), "range_edge_m", "finite and not negative")?;
        require(self.bearing_half_width_rad > zero, "bearing_half_width_rad", "positive")?;
        require(self.elevation_half_width_rad > zero, "elevation_half_width_rad", "positive")?;
        require(edge(self.angle_edge_rad), "angle_edge_rad", "finite and not negative")?;
        require(self.probability >= zero && self.probability < T::ONE, "probability", "in [0, 1)")
    }
}

impl<T: Real> SonarWindow<T> {
    /// The field of view with these limits.
    ///
    /// # Errors
    /// A limit is out of [range](SonarLimits::check).
    pub fn new(limits: SonarLimits<T>) -> Result<Self, ModelError> {
        limits.check()?;
        Ok(Self { limits })
    }

    /// The limits.
    pub fn limits(&self) -> &SonarLimits<T> {
        &self.limits
    }

    fn probability_at(&self, frame: &BodyFrame<T>, feature: &SVector<T, 3>) -> T {
        let Some((polar, _)) = polar(frame, feature) else { return T::ZERO };
        let limits = &self.limits;
        let mut probability = limits.probability * ramp(limits.range_max_m - polar.x, limits.range_edge_m);
        if limits.bearing_half_width_rad < T::PI {
            probability *= ramp(limits.bearing_half_width_rad - polar.y.abs(), limits.angle_edge_rad);
        }
        if limits.elevation_half_width_rad < T::PI * T::from_f64(0.5) {
            probability *= ramp(limits.elevation_half_width_rad - polar.z.abs(), limits.angle_edge_rad);
        }
        probability
    }
}

impl<T: Real, Z: Vector<Scalar = T>> FieldOfView<BodyFrame<T>, Vector3<T>, Z> for SonarWindow<T> {
    fn detection_probability(&self, frame: &BodyFrame<T>, feature: &Vector3<T>, _expected: &Z) -> T {
        self.probability_at(frame, feature)
    }

    fn bounds(&self, frame: &BodyFrame<T>) -> Bounds<Vector3<T>> {
        // The factor keeps features in view inside the box in spite of rounding errors.
        let reach = (self.limits.range_max_m + self.limits.range_edge_m) * (T::ONE + T::from_f64(8.0) * T::EPSILON);
        Bounds::around(&frame.position, reach)
    }
}

#[cfg(test)]
mod tests {
    use super::{AuvPose, BodyFrame, FieldOfView, RangeBearingElevation, Sensor, SonarLimits, SonarWindow};
    use crate::models::testing::check_sensor;
    use nalgebra::{Matrix3, Vector1, Vector3};

    fn poses() -> [AuvPose<f64>; 2] {
        let tilted = AuvPose { roll_rad: 0.4, pitch_rad: -0.3, ..AuvPose::new(1.0, -2.0, 0.5, 2.9) };
        [AuvPose::new(1.0, -2.0, 0.5, -0.4), tilted]
    }

    #[test]
    fn derivatives_agree_with_differences_and_the_inverse_inverts() {
        let sonar = RangeBearingElevation::new(0.1, 0.01, 0.02).unwrap();
        for pose in poses() {
            let frame = sonar.frame(&pose);
            for k in 0..40 {
                let (bearing, elevation) = (0.31 * f64::from(k), 1.4 * (0.7 * f64::from(k)).sin());
                let away =
                    Vector3::new(bearing.cos() * elevation.cos(), bearing.sin() * elevation.cos(), elevation.sin());
                let feature = frame.to_map(&(away * 4.0));
                check_sensor(&sonar, &pose, &feature, 1e-7);
                let seen = sonar.expect(&frame, &feature).unwrap();
                let back = sonar.invert(&frame, &seen.measurement).unwrap();
                assert!((back.feature - feature).norm() < 1e-12);
                assert!((back.jacobian * seen.jacobian - Matrix3::identity()).norm() < 1e-11);
            }
        }
    }

    #[test]
    fn features_and_measurements_without_a_result_give_none() {
        let sonar = RangeBearingElevation::new(0.1, 0.01, 0.02).unwrap();
        let frame = sonar.frame(&poses()[0]);
        assert!(sonar.expect(&frame, &frame.position).is_none());
        assert!(sonar.expect(&frame, &(frame.position + Vector3::z())).is_none());
        assert!(sonar.invert(&frame, &Vector3::new(0.0, 0.1, 0.1)).is_none());
        assert!(sonar.invert(&frame, &Vector3::new(1.0, 0.1, 2.0)).is_none());
        assert_eq!(RangeBearingElevation::new(0.1, f64::NAN, 0.1).unwrap_err().field, "bearing_sigma_rad");
    }

    #[test]
    fn the_window_has_the_given_limits() {
        let limits = SonarLimits {
            range_max_m: 10.0,
            range_edge_m: 0.5,
            bearing_half_width_rad: 1.0,
            elevation_half_width_rad: 0.3,
            angle_edge_rad: 0.1,
            probability: 0.8,
        };
        let window = SonarWindow::new(limits).unwrap();
        for bad in [f64::NAN, -1.0, 1.0, 1.5] {
            let refused = SonarWindow::new(SonarLimits { probability: bad, ..limits }).unwrap_err();
            assert_eq!(refused.field, "probability");
        }
        let frame = BodyFrame::of(&poses()[1]);
        let at = |range: f64, bearing: f64, elevation: f64| {
            let across = range * elevation.cos();
            let body = Vector3::new(across * bearing.cos(), across * bearing.sin(), range * elevation.sin());
            let feature = frame.to_map(&body);
            assert!(FieldOfView::<_, _, Vector1<f64>>::bounds(&window, &frame).holds(&feature) || range > 10.5);
            window.detection_probability(&frame, &feature, &Vector1::new(0.0))
        };
        assert!((at(5.0, -0.5, 0.1) - 0.8).abs() < 1e-12);
        assert!((at(10.0, 0.0, 0.0) - 0.4).abs() < 1e-9);
        assert!((at(5.0, -1.0, 0.0) - 0.4).abs() < 1e-9);
        assert!((at(5.0, 0.0, 0.3) - 0.4).abs() < 1e-9);
        assert_eq!([at(10.6, 0.0, 0.0), at(5.0, 1.2, 0.0), at(5.0, 0.0, -0.5), at(5.0, 3.0, 0.0)], [0.0; 4]);
    }
}
