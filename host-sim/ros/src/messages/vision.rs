//! `vision_msgs`, of version 4 (ROS 2 Humble and later).

use super::geometry::{POSE, POSE_WITH_COVARIANCE, Pose, PoseWithCovariance, VECTOR3, Vector3};
use super::message;
use super::standard::{HEADER, Header};
use crate::definition::Definition;
use serde::{Deserialize, Serialize};

/// What something may be.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ObjectHypothesis {
    /// Its kind.
    pub class_id: String,
    /// How likely that is.
    pub score: f64,
}

/// `vision_msgs/msg/ObjectHypothesis`.
pub static OBJECT_HYPOTHESIS: Definition =
    Definition { name: "vision_msgs/msg/ObjectHypothesis", text: "string class_id\nfloat64 score\n", parts: &[] };

/// What something may be, and where it then is.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ObjectHypothesisWithPose {
    /// What.
    pub hypothesis: ObjectHypothesis,
    /// Where.
    pub pose: PoseWithCovariance,
}

/// `vision_msgs/msg/ObjectHypothesisWithPose`.
pub static OBJECT_HYPOTHESIS_WITH_POSE: Definition = Definition {
    name: "vision_msgs/msg/ObjectHypothesisWithPose",
    text: "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose\n",
    parts: &[&OBJECT_HYPOTHESIS, &POSE_WITH_COVARIANCE],
};

/// A box around something.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct BoundingBox3D {
    /// Its middle.
    pub center: Pose,
    /// Its edges, m.
    pub size: Vector3,
}

/// `vision_msgs/msg/BoundingBox3D`.
pub static BOUNDING_BOX_3D: Definition = Definition {
    name: "vision_msgs/msg/BoundingBox3D",
    text: "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size\n",
    parts: &[&POSE, &VECTOR3],
};

/// One thing that was seen.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Detection3D {
    /// When, in which frame.
    pub header: Header,
    /// What it may be.
    pub results: Vec<ObjectHypothesisWithPose>,
    /// Where it is.
    pub bbox: BoundingBox3D,
    /// Its name from image to image.
    pub id: String,
}

/// `vision_msgs/msg/Detection3D`.
pub static DETECTION_3D: Definition = Definition {
    name: "vision_msgs/msg/Detection3D",
    text: "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\nvision_msgs/BoundingBox3D bbox\nstring id\n",
    parts: &[&HEADER, &OBJECT_HYPOTHESIS_WITH_POSE, &BOUNDING_BOX_3D],
};

/// All that was seen at a time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Detection3DArray {
    /// When, in which frame.
    pub header: Header,
    /// One a thing.
    pub detections: Vec<Detection3D>,
}

message!(
    /// `vision_msgs/msg/Detection3DArray`.
    Detection3DArray, DETECTION_3D_ARRAY = "vision_msgs/msg/Detection3DArray",
    "std_msgs/Header header\nvision_msgs/Detection3D[] detections\n", [HEADER, DETECTION_3D]
);
