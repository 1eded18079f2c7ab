//! Where a sensor sits.

use crate::reason::Reason;
use crate::scphd_status;
use scphd::models::Mounting;

/// Where a sensor sits on its vehicle and how it is turned: from where the pose is, x ahead, y to the left, z upwards; roll first, then
/// pitch, then yaw. In the plane up, roll and pitch must be 0.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_mounting {
    /// Ahead, m.
    pub forward_m: f32,
    /// To the left, m.
    pub left_m: f32,
    /// Upwards, m.
    pub up_m: f32,
    /// About the axis ahead, rad.
    pub roll_rad: f32,
    /// About the axis to the left, rad.
    pub pitch_rad: f32,
    /// About the axis upwards, rad.
    pub yaw_rad: f32,
}

impl scphd_mounting {
    /// Where the pose is.
    pub(crate) const NONE: Self =
        Self { forward_m: 0.0, left_m: 0.0, up_m: 0.0, roll_rad: 0.0, pitch_rad: 0.0, yaw_rad: 0.0 };

    /// `None` where the sensor's pose is the vehicle's.
    pub(crate) fn mounting(&self, reason: &mut Reason<'_>) -> Result<Option<Mounting<f32>>, scphd_status> {
        let place = [self.forward_m, self.left_m, self.up_m];
        let angles = [self.roll_rad, self.pitch_rad, self.yaw_rad];
        if place.iter().chain(&angles).all(|&number| number == 0.0) {
            return Ok(None);
        }
        Mounting::in_space(place, angles).map(Some).map_err(|error| reason.model(error))
    }
}
