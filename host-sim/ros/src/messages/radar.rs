//! `radar_msgs`.

use super::message;
use super::standard::{HEADER, Header};
use crate::definition::Definition;
use serde::{Deserialize, Serialize};

/// A radar detection of a target, in the sensor's frame.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct RadarReturn {
    /// Range, m.
    pub range: f32,
    /// Bearing, rad, positive to the left.
    pub azimuth: f32,
    /// Elevation, rad, positive upwards.
    pub elevation: f32,
    /// Speed along the ray, m/s.
    pub doppler_velocity: f32,
    /// Amplitude, dB.
    pub amplitude: f32,
}

pub static RADAR_RETURN: Definition = Definition {
    name: "radar_msgs/msg/RadarReturn",
    text: "float32 range\nfloat32 azimuth\nfloat32 elevation\nfloat32 doppler_velocity\nfloat32 amplitude\n",
    parts: &[],
};

/// The detections of a radar in a scan.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RadarScan {
    pub header: Header,
    /// One for each target.
    pub returns: Vec<RadarReturn>,
}

message!(
    RadarScan,
    RADAR_SCAN = "radar_msgs/msg/RadarScan",
    "std_msgs/Header header\nradar_msgs/RadarReturn[] returns\n",
    [HEADER, RADAR_RETURN]
);
