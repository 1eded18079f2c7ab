//! Models of the vehicle and its sensors: the traits that a user can implement, and the models of the crate.

mod ackermann;
mod auv;
mod auv_pose;
mod bearing_only;
mod calibrated;
mod calibrated_pose;
mod clutter;
mod constant_velocity;
mod control_noise;
mod field_of_view;
mod fix;
mod holonomic;
mod known_pose;
mod motion;
mod mounted;
mod mounting;
mod planar_motion;
mod pose;
mod range_bearing;
mod range_bearing_window;
mod range_noise;
mod self_calibrating;
mod sensing;
mod sensor;
mod sonar;
mod stereo_camera;
mod stereo_frustum;
#[cfg(test)]
mod testing;
mod unicycle;
mod varying_noise;

pub use ackermann::{Ackermann, AckermannControl, AckermannGeometry};
pub use auv::{Auv, AuvControl, Reading};
pub use auv_pose::{AuvPose, BodyFrame, rotation};
pub use bearing_only::{BearingOnly, BirthIntensity, PolarBirths, PolarGrid};
pub use calibrated::Calibrated;
pub use calibrated_pose::{CalibratedPose, OdometryCorrection};
pub use clutter::{Clutter, UniformClutter};
pub use constant_velocity::ConstantVelocity;
pub use control_noise::ControlNoise;
pub use field_of_view::FieldOfView;
pub use fix::{BeaconFix, Fix, HeadingFix, HeightFix, PositionFix};
pub use holonomic::{Holonomic, HolonomicControl};
pub use known_pose::KnownPose;
pub use motion::{Linearised, Motion, Rates};
pub(crate) use mounted::{Mounted, MountedFrame, MountedView};
pub use mounting::Mounting;
pub use planar_motion::{PlanarControl, PlanarMotion};
pub use pose::{CovarianceOf, MovingOf, PlanarPose, Pose, PositionOf, ScalarOf, TangentOf};
pub use range_bearing::{PlanarFrame, RangeBearing};
pub use range_bearing_window::{RangeBearingLimits, RangeBearingWindow};
pub use range_noise::RangeNoise;
pub use self_calibrating::{ByOdometry, OdometryPrior, SelfCalibrating};
pub(crate) use sensing::OnVehicle;
pub use sensing::{MeasurementModel, Sensing};
pub use sensor::{Expected, ExpectedOf, Inverse, InverseOf, Sensor};
pub use sonar::{RangeBearingElevation, SonarLimits, SonarWindow};
pub use stereo_camera::{StereoCamera, StereoFrame, pixel_noise, projection};
pub use stereo_frustum::{FrustumLimits, StereoFrustum};
pub use unicycle::{Step, Unicycle, UnicycleControl};
pub use varying_noise::{NoiseModel, ReportedNoise, WithNoise};
pub(crate) use varying_noise::{OwnNoise, noise_at};

/// A parameter of a model is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[error("{field} must be {range}")]
pub struct ModelError {
    /// The parameter, as the name of its field.
    pub field: &'static str,
    /// Its valid range.
    pub range: &'static str,
}

impl ModelError {
    /// The error for the `check` of a user's model: the parameter and its valid range.
    pub const fn new(field: &'static str, range: &'static str) -> Self {
        Self { field, range }
    }
}

/// Returns an error that names the field unless `holds`.
pub(crate) fn require(holds: bool, field: &'static str, range: &'static str) -> Result<(), ModelError> {
    if holds { Ok(()) } else { Err(ModelError { field, range }) }
}
