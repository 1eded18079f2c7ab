//! The vehicle state (parent state) of an underwater vehicle, and its body frame.

use super::{Mounting, Pose};
use crate::{Real, wrap};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3, Vector5};

/// Position, yaw and yaw rate of a vehicle in space: (x, y, z, θ, θ̇) of section 7.2.2, with roll and pitch from its inertial unit.
///
/// The complete state of the vehicle has twelve dimensions, too many for particles: position, velocity, three angles and their
/// rates. Quantities that are measured well are therefore not sampled: roll, pitch and their rates are taken from the inertial
/// unit, and the velocity is estimated separately by the [`VelocityFilter`](crate::navigation::VelocityFilter), because it hardly
/// depends on the position. The particles sample the five other coordinates. Roll and pitch are stored with the pose as the last
/// control set them: they are the same in all particles, and are not among its coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AuvPose<T> {
    /// x, m.
    pub x_m: T,
    /// y, m.
    pub y_m: T,
    /// z, m, upwards.
    pub z_m: T,
    /// Yaw θ, rad, from the x axis towards the y axis.
    pub yaw_rad: T,
    /// Yaw rate θ̇, rad/s.
    pub yaw_rate_radps: T,
    /// Roll φ, rad, about the vehicle's x axis. Given, not estimated.
    pub roll_rad: T,
    /// Pitch ψ, rad, about the vehicle's y axis. Given, not estimated.
    pub pitch_rad: T,
}

impl<T: Real> AuvPose<T> {
    /// The pose of a level vehicle at rest, from its position (m) and yaw (rad).
    pub const fn new(x_m: T, y_m: T, z_m: T, yaw_rad: T) -> Self {
        Self { x_m, y_m, z_m, yaw_rad, yaw_rate_radps: T::ZERO, roll_rad: T::ZERO, pitch_rad: T::ZERO }
    }

    /// Position, m.
    pub fn position(&self) -> Vector3<T> {
        Vector3::new(self.x_m, self.y_m, self.z_m)
    }
}

impl<T: Real> Pose for AuvPose<T> {
    type Scalar = T;
    type Tangent = Vector5<T>;
    type Position = Vector3<T>;

    const ZERO: Self = Self::new(T::ZERO, T::ZERO, T::ZERO, T::ZERO);
    const HEADING: Option<usize> = Some(3);

    fn coordinates(&self) -> Vector5<T> {
        Vector5::from([self.x_m, self.y_m, self.z_m, self.yaw_rad, self.yaw_rate_radps])
    }

    fn to_numbers(&self, take: impl FnMut(T)) {
        let Self { x_m, y_m, z_m, yaw_rad, yaw_rate_radps, roll_rad, pitch_rad } = *self;
        [x_m, y_m, z_m, yaw_rad, yaw_rate_radps, roll_rad, pitch_rad].into_iter().for_each(take);
    }

    fn of_numbers(mut next: impl FnMut() -> T) -> Self {
        Self {
            x_m: next(),
            y_m: next(),
            z_m: next(),
            yaw_rad: next(),
            yaw_rate_radps: next(),
            roll_rad: next(),
            pitch_rad: next(),
        }
    }

    fn difference(&self, from: &Self) -> Vector5<T> {
        Vector5::from([
            self.x_m - from.x_m,
            self.y_m - from.y_m,
            self.z_m - from.z_m,
            wrap(self.yaw_rad - from.yaw_rad),
            self.yaw_rate_radps - from.yaw_rate_radps,
        ])
    }

    fn displaced(&self, by: &Vector5<T>) -> Self {
        let [[x, y, z, yaw, rate]] = by.data.0;
        Self {
            x_m: self.x_m + x,
            y_m: self.y_m + y,
            z_m: self.z_m + z,
            yaw_rad: wrap(self.yaw_rad + yaw),
            yaw_rate_radps: self.yaw_rate_radps + rate,
            ..*self
        }
    }

    fn distance_m(&self, from: &Self) -> T {
        let [[dx, dy, dz]] = (self.position() - from.position()).data.0;
        (dx * dx + dy * dy + dz * dz).sqrt()
    }

    fn on_ground(&self) -> [T; 3] {
        [self.x_m, self.y_m, self.yaw_rad]
    }

    fn height_m(&self) -> T {
        self.z_m
    }

    fn mounted(&self, mounting: &Mounting<T>) -> (Self, Vector5<T>) {
        let (position, [roll, pitch, yaw]) = (mounting.position_m(), mounting.angles_rad());
        let BodyFrame { position: origin, rotation: of_vehicle } = BodyFrame::of(self);
        let lever = of_vehicle * Vector3::from(position);
        let [[x_m, y_m, z_m]] = (origin + lever).data.0;
        let [roll_rad, pitch_rad, yaw_rad] = angles(&(of_vehicle * rotation(roll, pitch, yaw)));
        let seat = Self { x_m, y_m, z_m, yaw_rad, yaw_rate_radps: self.yaw_rate_radps, roll_rad, pitch_rad };
        // A rotation of the vehicle about the vertical moves the sensor around it.
        let [[x, y, _]] = lever.data.0;
        (seat, Vector5::from([-y, x, T::ZERO, T::ONE, T::ZERO]))
    }

    fn mean(weighted: impl Iterator<Item = (T, Self)>) -> Self {
        let mut mean = Self::ZERO;
        let (mut sine, mut cosine) = (T::ZERO, T::ZERO);
        for (weight, pose) in weighted {
            let (s, c) = pose.yaw_rad.sin_cos();
            mean.x_m += weight * pose.x_m;
            mean.y_m += weight * pose.y_m;
            mean.z_m += weight * pose.z_m;
            mean.yaw_rate_radps += weight * pose.yaw_rate_radps;
            sine += weight * s;
            cosine += weight * c;
            (mean.roll_rad, mean.pitch_rad) = (pose.roll_rad, pose.pitch_rad);
        }
        Self { yaw_rad: sine.atan2(cosine), ..mean }
    }

    fn is_finite(&self) -> bool {
        self.coordinates().iter().all(|coordinate| coordinate.is_finite())
            && self.roll_rad.is_finite()
            && self.pitch_rad.is_finite()
    }
}

/// Rotation matrix R(φ, ψ, θ) from the body frame (x ahead, y to the left, z upwards) to the map frame; roll first, then pitch,
/// then yaw.
#[must_use]
pub fn rotation<T: Real>(roll_rad: T, pitch_rad: T, yaw_rad: T) -> Matrix3<T> {
    let ((sr, cr), (sp, cp), (sy, cy)) = (roll_rad.sin_cos(), pitch_rad.sin_cos(), yaw_rad.sin_cos());
    Matrix3::new(
        cy * cp,
        cy * sp * sr - sy * cr,
        cy * sp * cr + sy * sr,
        sy * cp,
        sy * sp * sr + cy * cr,
        sy * sp * cr - cy * sr,
        -sp,
        cp * sr,
        cp * cr,
    )
}

/// Roll, pitch and yaw of a [`rotation`], rad. If the x axis is vertical, the yaw depends on rounding errors, and the roll agrees
/// with it.
fn angles<T: Real>(rotation: &Matrix3<T>) -> [T; 3] {
    let [[xx, xy, xz], [yx, yy, _], [zx, zy, _]] = rotation.data.0;
    let yaw = xy.atan2(xx);
    let (sine, cosine) = yaw.sin_cos();
    let pitch = (-xz).atan2(cosine * xx + sine * xy);
    let roll = (sine * zx - cosine * zy).atan2(cosine * yy - sine * yx);
    [roll, pitch, yaw]
}

/// The body frame of a vehicle: its origin and rotation in the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyFrame<T: Real> {
    /// Position T_k, m.
    pub position: Vector3<T>,
    /// R(φ, ψ, θ), from body to map directions.
    pub rotation: Matrix3<T>,
}

impl<T: Real> BodyFrame<T> {
    /// The frame of a pose.
    pub fn of(pose: &AuvPose<T>) -> Self {
        Self { position: pose.position(), rotation: rotation(pose.roll_rad, pose.pitch_rad, pose.yaw_rad) }
    }

    /// Transforms a point from the map to the body frame: Rᵀ (m − T). (7.4) has −T without the rotation.
    #[inline]
    #[must_use]
    pub fn to_body(&self, point: &Vector3<T>) -> Vector3<T> {
        self.rotation.tr_mul(&(point - self.position))
    }

    /// Transforms a point from the body to the map frame: T + R p, as in (7.5).
    #[inline]
    #[must_use]
    pub fn to_map(&self, point: &Vector3<T>) -> Vector3<T> {
        self.position + self.rotation * point
    }

    /// ∂h/∂x of any sensor fixed to the vehicle, from H = ∂h/∂m: a translation of the vehicle has the effect of the opposite
    /// translation of the feature, and a rotation about the vertical that of the opposite rotation of the feature. The yaw rate has
    /// no effect.
    #[inline]
    #[must_use]
    pub fn by_pose<const Z: usize>(&self, by_feature: &SMatrix<T, Z, 3>, feature: &SVector<T, 3>) -> SMatrix<T, Z, 5> {
        let [[dx, dy, _]] = (feature - self.position).data.0;
        let (zero, one) = (T::ZERO, T::ONE);
        #[rustfmt::skip]
        let moves = SMatrix::<T, 3, 5>::from_row_slice(&[
            -one, zero, zero, dy, zero,
            zero, -one, zero, -dx, zero,
            zero, zero, -one, zero, zero,
        ]);
        by_feature * moves
    }
}

#[cfg(test)]
mod tests {
    use super::{AuvPose, BodyFrame, rotation};
    use crate::Pose;
    use nalgebra::{Matrix3, Rotation3, Vector3, Vector5};

    #[test]
    fn roll_comes_first_then_pitch_then_yaw() {
        for (roll, pitch, yaw) in [(0.3, -0.2, 2.9), (-3.0, 1.2, -0.4), (0.0, 0.0, 1.0_f64)] {
            let ours = rotation(roll, pitch, yaw);
            let theirs = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw)
                * Rotation3::from_axis_angle(&Vector3::y_axis(), pitch)
                * Rotation3::from_axis_angle(&Vector3::x_axis(), roll);
            assert!((ours - theirs.matrix()).norm() < 1e-14);
            assert!((ours.transpose() * ours - Matrix3::identity()).norm() < 1e-14);
        }
    }

    #[test]
    fn frame_transforms_are_inverse() {
        let pose = AuvPose { roll_rad: 0.2, pitch_rad: -0.1, ..AuvPose::new(1.0, -2.0, 3.0, 2.5_f64) };
        let frame = BodyFrame::of(&pose);
        let point = Vector3::new(0.3, -4.0, 1.5);
        assert!((frame.to_map(&frame.to_body(&point)) - point).norm() < 1e-14);
        assert!(frame.to_body(&pose.position()).norm() < 1e-15);
    }

    #[test]
    fn differences_and_means_wrap_and_keep_the_attitude() {
        let tilted = |yaw| AuvPose { roll_rad: 0.3, pitch_rad: 0.1, ..AuvPose::new(1.0, 2.0, 3.0, yaw) };
        let (a, b) = (tilted(3.1_f64), tilted(-3.1));
        assert!((a.difference(&b)[3] - (6.2 - core::f64::consts::TAU)).abs() < 1e-14);
        let mean = AuvPose::mean([(0.5, a), (0.5, b)].into_iter());
        assert!((mean.yaw_rad.abs() - core::f64::consts::PI).abs() < 1e-14);
        assert_eq!((mean.roll_rad, mean.pitch_rad, mean.z_m), (0.3, 0.1, 3.0));
        let by = Vector5::from([0.1, 0.2, 0.3, 0.5, 0.6]);
        assert!((a.displaced(&by).difference(&a) - by).norm() < 1e-14);
        assert_eq!(a.displaced(&by).roll_rad, 0.3);
        assert!(!AuvPose { roll_rad: f64::NAN, ..a }.is_finite());
    }
}
