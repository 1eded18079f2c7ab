//! `radar_msgs`.

use super::standard::Header;
use crate::definition::messages;

messages! {
    "radar_msgs"
    /// A radar detection of a target, in the sensor's frame: m, rad and m/s.
    #[derive(Copy, Default)]
    RadarReturn {
        range: f32,
        /// Positive to the left.
        azimuth: f32,
        /// Positive upwards.
        elevation: f32,
        doppler_velocity: f32,
        /// dB.
        amplitude: f32,
    }

    /// The detections of a radar in a scan.
    #[derive(Default)]
    RadarScan { header: Header, returns: Vec<RadarReturn>, }
}
