//! `ackermann_msgs`.

use super::message;
use super::standard::{HEADER, Header};
use crate::definition::Definition;
use serde::{Deserialize, Serialize};

/// Motion of a car by its wheels.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct AckermannDrive {
    /// Angle of a virtual wheel between the front wheels, rad, positive to the left.
    pub steering_angle: f32,
    /// Its rate, rad/s.
    pub steering_angle_velocity: f32,
    /// Speed, m/s.
    pub speed: f32,
    /// Acceleration, m/s².
    pub acceleration: f32,
    /// Jerk, m/s³.
    pub jerk: f32,
}

pub static ACKERMANN_DRIVE: Definition = Definition {
    name: "ackermann_msgs/msg/AckermannDrive",
    text: "float32 steering_angle\nfloat32 steering_angle_velocity\nfloat32 speed\nfloat32 acceleration\nfloat32 jerk\n",
    parts: &[],
};

/// The same with a time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct AckermannDriveStamped {
    pub header: Header,
    pub drive: AckermannDrive,
}

message!(
    AckermannDriveStamped,
    ACKERMANN_DRIVE_STAMPED = "ackermann_msgs/msg/AckermannDriveStamped",
    "std_msgs/Header header\nackermann_msgs/AckermannDrive drive\n",
    [HEADER, ACKERMANN_DRIVE]
);
