//! Models of the vehicle and its sensor: the traits a user may implement, and the models that come with the crate.

mod ackermann;
mod auv;
mod auv_pose;
mod bearing_only;
mod clutter;
mod constant_velocity;
mod control_noise;
mod field_of_view;
mod known_pose;
mod motion;
mod pose;
mod range_bearing;
mod sensor;
mod sonar;
mod stereo_camera;
mod stereo_frustum;
#[cfg(test)]
mod testing;
mod unicycle;

pub use ackermann::{Ackermann, AckermannControl, AckermannGeometry};
pub use auv::{Auv, AuvControl, Reading};
pub use auv_pose::{AuvPose, BodyFrame, rotation};
pub use bearing_only::{BearingOnly, BirthIntensity, PolarBirths, PolarGrid};
pub(crate) use clutter::is_rate;
pub use clutter::{Clutter, UniformClutter};
pub use constant_velocity::ConstantVelocity;
pub use control_noise::ControlNoise;
pub use field_of_view::{FieldOfView, RangeBearingLimits, RangeBearingWindow};
pub use known_pose::KnownPose;
pub use motion::{Linearised, Motion};
pub use pose::{PlanarPose, Pose};
pub use range_bearing::{PlanarFrame, RangeBearing};
pub use sensor::{Expected, Inverse, Locating, Sensor};
pub use sonar::{
    BearingElevation, RangeBearingElevation, RangeOnly, SonarLimits, SonarWindow, SphericalBirths, SphericalGrid,
};
pub use stereo_camera::{StereoCamera, StereoFrame, pixel_noise, projection};
pub use stereo_frustum::{FrustumLimits, StereoFrustum};
pub use unicycle::{Step, Unicycle, UnicycleControl};

use crate::{Dim, Packed, Real, SetupError};

/// A parameter of a model is not one the model can work with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct ModelError {
    /// The parameter, by the name of its field.
    pub field: &'static str,
    /// What it must be.
    pub range: &'static str,
}

impl core::fmt::Display for ModelError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} must be {}", self.field, self.range)
    }
}

impl core::error::Error for ModelError {}

/// `Ok` where `holds`, otherwise the error that names the field.
pub(crate) fn require(holds: bool, field: &'static str, range: &'static str) -> Result<(), ModelError> {
    if holds { Ok(()) } else { Err(ModelError { field, range }) }
}

/// The models one filter works with.
///
/// Models that come with the crate are checked where they are made. Those of a user are asked by
/// [`ScPhd::new`](crate::ScPhd::new) and [`ScPhd::retune`](crate::ScPhd::retune) whether they can be worked with (`check` of each
/// trait). Whatever they return later, no weight and no stored feature becomes NaN of it, and no loop goes on for ever:
///
/// | returned | taken for |
/// |---|---|
/// | p_D of 1 or more | 1 less a rounding error |
/// | p_D not above zero, NaN | out of view |
/// | ln κ that is NaN or +∞ | no clutter |
/// | an expected measurement, a Jacobian, an innovation that is not finite | a feature that meets no measurement |
/// | an inverse that is not finite | a measurement without birth |
/// | a component of the birth intensity that is not finite or not positive definite | none |
/// | more of those than `VIEW` of the static maps | none, and counted as lost |
/// | a pose that is not finite, a transition or noise of the motion that is not | the pose as it was, counted as rejected |
/// | a covariance of the measurement noise that is not positive definite | [`ScanError::SensorNoise`](crate::ScanError::SensorNoise) |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Models<M, S, V, C> {
    /// How the vehicle moves: π(x_k | x_{k−1}, u_k).
    pub motion: M,
    /// What its sensor measures: h, its inverse and their noise.
    pub sensor: S,
    /// Where the sensor sees: p_D(m | x).
    pub field_of_view: V,
    /// What it measures though nothing is there: κ(z).
    pub clutter: C,
}

impl<M, S, V, C> Models<M, S, V, C> {
    /// Whether a filter can work with these models whose updates have room for so many components.
    pub(crate) fn check_for<T: Real, const K: usize, const D: usize, const Z: usize>(
        &self,
        capacity: usize,
    ) -> Result<(), SetupError>
    where
        M: Motion<T, K>,
        S: Sensor<T, D, Z, Pose = M::Pose>,
        V: FieldOfView<T, S::Frame, D, Z>,
        C: Clutter<T, Z>,
        Dim<K>: Packed,
        Dim<D>: Packed,
        Dim<Z>: Packed,
    {
        Motion::check(&self.motion)?;
        Sensor::check(&self.sensor)?;
        FieldOfView::check(&self.field_of_view)?;
        Clutter::check(&self.clutter)?;
        require(self.sensor.noise().factor().is_some(), "noise", "positive definite")?;
        let frame = self.sensor.frame(&M::Pose::ZERO);
        if (0..=capacity).all(|index| self.sensor.expected_birth(&frame, index).is_some()) {
            return Err(SetupError::TooManyBirths { capacity });
        }
        Ok(())
    }
}
