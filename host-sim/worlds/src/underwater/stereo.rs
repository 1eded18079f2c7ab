//! Projection of points into a rectified pair of cameras.

use nalgebra::{SMatrix, Vector3, Vector4};

/// Projection matrices of the left and the right camera, from the vehicle's frame to homogeneous pixels.
pub(super) type Projections = [SMatrix<f64, 3, 4>; 2];

/// (u_l, v_l, u_r, v_r) of a point in the vehicle's frame; `None` if it is not in both images, or out of the range of depths.
pub(super) fn pair(
    projections: &Projections,
    [width, height]: [f64; 2],
    [near, far]: [f64; 2],
    point: &Vector3<f64>,
) -> Option<[f64; 4]> {
    let homogeneous = Vector4::new(point.x, point.y, point.z, 1.0);
    let [left, right] = projections.each_ref().map(|camera| camera * homogeneous);
    let pixel = |seen: &Vector3<f64>| [seen.x / seen.z, seen.y / seen.z];
    let ([ul, vl], [ur, vr]) = (pixel(&left), pixel(&right));
    let shown = (near..=far).contains(&left.z)
        && [ul, ur].iter().all(|u| (0.0..=width).contains(u))
        && [vl, vr].iter().all(|v| (0.0..=height).contains(v));
    shown.then_some([ul, vl, ur, vr])
}

/// The projections in the format of a log, row by row.
pub(super) fn rows(projections: &Projections) -> [[[f64; 4]; 3]; 2] {
    projections.map(|p| std::array::from_fn(|row| std::array::from_fn(|column| p[(row, column)])))
}
