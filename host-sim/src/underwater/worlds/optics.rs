//! The stereo camera of a world.

use nalgebra::{Matrix3, SMatrix, Vector3, Vector4};
use scphd::projection;

/// A rectified pair of cameras, one beside the other, fixed to the vehicle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Optics {
    /// Focal length, px.
    pub focal_px: f64,
    /// From the left to the right camera, m.
    pub baseline_m: f64,
    /// Width and height of an image, px.
    pub size_px: [f64; 2],
    /// Depths between which keypoints are matched, m.
    pub depth_m: [f64; 2],
    /// How far the rows of a pair may differ either way, px.
    pub row_tolerance_px: f64,
    /// How far down the camera looks, rad: 0 ahead, π/2 straight down with the top of the image ahead.
    pub down_rad: f64,
    /// Middle of both cameras in the vehicle's frame, m.
    pub place_m: Vector3<f64>,
}

impl Optics {
    /// The projections of the left and the right camera, from the vehicle's frame.
    pub fn projections(&self) -> [SMatrix<f64, 3, 4>; 2] {
        let [cu, cv] = self.size_px.map(|size| 0.5 * size);
        let calibration = Matrix3::new(self.focal_px, 0.0, cu, 0.0, self.focal_px, cv, 0.0, 0.0, 1.0);
        let (s, c) = (libm::sin(self.down_rad), libm::cos(self.down_rad));
        // Rows: to the right, down the image, along the view.
        let turn = Matrix3::new(0.0, -1.0, 0.0, -s, 0.0, -c, c, 0.0, -s);
        [0.5, -0.5].map(|side| {
            let place = self.place_m + Vector3::new(0.0, side * self.baseline_m, 0.0);
            projection(&calibration, &turn, &place)
        })
    }

    /// Disparities at the greatest and the least depth, px.
    pub fn disparities_px(&self) -> [f64; 2] {
        let [near, far] = self.depth_m;
        [far, near].map(|depth| self.focal_px * self.baseline_m / depth)
    }
}

/// (u_l, v_l, u_r, v_r) of a point of the vehicle's frame; `None` where it is not in both images, or too near or too far.
pub(super) fn pair(optics: &Optics, projections: &[SMatrix<f64, 3, 4>; 2], point: &Vector3<f64>) -> Option<[f64; 4]> {
    let homogeneous = Vector4::new(point.x, point.y, point.z, 1.0);
    let [left, right] = projections.each_ref().map(|camera| camera * homogeneous);
    let pixel = |seen: &Vector3<f64>| [seen.x / seen.z, seen.y / seen.z];
    let ([ul, vl], [ur, vr]) = (pixel(&left), pixel(&right));
    let [width, height] = optics.size_px;
    let [near, far] = optics.depth_m;
    let shown = (near..=far).contains(&left.z)
        && [ul, ur].iter().all(|u| (0.0..=width).contains(u))
        && [vl, vr].iter().all(|v| (0.0..=height).contains(v));
    shown.then_some([ul, vl, ur, vr])
}
