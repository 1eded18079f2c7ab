//! Vehicles in the plane: a car, a robot, or one that moves sideways too.

use crate::reason::Reason;
use crate::scphd_status;
use scphd::models::{Ackermann, AckermannGeometry, ControlNoise, Holonomic, PlanarMotion, Step, Unicycle};
use scphd::settings::Plausible;

/// A car: speed of a wheel's encoder and steering angle (5.25-5.27).
pub const SCPHD_VEHICLE_CAR: u32 = 1;
/// A robot that turns in place: speed and turn rate, along exact arcs.
pub const SCPHD_VEHICLE_ROBOT: u32 = 2;
/// A vehicle that moves sideways too, on mecanum wheels or legs: speed ahead and to the left, and turn rate, along exact arcs.
pub const SCPHD_VEHICLE_HOLONOMIC: u32 = 3;

/// A vehicle in the plane, and the noise of its odometry. The defaults are those of a wheeled vehicle whose noise nobody has measured:
/// 0.02 m/s and 10 %, 0.02 rad/s (or rad) and 10 %, for half a second. Without any noise it is refused.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_vehicle {
    /// `SCPHD_VEHICLE_CAR`, `SCPHD_VEHICLE_ROBOT` or `SCPHD_VEHICLE_HOLONOMIC`.
    pub kind: u32,
    /// Of a car: wheelbase L, m.
    pub wheelbase_m: f32,
    /// Of a car: offset H of the wheel encoder from the centreline, m.
    pub encoder_offset_m: f32,
    /// Of a car: how far ahead of the rear axle its pose is, m.
    pub pose_forward_m: f32,
    /// Of a car: how far left of the centreline its pose is, m.
    pub pose_left_m: f32,
    /// Standard deviation of the speed, m/s.
    pub speed_sigma_mps: f32,
    /// The same as a share of the speed; adds in quadrature.
    pub speed_sigma_ratio: f32,
    /// Standard deviation of a car's steering angle, rad, or of the others' turn rate, rad/s.
    pub turn_sigma: f32,
    /// The same as a share of it; adds in quadrature.
    pub turn_sigma_ratio: f32,
    /// How long an error lasts, s. 0: drawn anew in every prediction.
    pub noise_interval_s: f32,
}

/// What no vehicle does. A prediction beyond it is refused; infinite: no limit.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_plausible {
    /// Longest step, s.
    pub step_max_s: f32,
    /// Greatest speed, m/s.
    pub speed_max_mps: f32,
    /// Greatest turn rate, rad/s.
    pub turn_rate_max_radps: f32,
    /// Greatest distance of one step, m.
    pub jump_max_m: f32,
}

impl scphd_plausible {
    pub(crate) fn of(limits: Plausible<f32>) -> Self {
        let Plausible { step_max_s, speed_max_mps, turn_rate_max_radps, jump_max_m } = limits;
        Self { step_max_s, speed_max_mps, turn_rate_max_radps, jump_max_m }
    }

    pub(crate) fn limits(&self) -> Plausible<f32> {
        let Self { step_max_s, speed_max_mps, turn_rate_max_radps, jump_max_m } = *self;
        Plausible { step_max_s, speed_max_mps, turn_rate_max_radps, jump_max_m }
    }
}

impl scphd_vehicle {
    /// A robot with the noise of a wheeled vehicle.
    pub(crate) fn wheeled() -> Self {
        let ControlNoise { speed_sigma_mps, speed_sigma_ratio, turn_sigma, turn_sigma_ratio, interval_s } =
            ControlNoise::wheeled();
        Self {
            kind: SCPHD_VEHICLE_ROBOT,
            wheelbase_m: 1.0,
            encoder_offset_m: 0.0,
            pose_forward_m: 0.0,
            pose_left_m: 0.0,
            speed_sigma_mps,
            speed_sigma_ratio,
            turn_sigma,
            turn_sigma_ratio,
            noise_interval_s: interval_s,
        }
    }

    pub(crate) fn motion(&self, reason: &mut Reason<'_>) -> Result<PlanarMotion<f32>, scphd_status> {
        let noise = ControlNoise {
            speed_sigma_mps: self.speed_sigma_mps,
            speed_sigma_ratio: self.speed_sigma_ratio,
            turn_sigma: self.turn_sigma,
            turn_sigma_ratio: self.turn_sigma_ratio,
            interval_s: self.noise_interval_s,
        };
        if noise.is_none() {
            return Err(reason.field("vehicle", "not without noise: a sigma or a ratio above zero"));
        }
        let geometry = AckermannGeometry {
            wheelbase_m: self.wheelbase_m,
            encoder_offset_m: self.encoder_offset_m,
            sensor_forward_m: self.pose_forward_m,
            sensor_left_m: self.pose_left_m,
        };
        let motion = match self.kind {
            SCPHD_VEHICLE_CAR => Ackermann::new(geometry, noise).map(PlanarMotion::Ackermann),
            SCPHD_VEHICLE_ROBOT => Unicycle::new(Step::Arc, noise).map(PlanarMotion::Unicycle),
            SCPHD_VEHICLE_HOLONOMIC => Holonomic::new(noise).map(PlanarMotion::Holonomic),
            _ => return Err(reason.field("vehicle.kind", "one of SCPHD_VEHICLE_...")),
        };
        motion.map_err(|error| reason.model(error))
    }
}
