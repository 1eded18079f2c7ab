//! The stereo camera of a world.

use crate::underwater::stereo::{self, Projections};
use nalgebra::{Matrix3, Vector3};
use scphd::models::projection;

/// A rectified pair of cameras side by side, fixed to the vehicle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Optics {
    pub focal_px: f64,
    /// Distance of the two cameras, m.
    pub baseline_m: f64,
    /// Width and height of an image, px.
    pub size_px: [f64; 2],
    /// Depths between which keypoints are matched, m.
    pub depth_m: [f64; 2],
    /// Greatest row difference of a pair, px.
    pub row_tolerance_px: f64,
    /// Downward angle of the camera, rad: 0 ahead, π/2 straight down with the top of the image ahead.
    pub down_rad: f64,
    /// Centre between both cameras in the vehicle's frame, m.
    pub place_m: Vector3<f64>,
}

impl Optics {
    /// The projections of the left and the right camera, from the vehicle's frame.
    pub fn projections(&self) -> Projections {
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

    /// The pair of pixels of a point in the vehicle's frame; `None` out of view.
    pub fn pair(&self, projections: &Projections, point: &Vector3<f64>) -> Option<[f64; 4]> {
        stereo::pair(projections, self.size_px, self.depth_m, point)
    }
}
