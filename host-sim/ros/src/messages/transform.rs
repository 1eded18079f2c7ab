//! `tf2_msgs`.

use super::geometry::{TRANSFORM_STAMPED, TransformStamped};
use super::message;
use serde::{Deserialize, Serialize};

/// Transforms between frames.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TFMessage {
    pub transforms: Vec<TransformStamped>,
}

message!(
    TFMessage,
    TF_MESSAGE = "tf2_msgs/msg/TFMessage",
    "geometry_msgs/TransformStamped[] transforms\n",
    [TRANSFORM_STAMPED]
);
