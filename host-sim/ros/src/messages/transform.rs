//! `tf2_msgs`.

use super::geometry::TransformStamped;
use crate::definition::messages;

messages! {
    "tf2_msgs"
    /// Transforms between frames.
    #[derive(Default)]
    TFMessage { transforms: Vec<TransformStamped>, }
}
