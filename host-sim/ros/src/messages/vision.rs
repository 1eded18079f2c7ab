//! `vision_msgs`, of version 4 (ROS 2 Humble and later).

use super::geometry::{POSE, POSE_WITH_COVARIANCE, Pose, PoseWithCovariance, VECTOR3, Vector3};
use super::message;
use super::standard::{HEADER, Header};
use crate::definition::Definition;
use serde::{Deserialize, Serialize};

/// A class of an object with its probability.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ObjectHypothesis {
    pub class_id: String,
    pub score: f64,
}

pub static OBJECT_HYPOTHESIS: Definition =
    Definition { name: "vision_msgs/msg/ObjectHypothesis", text: "string class_id\nfloat64 score\n", parts: &[] };

/// A class of an object with the object's pose.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ObjectHypothesisWithPose {
    pub hypothesis: ObjectHypothesis,
    pub pose: PoseWithCovariance,
}

pub static OBJECT_HYPOTHESIS_WITH_POSE: Definition = Definition {
    name: "vision_msgs/msg/ObjectHypothesisWithPose",
    text: "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose\n",
    parts: &[&OBJECT_HYPOTHESIS, &POSE_WITH_COVARIANCE],
};

/// A bounding box.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct BoundingBox3D {
    /// Its centre.
    pub center: Pose,
    /// Its edges, m.
    pub size: Vector3,
}

pub static BOUNDING_BOX_3D: Definition = Definition {
    name: "vision_msgs/msg/BoundingBox3D",
    text: "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size\n",
    parts: &[&POSE, &VECTOR3],
};

/// A detected object.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Detection3D {
    pub header: Header,
    /// Its possible classes.
    pub results: Vec<ObjectHypothesisWithPose>,
    pub bbox: BoundingBox3D,
    /// Its name, the same from image to image.
    pub id: String,
}

pub static DETECTION_3D: Definition = Definition {
    name: "vision_msgs/msg/Detection3D",
    text: "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\nvision_msgs/BoundingBox3D bbox\nstring id\n",
    parts: &[&HEADER, &OBJECT_HYPOTHESIS_WITH_POSE, &BOUNDING_BOX_3D],
};

/// The detected objects at a time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Detection3DArray {
    pub header: Header,
    pub detections: Vec<Detection3D>,
}

message!(
    Detection3DArray,
    DETECTION_3D_ARRAY = "vision_msgs/msg/Detection3DArray",
    "std_msgs/Header header\nvision_msgs/Detection3D[] detections\n",
    [HEADER, DETECTION_3D]
);
