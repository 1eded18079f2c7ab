//! LANDING_TARGET: an object detected by a camera, as range and bearing.

use crate::bytes::Reader;

/// `MAV_FRAME_BODY_FRD`.
const BODY: u8 = 12;

/// A target relative to the vehicle; relative to the sensor if the message has no position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Time of the detection by the sender's clock, µs.
    pub time_us: u64,
    /// Its number, if the sender distinguishes several targets.
    pub number: u8,
    /// Direction in the horizontal plane, rad to the left.
    pub bearing_rad: f32,
    /// Direction above the horizontal plane, rad.
    pub elevation_rad: f32,
    /// Distance, m; `None` if it is unknown.
    pub distance_m: Option<f32>,
}

impl Target {
    /// Range in the horizontal plane (m) and bearing (rad), a measurement for a filter; `None` if the distance is unknown.
    pub fn in_plane(&self) -> Option<[f32; 2]> {
        self.distance_m.map(|distance_m| [distance_m * libm::cosf(self.elevation_rad), self.bearing_rad])
    }

    /// Reads the position in the vehicle's axes if the message has one, otherwise the angles from the centre of an image that
    /// looks ahead.
    pub(crate) fn read(mut payload: Reader<'_>) -> Option<Self> {
        let time_us = payload.u64();
        let [right_rad, down_rad, distance_m] = payload.floats();
        payload.skip(8);
        let (number, frame) = (payload.u8(), payload.u8());
        let place = payload.floats::<3>();
        payload.skip(16 + 1);
        let has_place = payload.u8() != 0 && frame == BODY && place.iter().all(|number| number.is_finite());
        let ([ahead, right, down], distance_m) = if has_place {
            let [x, y, z] = place;
            (place, libm::sqrtf(x * x + y * y + z * z))
        } else {
            ([1.0, libm::tanf(right_rad), libm::tanf(down_rad)], distance_m)
        };
        let bearing_rad = libm::atan2f(-right, ahead);
        let elevation_rad = libm::atan2f(-down, libm::hypotf(ahead, right));
        let distance_m = Some(distance_m).filter(|distance_m| *distance_m > 0.0 && distance_m.is_finite());
        (bearing_rad.is_finite() && elevation_rad.is_finite()).then_some(Self {
            time_us,
            number,
            bearing_rad,
            elevation_rad,
            distance_m,
        })
    }
}
