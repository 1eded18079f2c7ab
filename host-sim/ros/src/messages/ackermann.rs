//! `ackermann_msgs`.

use super::message;
use super::standard::{HEADER, Header};
use crate::definition::Definition;
use serde::{Deserialize, Serialize};

/// What the wheels of a car do.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct AckermannDrive {
    /// Of a wheel between the front wheels, rad, growing to the left.
    pub steering_angle: f32,
    /// Its rate, rad/s.
    pub steering_angle_velocity: f32,
    /// m/s.
    pub speed: f32,
    /// m/s².
    pub acceleration: f32,
    /// m/s³.
    pub jerk: f32,
}

/// `ackermann_msgs/msg/AckermannDrive`.
pub static ACKERMANN_DRIVE: Definition = Definition {
    name: "ackermann_msgs/msg/AckermannDrive",
    text: "float32 steering_angle\nfloat32 steering_angle_velocity\nfloat32 speed\nfloat32 acceleration\nfloat32 jerk\n",
    parts: &[],
};

/// The same at a time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct AckermannDriveStamped {
    /// When.
    pub header: Header,
    /// What the wheels do.
    pub drive: AckermannDrive,
}

message!(
    /// `ackermann_msgs/msg/AckermannDriveStamped`.
    AckermannDriveStamped, ACKERMANN_DRIVE_STAMPED = "ackermann_msgs/msg/AckermannDriveStamped",
    "std_msgs/Header header\nackermann_msgs/AckermannDrive drive\n", [HEADER, ACKERMANN_DRIVE]
);
