//! `vision_msgs`, of version 4 (ROS 2 Humble and later).

use super::geometry::{Pose, PoseWithCovariance, Vector3};
use super::standard::Header;
use crate::definition::messages;

messages! {
    "vision_msgs"
    /// A class of an object with its probability.
    #[derive(Default)]
    ObjectHypothesis { class_id: String, score: f64, }

    /// A class of an object with the object's pose.
    #[derive(Default)]
    ObjectHypothesisWithPose { hypothesis: ObjectHypothesis, pose: PoseWithCovariance, }

    /// A bounding box by its centre and its edges, m.
    #[derive(Copy, Default)]
    BoundingBox3D { center: Pose, size: Vector3, }

    /// A detected object.
    #[derive(Default)]
    Detection3D {
        header: Header,
        /// Its possible classes.
        results: Vec<ObjectHypothesisWithPose>,
        bbox: BoundingBox3D,
        /// Its name, the same from image to image.
        id: String,
    }

    /// The detected objects at a time.
    #[derive(Default)]
    Detection3DArray { header: Header, detections: Vec<Detection3D>, }
}
