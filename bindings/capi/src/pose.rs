//! Estimated poses.

use crate::pointer::Versioned;
use core::array::from_fn;
use scphd::PoseEstimate;
use scphd::models::{AuvPose, OdometryCorrection, PlanarPose};

/// A pose in the plane and its covariance.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_plane_pose {
    /// `sizeof(scphd_plane_pose)`, set by the caller.
    pub struct_size: u32,
    /// x, m.
    pub x_m: f32,
    /// y, m.
    pub y_m: f32,
    /// Heading from the x axis towards the y axis, rad.
    pub heading_rad: f32,
    /// Covariance of (x, y, heading), row by row, in the squares of their units.
    pub covariance: [f32; 9],
}

/// The estimated odometry error: the controls are multiplied by 1 + scale, and the offset is added to the turn rate or steering
/// angle.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_odometry {
    /// `sizeof(scphd_odometry)`, set by the caller.
    pub struct_size: u32,
    /// Relative correction of the speed.
    pub speed_scale: f32,
    /// Relative correction of the turn rate or steering angle.
    pub turn_scale: f32,
    /// Offset of the turn rate, rad/s, or of the steering angle, rad.
    pub turn_offset: f32,
}

/// A pose under water and its covariance.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_water_pose {
    /// `sizeof(scphd_water_pose)`, set by the caller.
    pub struct_size: u32,
    /// x, m.
    pub x_m: f32,
    /// y, m.
    pub y_m: f32,
    /// z, m, positive upwards: minus the depth.
    pub z_m: f32,
    /// Yaw from the x axis towards the y axis, rad.
    pub yaw_rad: f32,
    /// Yaw rate, rad/s.
    pub yaw_rate_radps: f32,
    /// Roll, from the last control, rad.
    pub roll_rad: f32,
    /// Pitch, from the last control, rad.
    pub pitch_rad: f32,
    /// Covariance of (x, y, z, yaw, yaw rate), row by row, in the squares of their units.
    pub covariance: [f32; 25],
}

impl From<PoseEstimate<PlanarPose<f32>>> for scphd_plane_pose {
    fn from(PoseEstimate { mean, covariance }: PoseEstimate<PlanarPose<f32>>) -> Self {
        Self {
            struct_size: Self::STRUCT_SIZE,
            x_m: mean.x_m,
            y_m: mean.y_m,
            heading_rad: mean.heading_rad,
            covariance: from_fn(|at| covariance.get(at / 3, at % 3)),
        }
    }
}

impl From<PoseEstimate<AuvPose<f32>>> for scphd_water_pose {
    fn from(PoseEstimate { mean, covariance }: PoseEstimate<AuvPose<f32>>) -> Self {
        Self {
            struct_size: Self::STRUCT_SIZE,
            x_m: mean.x_m,
            y_m: mean.y_m,
            z_m: mean.z_m,
            yaw_rad: mean.yaw_rad,
            yaw_rate_radps: mean.yaw_rate_radps,
            roll_rad: mean.roll_rad,
            pitch_rad: mean.pitch_rad,
            covariance: from_fn(|at| covariance.get(at / 5, at % 5)),
        }
    }
}

impl From<OdometryCorrection<f32>> for scphd_odometry {
    fn from(OdometryCorrection { speed_scale, turn_scale, turn_offset }: OdometryCorrection<f32>) -> Self {
        Self { struct_size: Self::STRUCT_SIZE, speed_scale, turn_scale, turn_offset }
    }
}
