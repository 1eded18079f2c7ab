//! The vehicle state (parent state).

use super::{ModelError, Mounting, require};
use crate::{Place, Real, Symmetric, Vector, Zero, wrap};
use core::fmt::Debug;
use nalgebra::{Vector2, Vector3};

/// The scalar type of a vehicle state.
pub type ScalarOf<P> = <P as Pose>::Scalar;
/// The covariance of a vehicle state.
pub type CovarianceOf<P> = Symmetric<TangentOf<P>>;
/// The difference of two vehicle states (tangent space).
pub type TangentOf<P> = <P as Pose>::Tangent;
/// The position of a feature in the map of a vehicle.
pub type PositionOf<P> = <P as Pose>::Position;
/// Position and velocity of a feature in the map of a vehicle.
pub type MovingOf<P> = <PositionOf<P> as Place>::Moving;

/// A vehicle state, X in the thesis (5.1).
pub trait Pose: Copy + PartialEq + Debug + Send + Sync {
    /// `f32` or `f64`.
    type Scalar: Real;
    /// The difference of two states: one coordinate for each degree of freedom.
    type Tangent: Vector<Scalar = Self::Scalar>;
    /// The position of a feature in the map.
    type Position: Place<Scalar = Self::Scalar>;

    /// All zero.
    const ZERO: Self;

    /// Index of the heading coordinate, if there is one; the first two coordinates are then x and y, as for features. A rotation of
    /// vehicle and map together does not change any measurement (the heading is unobservable). A joint map must know this
    /// coordinate, because otherwise linearisation errors would reduce the variance of the heading without information.
    const HEADING: Option<usize> = None;

    /// The coordinates, for checks and digests.
    fn coordinates(&self) -> Self::Tangent;

    /// All numbers of the pose in sequence, for a [snapshot](crate::ScPhd::save): always the same count, and all that
    /// [`of_numbers`](Self::of_numbers) needs.
    fn to_numbers(&self, take: impl FnMut(Self::Scalar));

    /// The pose from these numbers, in the order of [`to_numbers`](Self::to_numbers), equal to the bit.
    fn of_numbers(next: impl FnMut() -> Self::Scalar) -> Self;

    /// The difference `self` ⊖ `from` in the tangent space, angles wrapped.
    fn difference(&self, from: &Self) -> Self::Tangent;

    /// The pose displaced by `by`, `self` ⊕ `by`: the inverse of [`Self::difference`], angles wrapped.
    #[must_use]
    fn displaced(&self, by: &Self::Tangent) -> Self;

    /// The weighted mean of poses with weights that sum to one; angles by their circular mean.
    fn mean(weighted: impl Iterator<Item = (Self::Scalar, Self)>) -> Self;

    /// Position and heading on the ground: x and y, m, and heading, rad.
    fn on_ground(&self) -> [Self::Scalar; 3];

    /// Height, m; 0 in the plane.
    fn height_m(&self) -> Self::Scalar {
        Zero::ZERO
    }

    /// Distance of two poses, m, without angles.
    fn distance_m(&self, from: &Self) -> Self::Scalar {
        let ([x, y, _], [from_x, from_y, _]) = (self.on_ground(), from.on_ground());
        let (dx, dy) = (x - from_x, y - from_y);
        (dx * dx + dy * dy).sqrt()
    }

    /// Checks that a sensor on this type of vehicle can have this mounting.
    ///
    /// # Errors
    /// Names the first parameter out of range, and its range. No errors by default.
    fn check_mounting(_mounting: &Mounting<Self::Scalar>) -> Result<(), ModelError> {
        Ok(())
    }

    /// The pose of a sensor with this mounting, and its derivative with respect to the vehicle's [heading](Self::HEADING), in the
    /// coordinates of [`difference`](Self::difference). When any other coordinate of the vehicle changes, the sensor's pose changes
    /// by the same amount.
    fn mounted(&self, mounting: &Mounting<Self::Scalar>) -> (Self, Self::Tangent);

    /// Whether every coordinate is finite.
    fn is_finite(&self) -> bool {
        self.coordinates().as_slice().iter().all(|coordinate| coordinate.is_finite())
    }
}

/// Position and heading in the plane: (x, y, θ) of section 5.3.1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanarPose<T> {
    /// x, m.
    pub x_m: T,
    /// y, m.
    pub y_m: T,
    /// Heading θ, rad, from the x axis towards the y axis.
    pub heading_rad: T,
}

impl<T: Real> PlanarPose<T> {
    /// A pose from x (m), y (m) and heading (rad).
    pub const fn new(x_m: T, y_m: T, heading_rad: T) -> Self {
        Self { x_m, y_m, heading_rad }
    }
}

impl<T: Real> Pose for PlanarPose<T> {
    type Scalar = T;
    type Tangent = Vector3<T>;
    type Position = Vector2<T>;

    const ZERO: Self = Self::new(T::ZERO, T::ZERO, T::ZERO);
    const HEADING: Option<usize> = Some(2);

    fn coordinates(&self) -> Vector3<T> {
        Vector3::new(self.x_m, self.y_m, self.heading_rad)
    }

    fn to_numbers(&self, take: impl FnMut(T)) {
        [self.x_m, self.y_m, self.heading_rad].into_iter().for_each(take);
    }

    fn of_numbers(mut next: impl FnMut() -> T) -> Self {
        Self { x_m: next(), y_m: next(), heading_rad: next() }
    }

    fn difference(&self, from: &Self) -> Vector3<T> {
        Vector3::new(self.x_m - from.x_m, self.y_m - from.y_m, wrap(self.heading_rad - from.heading_rad))
    }

    fn displaced(&self, by: &Vector3<T>) -> Self {
        let [[x, y, heading]] = by.data.0;
        Self::new(self.x_m + x, self.y_m + y, wrap(self.heading_rad + heading))
    }

    fn on_ground(&self) -> [T; 3] {
        [self.x_m, self.y_m, self.heading_rad]
    }

    fn check_mounting(mounting: &Mounting<T>) -> Result<(), ModelError> {
        let ([_, _, up], [roll, pitch, _]) = (mounting.position_m(), mounting.angles_rad());
        require(up == T::ZERO, "up_m", "0 in the plane")?;
        require(roll == T::ZERO, "roll_rad", "0 in the plane")?;
        require(pitch == T::ZERO, "pitch_rad", "0 in the plane")
    }

    fn mounted(&self, mounting: &Mounting<T>) -> (Self, Vector3<T>) {
        let ([forward, left, _], [_, _, yaw]) = (mounting.position_m(), mounting.angles_rad());
        let (sine, cosine) = self.heading_rad.sin_cos();
        let (x, y) = (forward * cosine - left * sine, forward * sine + left * cosine);
        let seat = Self::new(self.x_m + x, self.y_m + y, wrap(self.heading_rad + yaw));
        // A rotation of the vehicle moves the sensor around it.
        (seat, Vector3::new(-y, x, T::ONE))
    }

    fn mean(weighted: impl Iterator<Item = (T, Self)>) -> Self {
        let (mut x, mut y, mut sine, mut cosine) = (T::ZERO, T::ZERO, T::ZERO, T::ZERO);
        for (weight, pose) in weighted {
            let (s, c) = pose.heading_rad.sin_cos();
            x += weight * pose.x_m;
            y += weight * pose.y_m;
            sine += weight * s;
            cosine += weight * c;
        }
        Self::new(x, y, sine.atan2(cosine))
    }
}

#[cfg(test)]
mod tests {
    use super::{PlanarPose, Pose};

    #[test]
    fn headings_average_across_pi() {
        let poses = [PlanarPose::new(1.0, 2.0, 3.1_f64), PlanarPose::new(3.0, 4.0, -3.1)];
        let mean = PlanarPose::mean(poses.into_iter().map(|pose| (0.5, pose)));
        assert!((mean.x_m - 2.0).abs() < 1e-15 && (mean.y_m - 3.0).abs() < 1e-15);
        assert!((mean.heading_rad.abs() - core::f64::consts::PI).abs() < 1e-15);
        let turned = poses[0].difference(&poses[1])[2];
        assert!((turned - (6.2 - core::f64::consts::TAU)).abs() < 1e-15);
    }
}
