//! Estimated poses.

use crate::pointer::Versioned;
use core::array::from_fn;
use scphd::PoseEstimate;
use scphd::models::{AuvPose, OdometryCorrection, PlanarPose};

/// A pose in the plane and how well it is known.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_plane_pose {
    /// `sizeof(scphd_plane_pose)`, set by the caller.
    pub struct_size: u32,
    /// x, m.
    pub x_m: f32,
    /// y, m.
    pub y_m: f32,
    /// From the x axis towards the y axis, rad.
    pub heading_rad: f32,
    /// Covariance of (x, y, heading), row after row, in the squares of their units.
    pub covariance: [f32; 9],
}

/// What the odometry is off by.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_odometry {
    /// `sizeof(scphd_odometry)`, set by the caller.
    pub struct_size: u32,
    /// The speed, as a share of it.
    pub speed_scale: f32,
    /// The turn rate or the steering angle, as a share of it.
    pub turn_scale: f32,
    /// The turn rate, rad/s, or the steering angle, rad, where the vehicle goes straight ahead.
    pub turn_offset: f32,
}

/// A pose under water and how well it is known.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_water_pose {
    /// `sizeof(scphd_water_pose)`, set by the caller.
    pub struct_size: u32,
    /// x, m.
    pub x_m: f32,
    /// y, m.
    pub y_m: f32,
    /// z, m, upwards: minus the depth.
    pub z_m: f32,
    /// From the x axis towards the y axis, rad.
    pub yaw_rad: f32,
    /// rad/s.
    pub yaw_rate_radps: f32,
    /// As the last control has it, rad.
    pub roll_rad: f32,
    /// As the last control has it, rad.
    pub pitch_rad: f32,
    /// Covariance of (x, y, z, yaw, yaw rate), row after row, in the squares of their units.
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
