//! Sonars in space: range, bearing and elevation, range only, and direction only.

use super::bearing_only::check_ranges;
use super::range_bearing_window::ramp;
use super::{AuvPose, BirthIntensity, BodyFrame, Expected, FieldOfView, Inverse, ModelError, Sensor, require};
use crate::{Bounds, Component, Real, Symmetric, Vector, wrap};
use nalgebra::{Matrix3, SMatrix, SVector, Vector1, Vector2, Vector3};

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

/// A sensor that measures only the range (m) of a feature in space, for example with an acoustic transponder.
///
/// One range has no inverse; features are therefore born from the birth intensity `B` (5.2.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeOnly<T: Real, B> {
    noise: Symmetric<Vector1<T>>,
    births: B,
}

/// A sensor that measures bearing and elevation (rad) of a feature in space, for example a single camera or a hydrophone array.
///
/// A direction has no inverse; features are therefore born from the birth intensity `B` (5.2.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingElevation<T: Real, B> {
    noise: Symmetric<Vector2<T>>,
    births: B,
}

fn usable<T: Real>(sigma: T) -> bool {
    sigma >= T::from_f64(1e-6) && sigma <= T::from_f64(1e6)
}

const SIGMA_RANGE: &str = "between 1e-6 and 1e6";

impl<T: Real> RangeBearingElevation<T> {
    /// A sensor with independent noise of these standard deviations, m, rad and rad.
    ///
    /// # Errors
    /// Each must lie between 1e-6 and 1e6.
    pub fn new(range_sigma_m: T, bearing_sigma_rad: T, elevation_sigma_rad: T) -> Result<Self, ModelError> {
        require(usable(range_sigma_m), "range_sigma_m", SIGMA_RANGE)?;
        require(usable(bearing_sigma_rad), "bearing_sigma_rad", SIGMA_RANGE)?;
        require(usable(elevation_sigma_rad), "elevation_sigma_rad", SIGMA_RANGE)?;
        let sigmas = [range_sigma_m, bearing_sigma_rad, elevation_sigma_rad];
        Ok(Self { noise: Symmetric::from_diagonal(sigmas.map(|sigma| sigma * sigma)) })
    }
}

impl<T: Real, B> RangeOnly<T, B> {
    /// A sensor with this standard deviation of the noise, m.
    ///
    /// # Errors
    /// It must lie between 1e-6 and 1e6.
    pub fn new(range_sigma_m: T, births: B) -> Result<Self, ModelError> {
        require(usable(range_sigma_m), "range_sigma_m", SIGMA_RANGE)?;
        Ok(Self { noise: Symmetric::from_diagonal([range_sigma_m * range_sigma_m]), births })
    }
}

impl<T: Real, B> BearingElevation<T, B> {
    /// A sensor with independent noise of these standard deviations, rad.
    ///
    /// # Errors
    /// Each must lie between 1e-6 and 1e6.
    pub fn new(bearing_sigma_rad: T, elevation_sigma_rad: T, births: B) -> Result<Self, ModelError> {
        require(usable(bearing_sigma_rad), "bearing_sigma_rad", SIGMA_RANGE)?;
        require(usable(elevation_sigma_rad), "elevation_sigma_rad", SIGMA_RANGE)?;
        let variances = [bearing_sigma_rad * bearing_sigma_rad, elevation_sigma_rad * elevation_sigma_rad];
        Ok(Self { noise: Symmetric::from_diagonal(variances), births })
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
    fn expect(&self, frame: &Self::Frame, feature: &SVector<T, 3>) -> Option<Expected<Vector3<T>, Vector3<T>>> {
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
    fn invert(&self, frame: &Self::Frame, measured: &SVector<T, 3>) -> Option<Inverse<Vector3<T>, Vector3<T>>> {
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
    fn by_pose(
        &self,
        frame: &Self::Frame,
        feature: &SVector<T, 3>,
        expected: &Expected<Vector3<T>, Vector3<T>>,
    ) -> SMatrix<T, 3, 5> {
        frame.by_pose(&expected.jacobian, feature)
    }
}

impl<T: Real, B: BirthIntensity<BodyFrame<T>, Vector3<T>>> Sensor for RangeOnly<T, B> {
    type Pose = AuvPose<T>;
    type Measurement = Vector1<T>;
    type Frame = BodyFrame<T>;

    const SORTED_BY: usize = 0;
    const SORTED_BY_ANGLE: bool = false;

    fn frame(&self, pose: &Self::Pose) -> Self::Frame {
        BodyFrame::of(pose)
    }

    #[inline]
    fn expect(&self, frame: &Self::Frame, feature: &SVector<T, 3>) -> Option<Expected<Vector3<T>, Vector1<T>>> {
        let offset = feature - frame.position;
        let squared = offset.x * offset.x + offset.y * offset.y + offset.z * offset.z;
        if !(squared > T::ZERO && squared.is_finite()) {
            return None;
        }
        let range = squared.sqrt();
        Some(Expected { measurement: Vector1::new(range), jacobian: offset.transpose() / range })
    }

    #[inline]
    fn innovation(&self, measured: &SVector<T, 1>, expected: &SVector<T, 1>) -> SVector<T, 1> {
        measured - expected
    }

    fn noise(&self) -> &Symmetric<Vector1<T>> {
        &self.noise
    }

    fn expected_birth(&self, frame: &Self::Frame, index: usize) -> Option<Component<Vector3<T>>> {
        self.births.component(frame, index)
    }

    /// `None`: any direction is possible.
    fn invert(&self, _frame: &Self::Frame, _measured: &SVector<T, 1>) -> Option<Inverse<Vector3<T>, Vector1<T>>> {
        None
    }

    #[inline]
    fn by_pose(
        &self,
        frame: &Self::Frame,
        feature: &SVector<T, 3>,
        expected: &Expected<Vector3<T>, Vector1<T>>,
    ) -> SMatrix<T, 1, 5> {
        frame.by_pose(&expected.jacobian, feature)
    }
}

impl<T: Real, B: BirthIntensity<BodyFrame<T>, Vector3<T>>> Sensor for BearingElevation<T, B> {
    type Pose = AuvPose<T>;
    type Measurement = Vector2<T>;
    type Frame = BodyFrame<T>;

    const SORTED_BY: usize = 0;
    const SORTED_BY_ANGLE: bool = true;
    /// The elevation, which does not wrap.
    const SIFTED_BY: Option<usize> = Some(1);

    fn frame(&self, pose: &Self::Pose) -> Self::Frame {
        BodyFrame::of(pose)
    }

    #[inline]
    fn expect(&self, frame: &Self::Frame, feature: &SVector<T, 3>) -> Option<Expected<Vector3<T>, Vector2<T>>> {
        let (measurement, jacobian) = polar(frame, feature)?;
        Some(Expected {
            measurement: Vector2::new(measurement.y, measurement.z),
            jacobian: jacobian.fixed_rows::<2>(1).into(),
        })
    }

    #[inline]
    fn innovation(&self, measured: &SVector<T, 2>, expected: &SVector<T, 2>) -> SVector<T, 2> {
        let [[bearing, elevation]] = (measured - expected).data.0;
        Vector2::new(wrap(bearing), elevation)
    }

    fn noise(&self) -> &Symmetric<Vector2<T>> {
        &self.noise
    }

    fn expected_birth(&self, frame: &Self::Frame, index: usize) -> Option<Component<Vector3<T>>> {
        self.births.component(frame, index)
    }

    /// `None`: any range is possible.
    fn invert(&self, _frame: &Self::Frame, _measured: &SVector<T, 2>) -> Option<Inverse<Vector3<T>, Vector2<T>>> {
        None
    }

    #[inline]
    fn by_pose(
        &self,
        frame: &Self::Frame,
        feature: &SVector<T, 3>,
        expected: &Expected<Vector3<T>, Vector2<T>>,
    ) -> SMatrix<T, 2, 5> {
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

/// Field of view of any of the sonars: checked [`SonarLimits`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SonarWindow<T> {
    limits: SonarLimits<T>,
}

impl<T: Real> SonarLimits<T> {
    /// Checks all fields, and returns the first that is out of range.
    ///
    /// # Errors
    /// The range must be finite and positive, half widths positive, edges finite and not negative, and the probability
    /// in [0, 1).
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
    #[must_use]
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

/// A spherical grid around a sensor: shells, each farther than the previous one by the same factor, divided into directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphericalGrid<T> {
    /// Range of the innermost shell, m; above zero.
    pub nearest_m: T,
    /// Range of the outermost shell, m.
    pub farthest_m: T,
    /// Number of shells, at least two.
    pub shells: u16,
    /// Number of directions in a shell, spread evenly along a spiral from straight down to straight up.
    pub directions: u16,
    /// Weight of every component: the expected number of features that appear there between two scans.
    pub weight: T,
}

/// Birth intensity all around the sensor: one component for every cell of a checked [`SphericalGrid`], with a size proportional to
/// its range. For a prior that knows only the range of the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphericalBirths<T> {
    grid: SphericalGrid<T>,
}

impl<T: Real> SphericalBirths<T> {
    /// The birth intensity of this grid.
    ///
    /// # Errors
    /// 1e-9 m ≤ nearest < farthest ≤ 1e9 m; at least two shells and one direction; a weight between 0 and 1e6.
    pub fn new(grid: SphericalGrid<T>) -> Result<Self, ModelError> {
        check_ranges(grid.nearest_m, grid.farthest_m)?;
        require(grid.shells >= 2, "shells", "at least 2")?;
        require(grid.directions >= 1, "directions", "at least 1")?;
        require(grid.weight >= T::ZERO && grid.weight <= T::from_f64(1e6), "weight", "between 0 and 1e6")?;
        Ok(Self { grid })
    }
}

impl<T: Real> BirthIntensity<BodyFrame<T>, Vector3<T>> for SphericalBirths<T> {
    fn component(&self, frame: &BodyFrame<T>, index: usize) -> Option<Component<Vector3<T>>> {
        let SphericalGrid { nearest_m, farthest_m, weight, .. } = self.grid;
        let (shells, directions) = (usize::from(self.grid.shells), usize::from(self.grid.directions));
        let (shell, place) = (index.checked_div(directions)?, index.checked_rem(directions)?);
        if shell >= shells {
            return None;
        }
        let step = (farthest_m / nearest_m).ln() / T::from_usize(shells - 1);
        let range = nearest_m * (step * T::from_usize(shell)).exp();
        // Equal steps in height give equal areas on a sphere; the golden angle separates neighbours.
        let (half, two) = (T::from_f64(0.5), T::from_f64(2.0));
        let count = T::from_usize(directions);
        let height = (two * T::from_usize(place) + T::ONE) / count - T::ONE;
        let across = (T::ONE - height * height).sqrt();
        let (sine, cosine) = wrap(T::from_f64(GOLDEN_ANGLE_RAD) * T::from_usize(place)).sin_cos();
        let direction = frame.rotation * Vector3::new(across * cosine, across * sine, height);
        // Standard deviations of half the distance to the neighbours, along and across the range: a direction has 4π/n of the
        // sphere.
        let along = range * step * half;
        let aside = range * (two * two * T::PI / count).sqrt() * half;
        let mut covariance = Symmetric::from_diagonal([aside * aside; 3]);
        covariance.add_outer(along * along - aside * aside, &direction);
        Some(Component { label: 0, ln_weight: weight.ln(), mean: frame.position + direction * range, covariance })
    }
}

/// π (3 − √5).
const GOLDEN_ANGLE_RAD: f64 = 2.399_963_229_728_653;

#[cfg(test)]
mod tests {
    use super::{
        AuvPose, BearingElevation, BirthIntensity, BodyFrame, FieldOfView, RangeBearingElevation, RangeOnly, Sensor,
        SonarLimits, SonarWindow, SphericalBirths, SphericalGrid,
    };
    use crate::models::testing::check_in_space;
    use nalgebra::{Matrix3, Vector1, Vector3};
    use std::vec::Vec;

    const GRID: SphericalGrid<f64> =
        SphericalGrid { nearest_m: 1.0, farthest_m: 20.0, shells: 6, directions: 60, weight: 1e-4 };

    fn births() -> SphericalBirths<f64> {
        SphericalBirths::new(GRID).unwrap()
    }

    fn poses() -> [AuvPose<f64>; 2] {
        let tilted = AuvPose { roll_rad: 0.4, pitch_rad: -0.3, ..AuvPose::new(1.0, -2.0, 0.5, 2.9) };
        [AuvPose::new(1.0, -2.0, 0.5, -0.4), tilted]
    }

    #[test]
    fn derivatives_agree_with_differences_and_the_inverse_inverts() {
        let sonar = RangeBearingElevation::new(0.1, 0.01, 0.02).unwrap();
        let range = RangeOnly::new(0.1, births()).unwrap();
        let direction = BearingElevation::new(0.01, 0.02, births()).unwrap();
        for pose in poses() {
            let frame = sonar.frame(&pose);
            for k in 0..40 {
                let (bearing, elevation) = (0.31 * f64::from(k), 1.4 * (0.7 * f64::from(k)).sin());
                let away =
                    Vector3::new(bearing.cos() * elevation.cos(), bearing.sin() * elevation.cos(), elevation.sin());
                let feature = frame.to_map(&(away * 4.0));
                check_in_space(&sonar, &pose, &feature, 1e-7);
                check_in_space(&range, &pose, &feature, 1e-7);
                check_in_space(&direction, &pose, &feature, 1e-7);
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
        let range = RangeOnly::new(0.1, births()).unwrap();
        assert!(range.expect(&frame, &frame.position).is_none());
        assert!(range.invert(&frame, &range.expect(&frame, &Vector3::zeros()).unwrap().measurement).is_none());
        assert_eq!(RangeBearingElevation::new(0.1, f64::NAN, 0.1).unwrap_err().field, "bearing_sigma_rad");
        assert_eq!(RangeOnly::new(0.0, births()).unwrap_err().field, "range_sigma_m");
        assert_eq!(BearingElevation::new(0.1, 0.0, births()).unwrap_err().field, "elevation_sigma_rad");
    }

    #[test]
    fn births_surround_the_sensor_once() {
        let frame = BodyFrame::of(&poses()[1]);
        let births: Vec<_> = (0..).map_while(|index| births().component(&frame, index)).collect();
        assert_eq!(births.len(), 6 * 60);
        for birth in &births {
            assert!((0.999..20.001).contains(&(birth.mean - frame.position).norm()));
            assert!(birth.covariance.factor().is_some());
        }
        let mean = births.iter().map(|birth| birth.mean).sum::<Vector3<f64>>() / births.len() as f64;
        assert!((mean - frame.position).norm() < 0.2, "{mean}");
        // Every direction is within two standard deviations of a component.
        let outer = &births[5 * 60..];
        for k in 0..500 {
            let (bearing, height) = (0.37 * f64::from(k), f64::from(k) / 250.0 - 0.998);
            let across = (1.0 - height * height).sqrt();
            let point = frame.position + Vector3::new(across * bearing.cos(), across * bearing.sin(), height) * 20.0;
            let nearest = outer
                .iter()
                .map(|birth| birth.covariance.factor().unwrap().mahalanobis(&(point - birth.mean)))
                .fold(f64::MAX, f64::min);
            assert!(nearest < 4.0, "{point} {nearest}");
        }
        assert_eq!(SphericalBirths::new(SphericalGrid { directions: 0, ..GRID }).unwrap_err().field, "directions");
        assert_eq!(SphericalBirths::new(SphericalGrid { shells: 1, ..GRID }).unwrap_err().field, "shells");
        assert_eq!(SphericalBirths::new(SphericalGrid { weight: f64::NAN, ..GRID }).unwrap_err().field, "weight");
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
