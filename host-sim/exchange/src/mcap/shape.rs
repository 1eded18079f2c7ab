//! Poses, covariances and ellipses in the format of messages.

use nalgebra::{Matrix3, Rotation3, SymmetricEigen, UnitQuaternion};
use scphd_ros::messages::{Covariance6, Point, Pose, Quaternion, Transform, Vector3};

/// Height of ellipses in the plane, m.
const FLAT_M: f64 = 0.05;
/// The 95 % quantiles of χ² with two and three degrees of freedom.
const GATES: [f64; 2] = [5.991, 7.815];

/// A position of two or three coordinates.
pub fn point(place: &[f64]) -> Point {
    let at = |k: usize| place.get(k).copied().unwrap_or(0.0);
    Point { x: at(0), y: at(1), z: at(2) }
}

pub fn pose(place: &[f64], heading_rad: f64) -> Pose {
    Pose { position: point(place), orientation: Quaternion::of_yaw(heading_rad) }
}

pub fn transform(place: &[f64], heading_rad: f64) -> Transform {
    let Point { x, y, z } = point(place);
    Transform { translation: Vector3 { x, y, z }, rotation: Quaternion::of_yaw(heading_rad) }
}

/// The frame of `b` in the frame of `a`, if the same vehicle has the pose `a` in one and `b` in the other: x m, y m, heading rad.
pub fn between(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let turn = a[2] - b[2];
    let (sine, cosine) = turn.sin_cos();
    [a[0] - cosine * b[0] + sine * b[1], a[1] - sine * b[0] - cosine * b[1], turn]
}

/// The covariance of a position with `count` coordinates followed by the heading, in the order of messages.
pub fn covariance(count: usize, entry: impl Fn(usize, usize) -> f64) -> Covariance6 {
    let own = |k: usize| match k {
        k if k < count => Some(k),
        5 => Some(count),
        _ => None,
    };
    std::array::from_fn(|row| {
        std::array::from_fn(|column| own(row).zip(own(column)).map_or(0.0, |(row, column)| entry(row, column)))
    })
}

/// The rotation and the axes (diameters, m) of the ellipse of 95 % probability.
pub fn ellipse(covariance: &[&[f64]]) -> (Quaternion, Vector3) {
    let count = covariance.len();
    let flat = count < 3;
    let gate = GATES[usize::from(!flat)];
    // In the plane the third axis is vertical.
    let entry = |row: usize, column: usize| {
        let vertical = if row == column { 0.25 * FLAT_M * FLAT_M / gate } else { 0.0 };
        covariance.get(row).and_then(|row| row.get(column)).copied().unwrap_or(vertical)
    };
    let eigen = SymmetricEigen::new(Matrix3::from_fn(entry));
    let mut axes = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    let [x, y, z] = eigen.eigenvalues.map(|variance| 2.0 * (gate * variance.max(0.0)).sqrt()).into();
    (Quaternion { x: turn.i, y: turn.j, z: turn.k, w: turn.w }, Vector3 { x, y, z })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ellipse_has_the_axes_of_the_covariance() {
        let rows = [[4.0, 1.2, 0.3], [1.2, 2.0, -0.4], [0.3, -0.4, 1.0]];
        for count in [2, 3] {
            let covariance: Vec<&[f64]> = rows[..count].iter().map(|row| &row[..count]).collect();
            let (turn, size) = ellipse(&covariance);
            let turn = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(turn.w, turn.x, turn.y, turn.z));
            let axes = turn.to_rotation_matrix();
            let gate = GATES[count - 2];
            let variances = [size.x, size.y, size.z].map(|length| 0.25 * length * length / gate);
            let made = axes * Matrix3::from_diagonal(&variances.into()) * axes.inverse();
            for row in 0..count {
                for column in 0..count {
                    assert!((made[(row, column)] - rows[row][column]).abs() < 1e-12, "{count}: {made}");
                }
            }
        }
    }

    #[test]
    fn the_odometry_frame_maps_odometry_to_the_estimate() {
        let (estimate, odometry) = ([3.0, -1.0, 2.5], [0.5, 4.0, -1.2]);
        let [x, y, turn] = between(estimate, odometry);
        let (s, c) = turn.sin_cos();
        let back = [x + c * odometry[0] - s * odometry[1], y + s * odometry[0] + c * odometry[1], turn + odometry[2]];
        back.iter().zip(estimate).for_each(|(back, estimate)| assert!((back - estimate).abs() < 1e-12));
    }

    #[test]
    fn covariances_are_in_the_order_of_messages() {
        let made = covariance(2, |row, column| (10 * row + column) as f64);
        assert_eq!((made[0][1], made[1][5], made[5][5], made[2][2]), (1.0, 12.0, 22.0, 0.0));
    }
}
