//! A stereo camera: a feature in space is measured as four pixel coordinates (7.2–7.5).

use super::{AuvPose, BodyFrame, Expected, ExpectedOf, Inverse, ModelError, Sensor, require};
use crate::{Real, Symmetric};
use nalgebra::{Matrix2x3, Matrix3, Matrix4x3, SMatrix, SVector, Vector1, Vector3, Vector4};

/// A rectified stereo camera fixed to the vehicle. It measures (u_l, v_l, u_r, v_r): column and row of a keypoint in the left and
/// in the right image, px.
///
/// Each camera is a 3 × 4 projection matrix from a point in the vehicle's frame (x ahead, y to the left, z upwards, m) to
/// homogeneous pixels (7.4). The matrix includes the mounting: P = K C [I | −c] with the calibration K, the position c and the
/// rotation C from the vehicle's axes to those of the image (x right, y down, z into the scene).
///
/// ```
/// use nalgebra::{Matrix3, Vector3, Vector4};
/// use scphd::models::{AuvPose, Sensor, StereoCamera, pixel_noise, projection};
///
/// // Looking down, with the top of the image ahead and a baseline of 0.2 m to the vehicle's right.
/// let calibration = Matrix3::new(890.0_f64, 0.0, 400.0, 0.0, 890.0, 300.0, 0.0, 0.0, 1.0);
/// let down = Matrix3::new(0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0);
/// let left = projection(&calibration, &down, &Vector3::new(0.0, 0.1, 0.0));
/// let right = projection(&calibration, &down, &Vector3::new(0.0, -0.1, 0.0));
/// let camera = StereoCamera::new(left, right, pixel_noise([3.0; 4], [0.0; 2]), 16.0)?;
///
/// let frame = camera.frame(&AuvPose::new(0.0, 0.0, 2.0, 0.0));
/// let seen = camera.expect(&frame, &Vector3::new(0.0, 0.0, 0.0)).unwrap();
/// assert!((seen.measurement - Vector4::new(444.5, 300.0, 355.5, 300.0)).norm() < 1e-9);
/// let back = camera.invert(&frame, &seen.measurement).unwrap();
/// assert!(back.feature.norm() < 1e-9);
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StereoCamera<T: Real> {
    left: Camera<T>,
    right: Camera<T>,
    noise: Symmetric<Vector4<T>>,
    /// R⁻¹.
    precision: Symmetric<Vector4<T>>,
    epipolar_gate: T,
}

/// One camera, P = [A | a].
#[derive(Debug, Clone, Copy, PartialEq)]
struct Camera<T: Real> {
    /// A.
    turn: Matrix3<T>,
    /// a.
    shift: Vector3<T>,
}

/// Covariance R of pixel noise with these standard deviations, px: independent noise of each of (u_l, v_l, u_r, v_r), and noise of
/// columns and rows that is common to both images. Common noise (from the time of the images, or the attitude of the camera) shifts
/// a feature and does not change its disparity.
#[must_use]
pub fn pixel_noise<T: Real>(own_px: [T; 4], common_px: [T; 2]) -> Symmetric<Vector4<T>> {
    let [columns, rows] = common_px.map(|sigma| sigma * sigma);
    let [ul, vl, ur, vr] = own_px.map(|sigma| sigma * sigma);
    Symmetric::from_fn(|row, column| match (row, column) {
        (0, 0) => ul + columns,
        (1, 1) => vl + rows,
        (2, 2) => ur + columns,
        (3, 3) => vr + rows,
        (2, 0) => columns,
        (3, 1) => rows,
        _ => T::ZERO,
    })
}

/// A projection matrix P = K C [I | −c] from a calibration K, the rotation C from the vehicle's axes to those of the image (x
/// right, y down, z into the scene), and the position c of the camera in the vehicle's frame, m.
#[must_use]
pub fn projection<T: Real>(calibration: &Matrix3<T>, rotation: &Matrix3<T>, place_m: &Vector3<T>) -> SMatrix<T, 3, 4> {
    let turn = calibration * rotation;
    let shift = -(turn * place_m);
    SMatrix::from_columns(&[turn.column(0).into(), turn.column(1).into(), turn.column(2).into(), shift])
}

/// Least depth of a feature in front of either camera, m: nearer features count as behind it.
const LEAST_DEPTH_M: f64 = 1e-3;

/// A stereo camera at a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StereoFrame<T: Real> {
    /// The vehicle's frame.
    pub body: BodyFrame<T>,
    /// A Rᵀ of the left and of the right camera: from map directions to homogeneous pixels.
    left: Matrix3<T>,
    right: Matrix3<T>,
    left_shift: Vector3<T>,
}

impl<T: Real> StereoFrame<T> {
    /// Depth of a point in front of the left camera, m.
    #[inline]
    #[must_use]
    pub fn depth(&self, point: &Vector3<T>) -> T {
        self.homogeneous(point).z
    }

    /// Homogeneous pixels of a point in the left image, the last of them its depth, m.
    #[inline]
    pub(super) fn homogeneous(&self, point: &Vector3<T>) -> Vector3<T> {
        self.left * (point - self.body.position) + self.left_shift
    }
}

impl<T: Real> Camera<T> {
    /// The camera of a projection matrix, scaled so that the third coordinate is the depth in m.
    fn new(projection: &SMatrix<T, 3, 4>) -> Option<Self> {
        let turn: Matrix3<T> = projection.fixed_columns::<3>(0).into();
        let shift: Vector3<T> = projection.column(3).into();
        let [[a, b, c], [d, e, f], [g, h, i]] = turn.transpose().data.0;
        let determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g);
        let length = (g * g + h * h + i * i).sqrt();
        let usable = determinant != T::ZERO && length > T::ZERO && projection.iter().all(|element| element.is_finite());
        // The scale has the sign of the determinant: a matrix and its negative describe the same camera, but only one of them has
        // positive depths in front of it.
        let scale = if determinant > T::ZERO { T::ONE / length } else { -T::ONE / length };
        usable.then_some(Self { turn: turn * scale, shift: shift * scale })
    }

    /// Pixels of a point at `offset`, where `turn` maps directions to homogeneous pixels, with their derivative; `None` for a
    /// point behind the camera. The comparison is written so that NaN counts as behind.
    #[inline]
    fn project(turn: &Matrix3<T>, shift: &Vector3<T>, offset: &Vector3<T>) -> Option<([T; 2], Matrix2x3<T>)> {
        let [[x, y, depth]] = (turn * offset + shift).data.0;
        if !(depth > T::from_f64(LEAST_DEPTH_M)) {
            return None;
        }
        let per_depth = T::ONE / depth;
        let (u, v) = (x * per_depth, y * per_depth);
        if !(u.is_finite() && v.is_finite()) {
            return None;
        }
        let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = turn.data.0;
        let slope = Matrix2x3::new(xx - u * zx, xy - u * zy, xz - u * zz, yx - v * zx, yy - v * zy, yz - v * zz);
        Some(([u, v], slope * per_depth))
    }

    /// The two rows of the linear equations (A_1 − u A_3) p = u a_3 − a_1 of a point p in the vehicle's frame that projects to
    /// (u, v), with their right-hand sides.
    fn equations(&self, u: T, v: T) -> (Matrix2x3<T>, [T; 2]) {
        let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = self.turn.data.0;
        let [[x, y, z]] = self.shift.data.0;
        let rows = Matrix2x3::new(xx - u * zx, xy - u * zy, xz - u * zz, yx - v * zx, yy - v * zy, yz - v * zz);
        (rows, [u * z - x, v * z - y])
    }
}

/// The first matrix above the second.
#[inline]
fn stacked<T: Real>(upper: &Matrix2x3<T>, lower: &Matrix2x3<T>) -> Matrix4x3<T> {
    let ([[a, d], [b, e], [c, f]], [[g, j], [h, k], [i, l]]) = (upper.data.0, lower.data.0);
    Matrix4x3::new(a, b, c, d, e, f, g, h, i, j, k, l)
}

impl<T: Real> StereoCamera<T> {
    /// A camera with these projection matrices, covariance R of the noise of (u_l, v_l, u_r, v_r), px², and epipolar gate.
    /// [`pixel_noise`] computes R from the independent and the common noise of both images.
    ///
    /// The epipolar gate limits the squared normalised part of a measurement that no point in space can cause: in rectified images
    /// (v_l − v_r)² divided by its variance. A pair beyond the gate is a mismatch, and gives no feature.
    ///
    /// # Errors
    /// The matrices must be finite, with a left 3 × 3 part that is not singular; the noise positive definite, with variances
    /// between 1e-6 and 1e6 px²; the gate positive.
    pub fn new(
        left: SMatrix<T, 3, 4>,
        right: SMatrix<T, 3, 4>,
        noise: Symmetric<Vector4<T>>,
        epipolar_gate: T,
    ) -> Result<Self, ModelError> {
        const RANGE: &str = "finite, with a 3 x 3 part that is not singular";
        let usable = |variance: T| variance >= T::from_f64(1e-6) && variance <= T::from_f64(1e6);
        let factor = noise.factor().filter(|_| (0..4).all(|k| usable(noise.get(k, k))));
        let left = Camera::new(&left).ok_or(ModelError { field: "left", range: RANGE })?;
        let right = Camera::new(&right).ok_or(ModelError { field: "right", range: RANGE })?;
        let factor = factor.ok_or(ModelError { field: "noise", range: "positive definite, of 1e-6 to 1e6 px^2" })?;
        require(epipolar_gate > T::ZERO, "epipolar_gate", "positive")?;
        Ok(Self { left, right, noise, precision: factor.inverse(), epipolar_gate })
    }

    /// The point in the vehicle's frame at this pixel of the left camera and this depth, m.
    #[must_use]
    pub(crate) fn point_at(&self, u: T, v: T, depth: T) -> Option<Vector3<T>> {
        let Camera { turn, shift } = self.left;
        let homogeneous = Vector3::new(u * depth, v * depth, depth) - shift;
        solve(&turn, &homogeneous)
    }

    /// The predicted measurement of a point in the vehicle's frame.
    fn project(&self, point: &Vector3<T>) -> Option<Expected<Vector3<T>, Vector4<T>>> {
        let ([ul, vl], left) = Camera::project(&self.left.turn, &self.left.shift, point)?;
        let ([ur, vr], right) = Camera::project(&self.right.turn, &self.right.shift, point)?;
        Some(Expected { measurement: Vector4::new(ul, vl, ur, vr), jacobian: stacked(&left, &right) })
    }

    /// (Aᵀ R⁻¹ A)⁻¹ Aᵀ R⁻¹, the weighted pseudoinverse.
    fn pseudoinverse(&self, a: &Matrix4x3<T>) -> Option<SMatrix<T, 3, 4>> {
        // R⁻¹ A, as (Aᵀ R⁻¹)ᵀ.
        let weighted: Matrix4x3<T> = self.precision.times_transpose::<Vector4<T>, Vector3<T>>(&a.transpose());
        let normal = a.tr_mul(&weighted);
        let element = |row: usize, column: usize| normal.get((row, column)).copied().unwrap_or(T::ZERO);
        let factor = Symmetric::<Vector3<T>>::from_fn(element).factor()?;
        let mut inverse = SMatrix::<T, 3, 4>::zeros();
        for (mut column, row) in inverse.column_iter_mut().zip(weighted.row_iter()) {
            column.copy_from(&factor.solve(&row.transpose()));
        }
        Some(inverse)
    }

    /// g⁻¹ of (7.5): the point in the vehicle's frame whose projection is nearest to the measurement, in standard deviations, and
    /// its derivative with respect to the measurement.
    ///
    /// The weighted linear solution, followed by a Gauss–Newton step, which also removes rounding errors of the former.
    fn triangulate(&self, measured: &Vector4<T>) -> Option<(Vector3<T>, SMatrix<T, 3, 4>)> {
        let [[ul, vl, ur, vr]] = measured.data.0;
        let (left, [lu, lv]) = self.left.equations(ul, vl);
        let (right, [ru, rv]) = self.right.equations(ur, vr);
        let start = self.pseudoinverse(&stacked(&left, &right))? * Vector4::new(lu, lv, ru, rv);
        let from_start = self.project(&start)?;
        let correction = self.pseudoinverse(&from_start.jacobian)? * (measured - from_start.measurement);
        let point = start + correction;
        let expected = self.project(&point)?;
        let residual = measured - expected.measurement;
        let mismatch = self.precision.congruence::<Vector1<T>>(&residual.transpose()).get(0, 0);
        if !(mismatch <= self.epipolar_gate) {
            return None;
        }
        Some((point, self.pseudoinverse(&expected.jacobian)?))
    }
}

/// A⁻¹ b by Cramer's rule; `None` if A is singular.
fn solve<T: Real>(a: &Matrix3<T>, b: &Vector3<T>) -> Option<Vector3<T>> {
    let [[x, y, z]] = [[a.column(0), a.column(1), a.column(2)]];
    let (x, y, z): (Vector3<T>, Vector3<T>, Vector3<T>) = (x.into(), y.into(), z.into());
    let cross = |a: &Vector3<T>, b: &Vector3<T>| {
        Vector3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
    };
    let dot = |a: &Vector3<T>, b: &Vector3<T>| a.x * b.x + a.y * b.y + a.z * b.z;
    let determinant = dot(&x, &cross(&y, &z));
    let solution = Vector3::new(dot(b, &cross(&y, &z)), dot(b, &cross(&z, &x)), dot(b, &cross(&x, &y))) / determinant;
    solution.iter().all(|coordinate| coordinate.is_finite()).then_some(solution)
}

impl<T: Real> Sensor for StereoCamera<T> {
    type Pose = AuvPose<T>;
    type Measurement = Vector4<T>;
    type Frame = StereoFrame<T>;

    /// The column in the left image: images are wider than high.
    const SORTED_BY: usize = 0;
    const SORTED_BY_ANGLE: bool = false;
    /// The row.
    const SIFTED_BY: Option<usize> = Some(1);

    fn frame(&self, pose: &Self::Pose) -> Self::Frame {
        let body = BodyFrame::of(pose);
        let to_body = body.rotation.transpose();
        StereoFrame {
            body,
            left: self.left.turn * to_body,
            right: self.right.turn * to_body,
            left_shift: self.left.shift,
        }
    }

    /// (7.2–7.4).
    #[inline]
    fn expect(&self, frame: &Self::Frame, feature: &SVector<T, 3>) -> Option<Expected<Vector3<T>, Vector4<T>>> {
        let offset = feature - frame.body.position;
        let ([ul, vl], left) = Camera::project(&frame.left, &frame.left_shift, &offset)?;
        let ([ur, vr], right) = Camera::project(&frame.right, &self.right.shift, &offset)?;
        Some(Expected { measurement: Vector4::new(ul, vl, ur, vr), jacobian: stacked(&left, &right) })
    }

    #[inline]
    fn innovation(&self, measured: &SVector<T, 4>, expected: &SVector<T, 4>) -> SVector<T, 4> {
        measured - expected
    }

    fn noise(&self) -> &Symmetric<Vector4<T>> {
        &self.noise
    }

    /// (7.5). `None` for a pair whose rays do not meet in front of both cameras (a disparity of zero or less), or that is not on
    /// one epipolar line.
    fn invert(&self, frame: &Self::Frame, measured: &SVector<T, 4>) -> Option<Inverse<Vector3<T>, Vector4<T>>> {
        let (point, by_measurement) = self.triangulate(measured)?;
        let jacobian = frame.body.rotation * by_measurement;
        let feature = frame.body.to_map(&point);
        let finite = feature.iter().chain(jacobian.iter()).all(|number| number.is_finite());
        finite.then_some(Inverse { feature, jacobian })
    }

    #[inline]
    fn by_pose(&self, frame: &Self::Frame, feature: &SVector<T, 3>, expected: &ExpectedOf<Self>) -> SMatrix<T, 4, 5> {
        frame.body.by_pose(&expected.jacobian, feature)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::{StereoCamera, pixel_noise, projection};
    use crate::models::testing::check_sensor;
    use crate::{AuvPose, Noise, Real, Sensor};
    use nalgebra::{Matrix3, SMatrix, Vector3, Vector4};

    /// A camera like that of the Girona 500, looking down, a little ahead of the vehicle's centre.
    pub(crate) fn camera<T: Real>(tilt_rad: f64) -> StereoCamera<T> {
        let (s, c) = tilt_rad.sin_cos();
        let calibration = Matrix3::new(890.0, 0.0, 400.0, 0.0, 885.0, 300.0, 0.0, 0.0, 1.0);
        let down = Matrix3::new(0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0);
        let tilted = Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c) * down;
        let side = |y: f64| projection(&calibration, &tilted, &Vector3::new(0.3, y, -0.1)).map(T::from_f64);
        let noise = pixel_noise([3.0; 4].map(T::from_f64), [T::ZERO; 2]);
        StereoCamera::new(side(0.1), side(-0.1), noise, T::from_f64(16.0)).unwrap()
    }

    fn poses() -> [AuvPose<f64>; 3] {
        let tilted =
            |yaw, roll, pitch| AuvPose { roll_rad: roll, pitch_rad: pitch, ..AuvPose::new(1.0, -2.0, 0.5, yaw) };
        [tilted(0.0, 0.0, 0.0), tilted(2.9, 0.2, -0.1), tilted(-1.2, -0.3, 0.25)]
    }

    /// Features a few metres in front of the camera.
    fn features(frame: &super::StereoFrame<f64>) -> impl Iterator<Item = Vector3<f64>> {
        let frame = *frame;
        (0..27).map(move |k| {
            let [x, y, z] = [k % 3, k / 3 % 3, k / 9].map(f64::from);
            frame.body.to_map(&Vector3::new(0.3 + 0.5 * (x - 1.0), 0.6 * (y - 1.0), -1.5 - 1.2 * z))
        })
    }

    #[test]
    fn derivatives_agree_with_differences_and_the_inverse_inverts() {
        let camera = camera::<f64>(0.2);
        for pose in poses() {
            let frame = camera.frame(&pose);
            for feature in features(&frame) {
                check_sensor(&camera, &pose, &feature, 2e-4);
                let seen = camera.expect(&frame, &feature).unwrap();
                let back = camera.invert(&frame, &seen.measurement).unwrap();
                assert!((back.feature - feature).norm() < 1e-10);
                assert!((back.jacobian * seen.jacobian - Matrix3::identity()).norm() < 1e-10);
                assert!((frame.depth(&feature) - (feature - frame.body.position).norm()).abs() < 1.5);
            }
        }
    }

    #[test]
    fn the_derivative_of_the_inverse_agrees_with_differences() {
        let camera = camera::<f64>(0.1);
        for pose in poses() {
            let frame = camera.frame(&pose);
            for feature in features(&frame) {
                let measured = camera.expect(&frame, &feature).unwrap().measurement;
                let slope = camera.invert(&frame, &measured).unwrap().jacobian;
                for k in 0..4 {
                    let at = |step: f64| {
                        let mut offset = Vector4::zeros();
                        offset[k] = step;
                        camera.invert(&frame, &(measured + offset)).unwrap().feature
                    };
                    let difference = (at(1e-3) - at(-1e-3)) / 2e-3;
                    assert!((difference - slope.column(k)).norm() < 1e-6 * slope.norm(), "{difference} {slope}");
                }
            }
        }
    }

    /// R* = H* R H*ᵀ (7.5) is the covariance of triangulated points within the accuracy of linearisation: with noise of 0.3 px
    /// the depth is nearly linear in the disparity.
    #[test]
    fn the_covariance_of_the_triangulation_is_that_of_samples() {
        let camera = camera::<f64>(0.0);
        let pose = poses()[1];
        let frame = camera.frame(&pose);
        let feature = frame.body.to_map(&Vector3::new(0.5, -0.4, -2.4));
        let measured = camera.expect(&frame, &feature).unwrap().measurement;
        let inverse = camera.invert(&frame, &measured).unwrap();
        let sigma = 0.3;
        let expected = inverse.jacobian * inverse.jacobian.transpose() * (sigma * sigma);
        let (mut noise, runs) = (Noise::seeded(8), 40_000);
        let mut covariance = SMatrix::<f64, 3, 3>::zeros();
        let mut mean = Vector3::zeros();
        for _ in 0..runs {
            let drawn = measured + Vector4::from_fn(|_, _| sigma * noise.normal::<f64>());
            let off = camera.invert(&frame, &drawn).unwrap().feature - feature;
            mean += off / f64::from(runs);
            covariance += off * off.transpose() / f64::from(runs);
        }
        for (row, column) in [(0, 0), (1, 1), (2, 2), (1, 0), (2, 0), (2, 1)] {
            let scale = (expected[(row, row)] * expected[(column, column)]).sqrt();
            assert!(
                (covariance[(row, column)] - expected[(row, column)]).abs() < 0.03 * scale,
                "{covariance} {expected}"
            );
        }
        assert!(mean.norm() < 0.05 * expected.trace().sqrt());
        // Along the line of sight the standard deviation is more than ten times that across it.
        let eigenvalues = expected.symmetric_eigenvalues();
        assert!(eigenvalues.max() / eigenvalues.min() > 100.0);
    }

    #[test]
    fn single_precision_errors_are_small_against_the_covariance() {
        let (coarse, fine) = (camera::<f32>(0.1), camera::<f64>(0.1));
        let frame = fine.frame(&poses()[0]);
        let coarse_frame = coarse.frame(&AuvPose::new(1.0, -2.0, 0.5, 0.0));
        for feature in features(&frame) {
            let measured = fine.expect(&frame, &feature).unwrap().measurement + Vector4::new(1.0, -2.0, 0.5, 1.0);
            let exact = fine.invert(&frame, &measured).unwrap();
            let sigma = (exact.jacobian * exact.jacobian.transpose() * 9.0).trace().sqrt();
            let single = coarse.invert(&coarse_frame, &measured.map(|x| x as f32)).unwrap().feature.map(f64::from);
            assert!((single - exact.feature).norm() < 0.01 * sigma, "{single} {}", exact.feature);
        }
    }

    #[test]
    fn features_and_measurements_without_a_result_give_none() {
        let camera = camera::<f64>(0.0);
        let frame = camera.frame(&poses()[0]);
        let body = |x, y, z| frame.body.to_map(&Vector3::new(x, y, z));
        assert!(camera.expect(&frame, &body(0.3, 0.0, 1.0)).is_none(), "behind");
        assert!(camera.expect(&frame, &body(0.3, 0.0, -0.1)).is_none(), "in the plane of the lenses");
        assert!(camera.expect(&frame, &Vector3::new(f64::NAN, 0.0, 0.0)).is_none());
        let seen = camera.expect(&frame, &body(0.3, 0.0, -2.1)).unwrap().measurement;
        assert!(camera.invert(&frame, &seen).is_some());
        let with = |ur: f64, vr: f64| camera.invert(&frame, &Vector4::new(seen[0], seen[1], ur, vr));
        assert!(with(seen[0], seen[3]).is_none(), "no disparity");
        assert!(with(seen[0] + 20.0, seen[3]).is_none(), "negative disparity");
        // Four standard deviations of the difference of two rows.
        assert!(with(seen[2], seen[3] + 3.9 * 18.0_f64.sqrt()).is_some());
        assert!(with(seen[2], seen[3] + 4.1 * 18.0_f64.sqrt()).is_none(), "epipolar mismatch");
    }

    #[test]
    fn a_matrix_and_its_multiples_are_the_same_camera() {
        let calibration = Matrix3::new(500.0, 0.0, 320.0, 0.0, 500.0, 240.0, 0.0, 0.0, 1.0);
        let left = projection(&calibration, &Matrix3::identity(), &Vector3::zeros());
        let right = projection(&calibration, &Matrix3::identity(), &Vector3::new(0.24, 0.0, 0.0));
        let noise = pixel_noise([1.0; 4], [0.0; 2]);
        let plain = StereoCamera::new(left, right, noise, 9.0).unwrap();
        let scaled = StereoCamera::new(left * -7.0, right * 0.5, noise, 9.0).unwrap();
        let frame = |camera: &StereoCamera<f64>| camera.frame(&poses()[1]);
        let feature = frame(&plain).body.to_map(&Vector3::new(0.2, -0.1, 3.0));
        let [a, b] = [plain, scaled].map(|camera| camera.expect(&frame(&camera), &feature).unwrap());
        assert!((a.measurement - b.measurement).norm() < 1e-10 && (a.jacobian - b.jacobian).norm() < 1e-10);
        let error = |left, right, noise, gate| StereoCamera::new(left, right, noise, gate).unwrap_err().field;
        assert_eq!(error(left * 0.0, right, noise, 9.0), "left");
        assert_eq!(error(left, right * f64::NAN, noise, 9.0), "right");
        assert_eq!(error(left, right, pixel_noise([1.0, 1.0, 0.0, 1.0], [0.0; 2]), 9.0), "noise");
        assert_eq!(error(left, right, noise, f64::NAN), "epipolar_gate");
    }

    /// Noise that is common to both images moves the point across the line of sight, and does not change the variance of its depth.
    #[test]
    fn common_noise_does_not_change_the_variance_of_the_depth() {
        let camera = camera::<f64>(0.0);
        let shaken = StereoCamera { noise: pixel_noise([3.0; 4], [30.0; 2]), ..camera };
        let shaken = StereoCamera { precision: shaken.noise.factor().unwrap().inverse(), ..shaken };
        let frame = camera.frame(&poses()[0]);
        let measured = camera.expect(&frame, &frame.body.to_map(&Vector3::new(0.5, 0.2, -2.4))).unwrap().measurement;
        let covariance = |camera: &StereoCamera<f64>| {
            let jacobian = camera.invert(&frame, &measured).unwrap().jacobian;
            camera.noise().congruence::<Vector3<f64>>(&jacobian)
        };
        let (alone, common) = (covariance(&camera), covariance(&shaken));
        assert!((common.get(2, 2) / alone.get(2, 2) - 1.0).abs() < 1e-9);
        assert!(common.get(0, 0) > 20.0 * alone.get(0, 0));
    }
}
