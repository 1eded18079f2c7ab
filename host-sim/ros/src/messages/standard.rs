//! `std_msgs`.

use crate::definition::messages;
use crate::time::Time;

messages! {
    "std_msgs"
    /// Time, and the frame of the coordinates.
    #[derive(Default)]
    Header { stamp: Time, frame_id: String, }

    /// Red, green, blue and opacity, each from 0 to 1.
    #[derive(Copy, Default)]
    ColorRGBA { r: f32, g: f32, b: f32, a: f32, }
}

impl Header {
    pub fn new(stamp: Time, frame_id: &str) -> Self {
        Self { stamp, frame_id: frame_id.to_owned() }
    }
}
