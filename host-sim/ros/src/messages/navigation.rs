//! `nav_msgs`.

use super::geometry::{POSE_WITH_COVARIANCE, PoseWithCovariance, TWIST_WITH_COVARIANCE, TwistWithCovariance};
use super::message;
use super::standard::{HEADER, Header};
use serde::{Deserialize, Serialize};

/// Pose and velocity of a vehicle.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Odometry {
    /// Time, and the frame of the pose.
    pub header: Header,
    /// The frame of the velocities.
    pub child_frame_id: String,
    pub pose: PoseWithCovariance,
    pub twist: TwistWithCovariance,
}

message!(
    Odometry,
    ODOMETRY = "nav_msgs/msg/Odometry",
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist\n",
    [HEADER, POSE_WITH_COVARIANCE, TWIST_WITH_COVARIANCE]
);
