//! Field of view in range and bearing (section 5.2.3).

use super::{FieldOfView, ModelError, PlanarFrame, require};
use crate::{Bounds, Real, wrap};
use nalgebra::Vector2;

/// Limits of the field of view of a sensor in the plane, in range and bearing.
///
/// p_D falls linearly with range from `probability_near` at the sensor to `probability_far` at the greatest range. At every edge of
/// the window it falls to zero over a cubic ramp of half width `range_edge_m` or `bearing_edge_rad`. With a hard edge, a pose error
/// could delete a feature near the edge that is in view according to the estimate but not in reality.
///
/// ```
/// use scphd::models::{RangeBearingLimits, RangeBearingWindow};
///
/// let ahead = RangeBearingLimits {
///     range_edge_m: 1.0,
///     bearing_half_width_rad: 1.57,
///     bearing_edge_rad: 0.05,
///     ..RangeBearingLimits::full_circle(30.0_f32, 0.9)
/// };
/// assert!(RangeBearingWindow::new(ahead).is_ok());
/// let error = RangeBearingWindow::new(RangeBearingLimits { probability_near: 1.5, ..ahead }).unwrap_err();
/// assert_eq!(error.to_string(), "probability_near must be in [0, 1)");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeBearingLimits<T> {
    /// Least range, m; 0 for none.
    pub range_min_m: T,
    /// Greatest range, m.
    pub range_max_m: T,
    /// Half width of the soft edge at either range, m.
    pub range_edge_m: T,
    /// Middle of the window, rad.
    pub bearing_center_rad: T,
    /// Half width of the window in bearing, rad; π or more for a full circle.
    pub bearing_half_width_rad: T,
    /// Half width of the soft edge at either side, rad.
    pub bearing_edge_rad: T,
    /// p_D at range zero.
    pub probability_near: T,
    /// p_D at the greatest range, before the edge.
    pub probability_far: T,
}

/// A field of view in range and bearing with soft edges: checked [`RangeBearingLimits`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeBearingWindow<T> {
    limits: RangeBearingLimits<T>,
    /// Up to this range, m, p_D is that at the sensor. Most features are within it, and cost only one comparison. Negative: no such
    /// range.
    even_within_m: T,
    /// Beyond the square root of this, m, p_D is zero.
    blind_beyond_m2: T,
}

impl<T: Real> RangeBearingLimits<T> {
    /// A full circle with hard edges and a constant probability of detection, as in (5.15).
    pub fn full_circle(range_max_m: T, probability: T) -> Self {
        Self {
            range_min_m: T::ZERO,
            range_max_m,
            range_edge_m: T::ZERO,
            bearing_center_rad: T::ZERO,
            bearing_half_width_rad: T::PI,
            bearing_edge_rad: T::ZERO,
            probability_near: probability,
            probability_far: probability,
        }
    }

    /// Checks all fields, and returns the first that is out of range.
    ///
    /// # Errors
    /// Ranges must be finite with 0 ≤ min < max, edges finite and not negative, the half width positive, and both probabilities in
    /// [0, 1): with p_D = 1, a missed detection would give a weight of zero.
    pub fn check(&self) -> Result<(), ModelError> {
        let zero = T::ZERO;
        let probability = |p: T| p >= zero && p < T::ONE;
        require(self.range_min_m >= zero, "range_min_m", "not negative")?;
        require(
            self.range_max_m > self.range_min_m && self.range_max_m.is_finite(),
            "range_max_m",
            "finite and above range_min_m",
        )?;
        require(self.range_edge_m.is_amount(), "range_edge_m", "finite and not negative")?;
        require(self.bearing_center_rad.is_finite(), "bearing_center_rad", "finite")?;
        require(self.bearing_half_width_rad > zero, "bearing_half_width_rad", "positive")?;
        require(self.bearing_edge_rad.is_amount(), "bearing_edge_rad", "finite and not negative")?;
        require(probability(self.probability_near), "probability_near", "in [0, 1)")?;
        require(probability(self.probability_far), "probability_far", "in [0, 1)")
    }
}

impl<T: Real> RangeBearingWindow<T> {
    /// The field of view with these limits.
    ///
    /// # Errors
    /// A limit is out of [range](RangeBearingLimits::check).
    pub fn new(limits: RangeBearingLimits<T>) -> Result<Self, ModelError> {
        limits.check()?;
        let is_even = limits.probability_far == limits.probability_near
            && limits.range_min_m == T::ZERO
            && limits.bearing_half_width_rad >= T::PI;
        // The factor allows for rounding errors.
        let inner = (limits.range_max_m - limits.range_edge_m) * (T::ONE - T::from_f64(4.0) * T::EPSILON);
        let outer = (limits.range_max_m + limits.range_edge_m) * (T::ONE + T::from_f64(8.0) * T::EPSILON);
        Ok(Self { limits, even_within_m: if is_even { inner } else { -T::ONE }, blind_beyond_m2: outer * outer })
    }

    /// A full circle of this radius, m, with hard edges and a constant probability of detection, as in (5.15).
    ///
    /// # Errors
    /// The range must be finite and positive, the probability in [0, 1).
    pub fn full_circle(range_max_m: T, probability: T) -> Result<Self, ModelError> {
        Self::new(RangeBearingLimits::full_circle(range_max_m, probability))
    }

    /// The limits.
    pub fn limits(&self) -> &RangeBearingLimits<T> {
        &self.limits
    }

    /// Measure of the window in range × bearing, m·rad: the domain of uniform clutter.
    pub fn measure(&self) -> T {
        let half_width = self.limits.bearing_half_width_rad.at_most(T::PI);
        (self.limits.range_max_m - self.limits.range_min_m) * (half_width + half_width)
    }
}

/// The ramp from 0 at `inside` = −`edge` to 1 at `inside` = +`edge`.
#[inline]
pub(super) fn ramp<T: Real>(inside: T, edge: T) -> T {
    if inside >= edge {
        T::ONE
    } else if inside > -edge {
        let t = (inside / edge + T::ONE) * T::from_f64(0.5);
        t * t * (T::from_f64(3.0) - (t + t))
    } else {
        T::ZERO
    }
}

impl<T: Real> FieldOfView<PlanarFrame<T>, Vector2<T>, Vector2<T>> for RangeBearingWindow<T> {
    #[inline(always)]
    fn detection_probability(&self, _frame: &PlanarFrame<T>, _feature: &Vector2<T>, expected: &Vector2<T>) -> T {
        let [[range, bearing]] = expected.data.0;
        let limits = &self.limits;
        if range <= self.even_within_m {
            return limits.probability_near;
        }
        let mut probability = limits.probability_near;
        if limits.probability_far != limits.probability_near {
            let far = (range / limits.range_max_m).at_most(T::ONE);
            probability += (limits.probability_far - limits.probability_near) * far;
        }
        probability *= ramp(limits.range_max_m - range, limits.range_edge_m);
        if limits.range_min_m > T::ZERO {
            probability *= ramp(range - limits.range_min_m, limits.range_edge_m);
        }
        if limits.bearing_half_width_rad < T::PI {
            let aside = wrap(bearing - limits.bearing_center_rad).abs();
            probability *= ramp(limits.bearing_half_width_rad - aside, limits.bearing_edge_rad);
        }
        probability
    }

    #[inline(always)]
    fn may_see(&self, frame: &PlanarFrame<T>, feature: &Vector2<T>) -> bool {
        let [[dx, dy]] = (feature - frame.position).data.0;
        dx * dx + dy * dy <= self.blind_beyond_m2
    }

    fn bounds(&self, frame: &PlanarFrame<T>) -> Bounds<Vector2<T>> {
        // The factor keeps features in view inside the box in spite of rounding errors.
        let reach = (self.limits.range_max_m + self.limits.range_edge_m) * (T::ONE + T::from_f64(4.0) * T::EPSILON);
        Bounds::around(&frame.position, reach)
    }
}

#[cfg(test)]
mod tests {
    use super::{FieldOfView, RangeBearingLimits, RangeBearingWindow};
    use crate::{PlanarPose, RangeBearing, Sensor};
    use nalgebra::Vector2;

    fn probability(window: &RangeBearingWindow<f64>, range: f64, bearing: f64) -> f64 {
        let frame = RangeBearing::new(1.0, 1.0).unwrap().frame(&PlanarPose::new(0.0, 0.0, 0.0));
        FieldOfView::<_, _, Vector2<f64>>::detection_probability(
            window,
            &frame,
            &Vector2::zeros(),
            &Vector2::new(range, bearing),
        )
    }

    /// Up to the soft edge p_D equals that at the sensor to the bit, and the product over all edges.
    #[test]
    fn probability_is_constant_inside_the_edges() {
        let limits = RangeBearingLimits { range_edge_m: 0.3, ..RangeBearingLimits::full_circle(15.0, 0.95) };
        let even = RangeBearingWindow::new(limits).unwrap();
        let without = RangeBearingWindow { even_within_m: -1.0, ..even };
        assert!(even.even_within_m > 14.6);
        for step in 0..4000 {
            let range = 14.0 + 0.000_4 * f64::from(step);
            assert_eq!(probability(&even, range, 1.0), probability(&without, range, 1.0), "{range}");
        }
        let ahead = RangeBearingWindow::new(RangeBearingLimits { bearing_half_width_rad: 1.0, ..limits }).unwrap();
        assert_eq!((probability(&ahead, 3.0, 0.0), probability(&ahead, 3.0, 2.0)), (0.95, 0.0));
    }

    #[test]
    fn a_hard_window_is_that_of_the_thesis() {
        let window = RangeBearingWindow::full_circle(15.0, 0.95).unwrap();
        assert_eq!(probability(&window, 15.0, 3.0), 0.95);
        assert_eq!(probability(&window, 15.000_001, 3.0), 0.0);
    }

    #[test]
    fn soft_edges_are_half_at_the_limit_and_monotonic() {
        let limits = RangeBearingLimits {
            range_min_m: 1.0,
            range_edge_m: 0.5,
            bearing_center_rad: 3.0,
            bearing_half_width_rad: 0.6,
            bearing_edge_rad: 0.1,
            probability_far: 0.5,
            ..RangeBearingLimits::full_circle(10.0, 0.9)
        };
        let window = RangeBearingWindow::new(limits).unwrap();
        assert!((probability(&window, 5.0, 3.0) - 0.7).abs() < 1e-15);
        assert!((probability(&window, 10.0, 3.0) - 0.25).abs() < 1e-15);
        assert!((probability(&window, 1.0, 3.0) - 0.5 * 0.86).abs() < 1e-15);
        // The window reaches across ±π.
        let other_side = 3.6 - core::f64::consts::TAU;
        assert!((probability(&window, 5.0, other_side) - 0.35).abs() < 1e-12);
        assert_eq!(probability(&window, 10.5, 3.0), 0.0);
        assert_eq!(probability(&window, 5.0, 0.0), 0.0);
        let mut last = 1.0;
        for step in 0..=100 {
            let p = probability(&window, 9.0 + 0.02 * f64::from(step), 3.0);
            assert!(p <= last);
            last = p;
        }
    }

    #[test]
    fn every_position_in_view_is_in_the_bounds() {
        let limits = RangeBearingLimits { range_edge_m: 0.5, ..RangeBearingLimits::full_circle(10.0, 0.9) };
        let window = RangeBearingWindow::new(limits).unwrap();
        let sensor = RangeBearing::new(1.0, 1.0).unwrap();
        let frame = sensor.frame(&PlanarPose::new(100.0, -50.0, 1.0));
        let bounds = FieldOfView::<_, _, Vector2<f64>>::bounds(&window, &frame);
        for k in 0..1000 {
            let angle = f64::from(k) * 0.1;
            let feature = frame.position + Vector2::new(angle.cos(), angle.sin()) * 10.499_999_9;
            let expected = sensor.expect(&frame, &feature).unwrap().measurement;
            assert!(window.detection_probability(&frame, &feature, &expected) > 0.0);
            assert!(feature.x >= bounds.low.x && feature.x <= bounds.high.x);
            assert!(feature.y >= bounds.low.y && feature.y <= bounds.high.y);
            assert!(FieldOfView::<_, _, Vector2<f64>>::may_see(&window, &frame, &feature));
            let outside = frame.position + (feature - frame.position) * 1.000_001;
            assert!(!FieldOfView::<_, _, Vector2<f64>>::may_see(&window, &frame, &outside));
        }
    }

    #[test]
    fn bad_fields_are_named() {
        let good = RangeBearingLimits::full_circle(10.0, 0.9);
        assert_eq!(RangeBearingWindow::new(good).unwrap().limits(), &good);
        for bad in [f64::NAN, -1.0, 1.0, 1.5, f64::INFINITY] {
            let refused = |limits| RangeBearingWindow::new(limits).unwrap_err().field;
            assert_eq!(refused(RangeBearingLimits { probability_near: bad, ..good }), "probability_near");
            assert_eq!(refused(RangeBearingLimits { probability_far: bad, ..good }), "probability_far");
        }
        for bad in [f64::NAN, -1.0, 0.0, f64::INFINITY] {
            assert_eq!(RangeBearingWindow::full_circle(bad, 0.9).unwrap_err().field, "range_max_m");
        }
    }
}
