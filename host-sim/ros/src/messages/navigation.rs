//! `nav_msgs`.

use super::geometry::{PoseWithCovariance, TwistWithCovariance};
use super::standard::Header;
use crate::definition::messages;

messages! {
    "nav_msgs"
    /// Pose of a vehicle in the frame of the header, and velocity in the child frame.
    #[derive(Default)]
    Odometry { header: Header, child_frame_id: String, pose: PoseWithCovariance, twist: TwistWithCovariance, }
}
