//! Field of view of a stereo camera: visible in both images, and within a range of depths.

use super::range_bearing_window::ramp;
use super::{FieldOfView, ModelError, StereoCamera, StereoFrame, require};
use crate::{Bounds, Real};
use nalgebra::{SVector, Vector3, Vector4};

/// Limits of the field of view of a stereo camera.
///
/// p_D is constant inside (section 7.2.3), and falls to zero over a cubic ramp of half width `edge_px` at the edges of either
/// image, and `depth_edge_m` at the least and the greatest depth. With a hard edge, a pose error could delete a feature that is in
/// view according to the estimate but not in reality.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrustumLimits<T> {
    /// Width of the images, px: columns are 0 to `width_px`.
    pub width_px: T,
    /// Height of the images, px: rows are 0 to `height_px`.
    pub height_px: T,
    /// Half width of the soft edge around the images, px.
    pub edge_px: T,
    /// Least depth in front of the left camera, m.
    pub near_m: T,
    /// Greatest depth in front of the left camera, m.
    pub far_m: T,
    /// Half width of the soft edge at either depth, m.
    pub depth_edge_m: T,
    /// Probability of detection p_D inside the field of view.
    pub probability: T,
}

/// The view frustum of a stereo camera: checked [`FrustumLimits`] of a [`StereoCamera`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StereoFrustum<T: Real> {
    limits: FrustumLimits<T>,
    /// Its corners in the vehicle's frame, m.
    corners: [Vector3<T>; 8],
}

impl<T: Real> FrustumLimits<T> {
    /// Checks all fields, and returns the first that is out of range.
    ///
    /// # Errors
    /// Sizes must be finite and positive, edges finite and not negative, 0 < near − edge, near < far, and the
    /// probability in [0, 1).
    pub fn check(&self) -> Result<(), ModelError> {
        let zero = T::ZERO;
        let size = |x: T| x > zero && x.is_finite();
        let edge = |x: T| x >= zero && x.is_finite();
        require(size(self.width_px), "width_px", "finite and positive")?;
        require(size(self.height_px), "height_px", "finite and positive")?;
        require(edge(self.edge_px), "edge_px", "finite and not negative")?;
        require(edge(self.depth_edge_m), "depth_edge_m", "finite and not negative")?;
        require(self.near_m > self.depth_edge_m, "near_m", "above depth_edge_m")?;
        require(self.far_m > self.near_m && self.far_m.is_finite(), "far_m", "finite and above near_m")?;
        require(self.probability >= zero && self.probability < T::ONE, "probability", "in [0, 1)")
    }
}

impl<T: Real> StereoFrustum<T> {
    /// The frustum of a camera.
    ///
    /// # Errors
    /// A limit is out of range.
    pub fn new(camera: &StereoCamera<T>, limits: FrustumLimits<T>) -> Result<Self, ModelError> {
        limits.check()?;
        let FrustumLimits { width_px, height_px, edge_px, near_m, far_m, depth_edge_m, .. } = limits;
        let mut corners = [Vector3::zeros(); 8];
        for (index, corner) in corners.iter_mut().enumerate() {
            let pick = |bit: usize, low: T, high: T| if index >> bit & 1 == 0 { low } else { high };
            let u = pick(0, -edge_px, width_px + edge_px);
            let v = pick(1, -edge_px, height_px + edge_px);
            let depth = pick(2, near_m - depth_edge_m, far_m + depth_edge_m);
            let point = camera.point_at(u, v, depth);
            *corner = point.ok_or(ModelError { field: "left", range: "a projection that can be inverted" })?;
        }
        Ok(Self { limits, corners })
    }

    /// The limits.
    pub fn limits(&self) -> &FrustumLimits<T> {
        &self.limits
    }

    /// Measure of the pairs of keypoints that a matcher can report, px⁴: the domain of uniform clutter. A pair has any position in
    /// the left image, a disparity from `disparity_min_px` to `disparity_max_px`, and rows that differ by at most
    /// `row_tolerance_px` in either direction.
    #[must_use]
    pub fn measure(&self, disparity_min_px: T, disparity_max_px: T, row_tolerance_px: T) -> T {
        let rows = row_tolerance_px + row_tolerance_px;
        self.limits.width_px * self.limits.height_px * (disparity_max_px - disparity_min_px) * rows
    }
}

impl<T: Real> FieldOfView<StereoFrame<T>, Vector3<T>, Vector4<T>> for StereoFrustum<T> {
    #[inline]
    fn detection_probability(&self, frame: &StereoFrame<T>, feature: &SVector<T, 3>, expected: &SVector<T, 4>) -> T {
        let FrustumLimits { width_px, height_px, edge_px, near_m, far_m, depth_edge_m, probability } = self.limits;
        let [[ul, vl, ur, vr]] = expected.data.0;
        let mut probability = probability;
        for (pixel, size) in [(ul, width_px), (ur, width_px), (vl, height_px), (vr, height_px)] {
            probability *= ramp(pixel.at_most(size - pixel), edge_px);
        }
        let depth = frame.depth(feature);
        probability * ramp((depth - near_m).at_most(far_m - depth), depth_edge_m)
    }

    /// Whether the feature may be in the left image, at a depth in view.
    #[inline]
    fn may_see(&self, frame: &StereoFrame<T>, feature: &SVector<T, 3>) -> bool {
        let FrustumLimits { width_px, height_px, edge_px, near_m, far_m, depth_edge_m, .. } = self.limits;
        let [[x, y, depth]] = frame.homogeneous(feature).data.0;
        // Pixels are not yet divided by the depth here; the margin exceeds the difference in rounding.
        let margin = (width_px + height_px + edge_px) * T::from_f64(64.0) * T::EPSILON;
        let shows = |homogeneous: T, size: T| {
            let beyond = edge_px + margin;
            homogeneous > -beyond * depth && homogeneous < (size + beyond) * depth
        };
        let within_depth = (depth - near_m).at_most(far_m - depth) > -depth_edge_m;
        within_depth && shows(x, width_px) && shows(y, height_px)
    }

    /// The bounding box of the view of the left image.
    fn bounds(&self, frame: &StereoFrame<T>) -> Bounds<Vector3<T>> {
        let mut bounds = Bounds::EMPTY;
        for corner in &self.corners {
            bounds.include(&frame.body.to_map(corner));
        }
        // The margin keeps features in view inside the box in spite of rounding errors.
        let size = self.limits.far_m + frame.body.position.iter().fold(T::ZERO, |sum, x| sum + x.abs());
        let margin = size * T::from_f64(64.0) * T::EPSILON;
        Bounds { low: bounds.low.map(|x| x - margin), high: bounds.high.map(|x| x + margin) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::stereo_camera::tests::camera;
    use super::{FieldOfView, FrustumLimits, StereoFrustum};
    use crate::{AuvPose, Noise, Real, Sensor};
    use nalgebra::{Vector3, Vector4};

    fn limits<T: Real>() -> FrustumLimits<T> {
        FrustumLimits {
            width_px: T::from_f64(800.0),
            height_px: T::from_f64(600.0),
            edge_px: T::from_f64(20.0),
            near_m: T::from_f64(0.5),
            far_m: T::from_f64(5.0),
            depth_edge_m: T::from_f64(0.2),
            probability: T::from_f64(0.85),
        }
    }

    #[test]
    fn the_probability_falls_at_the_edges_of_both_images_and_of_the_depth() {
        let camera = camera::<f64>(0.0);
        let frustum = StereoFrustum::new(&camera, limits()).unwrap();
        let frame = camera.frame(&AuvPose::new(0.0, 0.0, 0.0, 0.4));
        let deep = |depth: f64| frame.body.to_map(&Vector3::new(0.3, 0.0, -0.1 - depth));
        let at = |ul, vl, ur, depth| frustum.detection_probability(&frame, &deep(depth), &Vector4::new(ul, vl, ur, vl));
        assert_eq!(at(400.0, 300.0, 330.0, 2.0), 0.85);
        assert!((at(800.0, 300.0, 700.0, 2.0) - 0.425).abs() < 1e-12);
        assert!((at(100.0, 300.0, 0.0, 2.0) - 0.425).abs() < 1e-12);
        // A feature at the upper edge of the left image is at that of the right image too.
        assert!((at(400.0, 0.0, 330.0, 2.0) - 0.2125).abs() < 1e-12);
        assert!((at(400.0, 300.0, 330.0, 5.0) - 0.425).abs() < 1e-9);
        assert!((at(400.0, 300.0, 330.0, 0.5) - 0.425).abs() < 1e-9);
        for outside in [at(820.0, 300.0, 700.0, 2.0), at(50.0, 300.0, -21.0, 2.0), at(400.0, 300.0, 330.0, 5.3)] {
            assert_eq!(outside, 0.0);
        }
    }

    #[test]
    fn every_position_in_view_is_in_the_bounds() {
        let camera = camera::<f64>(0.2);
        let frustum = StereoFrustum::new(&camera, limits()).unwrap();
        let pose = AuvPose { roll_rad: 0.2, pitch_rad: -0.3, ..AuvPose::new(50.0, -20.0, -3.0, 2.0) };
        let frame = camera.frame(&pose);
        let bounds = frustum.bounds(&frame);
        let (mut noise, mut seen, mut held) = (Noise::seeded(2), 0, 0);
        for _ in 0..200_000 {
            let offset = Vector3::from_fn(|_, _| 7.0 * (2.0 * noise.uniform::<f64>() - 1.0));
            let feature = pose.position() + offset;
            held += usize::from(bounds.holds(&feature));
            let Some(expected) = camera.expect(&frame, &feature) else { continue };
            if frustum.detection_probability(&frame, &feature, &expected.measurement) > 0.0 {
                seen += 1;
                assert!(bounds.holds(&feature), "{feature}");
            }
        }
        // The box is not much too large: the frustum is a pyramid, a third of its box, and tilted.
        assert!(seen > 1000 && held < 9 * seen, "{seen} {held}");
    }

    /// In single precision, with many features at the edges, where rounding decides.
    #[test]
    fn features_excluded_by_may_see_have_zero_probability() {
        let camera = camera::<f32>(0.2);
        let frustum = StereoFrustum::new(&camera, limits()).unwrap();
        let pose = AuvPose { roll_rad: 0.2, pitch_rad: -0.3, ..AuvPose::new(50.0_f32, -20.0, -3.0, 2.0) };
        let frame = camera.frame(&pose);
        let (mut noise, mut seen, mut passed) = (Noise::seeded(2), 0, 0);
        for k in 0..200_000 {
            let mut uniform = |low: f32, high: f32| low + (high - low) * noise.uniform::<f32>();
            let mut near = |rims: [f32; 2]| {
                if k % 2 == 0 { rims[k / 2 % 2] + uniform(-1e-3, 1e-3) } else { uniform(-300.0, 1100.0) }
            };
            let (u, v) = (near([-20.0, 820.0]), near([-20.0, 620.0]));
            let depth = uniform(0.2, 5.5);
            let Some(point) = camera.point_at(u, v, depth) else { continue };
            let feature = frame.body.to_map(&point);
            let expected = camera.expect(&frame, &feature);
            let p = expected.map_or(0.0, |e| frustum.detection_probability(&frame, &feature, &e.measurement));
            let may_see = frustum.may_see(&frame, &feature);
            assert!(may_see || p == 0.0, "{u} {v} {depth}: {p}");
            if k % 2 == 1 {
                seen += usize::from(p > 0.0);
                passed += usize::from(may_see);
            }
        }
        // Features that pass `may_see` and are out of view are out of the right image.
        assert!(seen > 10_000 && passed < seen * 3 / 2, "{seen} {passed}");
    }

    #[test]
    fn bad_limits_are_named() {
        let camera = camera::<f64>(0.0);
        let field = |limits| StereoFrustum::new(&camera, limits).unwrap_err().field;
        assert_eq!(field(FrustumLimits { width_px: f64::NAN, ..limits() }), "width_px");
        assert_eq!(field(FrustumLimits { near_m: 0.1, ..limits() }), "near_m");
        assert_eq!(field(FrustumLimits { far_m: 0.4, ..limits() }), "far_m");
        assert_eq!(field(FrustumLimits { probability: 1.0, ..limits() }), "probability");
        let frustum = StereoFrustum::new(&camera, limits()).unwrap();
        assert_eq!(frustum.measure(30.0, 130.0, 10.0), 800.0 * 600.0 * 100.0 * 20.0);
    }
}
