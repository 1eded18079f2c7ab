//! `std_msgs` and `builtin_interfaces`.

use crate::definition::Definition;
use crate::time::Time;
use serde::{Deserialize, Serialize};

pub static TIME: Definition =
    Definition { name: "builtin_interfaces/msg/Time", text: "int32 sec\nuint32 nanosec\n", parts: &[] };

pub static DURATION: Definition =
    Definition { name: "builtin_interfaces/msg/Duration", text: "int32 sec\nuint32 nanosec\n", parts: &[] };

/// Time and frame.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Header {
    pub stamp: Time,
    /// The frame of the coordinates.
    pub frame_id: String,
}

impl Header {
    #[must_use]
    pub fn new(stamp: Time, frame_id: &str) -> Self {
        Self { stamp, frame_id: frame_id.to_owned() }
    }
}

pub static HEADER: Definition = Definition {
    name: "std_msgs/msg/Header",
    text: "builtin_interfaces/Time stamp\nstring frame_id\n",
    parts: &[&TIME],
};

/// Red, green, blue and opacity, each from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are said above")]
pub struct ColorRGBA {
    pub r: f32,
    pub g: f32,
    pub b: f32,
    pub a: f32,
}

pub static COLOR: Definition =
    Definition { name: "std_msgs/msg/ColorRGBA", text: "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n", parts: &[] };
