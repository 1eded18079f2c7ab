//! GPS_RAW_INT: a position, and its transformation to a map.

use crate::bytes::Reader;

/// The ellipsoid WGS 84: equatorial radius, m, and squared eccentricity.
const RADIUS_M: f64 = 6_378_137.0;
const ECCENTRICITY_SQUARE: f64 = 0.006_694_379_990_141_316;
/// Units of a message per degree.
const UNITS: f64 = 1e7;

/// A position of a satellite receiver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Satellite {
    /// Time of the position by the sender's clock, µs.
    pub time_us: u64,
    /// North of the equator, degrees × 10⁷.
    pub latitude_e7: i32,
    /// East of Greenwich, degrees × 10⁷.
    pub longitude_e7: i32,
    /// Horizontal standard deviation, m; `None` if the receiver does not report it.
    pub sigma_m: Option<f32>,
}

impl Satellite {
    /// `None` if the receiver has no position.
    pub(crate) fn read(mut payload: Reader<'_>) -> Option<Self> {
        let time_us = payload.u64();
        let [latitude_e7, longitude_e7, _height_mm] = [payload.i32(), payload.i32(), payload.i32()];
        payload.skip(8);
        let (fix, _satellites) = (payload.u8(), payload.u8());
        payload.skip(4);
        let sigma_mm = payload.u32();
        let sigma_m = (sigma_mm > 0 && sigma_mm < u32::MAX).then_some(sigma_mm as f32 * 1e-3);
        // 2 or more: a horizontal position.
        (fix >= 2).then_some(Self { time_us, latitude_e7, longitude_e7, sigma_m })
    }
}

/// The position of a map on the earth: its origin, with x to the east and y to the north.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Origin {
    latitude_e7: i32,
    longitude_e7: i32,
    /// Metres per unit to the east and to the north.
    metres: [f64; 2],
}

impl Origin {
    /// A map with this origin, degrees × 10⁷. Errors are a few metres within 10 km, and centimetres within 1 km.
    pub fn new(latitude_e7: i32, longitude_e7: i32) -> Self {
        let (sine, cosine) = libm::sincos((f64::from(latitude_e7) / UNITS).to_radians());
        let flat = 1.0 - ECCENTRICITY_SQUARE * sine * sine;
        let across = RADIUS_M / libm::sqrt(flat);
        let along = across * (1.0 - ECCENTRICITY_SQUARE) / flat;
        let metres = [across * cosine, along].map(|radius| (radius / UNITS).to_radians());
        Self { latitude_e7, longitude_e7, metres }
    }

    /// x and y of a position, m.
    #[must_use]
    pub fn place(&self, satellite: &Satellite) -> [f32; 2] {
        // The shorter direction around the earth.
        let turn = (360.0 * UNITS) as i64;
        let mut east = i64::from(satellite.longitude_e7) - i64::from(self.longitude_e7);
        east -= turn * i64::from(2 * east > turn) - turn * i64::from(2 * east < -turn);
        let north = i64::from(satellite.latitude_e7) - i64::from(self.latitude_e7);
        let [x, y] = self.metres;
        [(east as f64 * x) as f32, (north as f64 * y) as f32]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(latitude_e7: i32, longitude_e7: i32) -> Satellite {
        Satellite { time_us: 0, latitude_e7, longitude_e7, sigma_m: None }
    }

    /// A minute of arc of the ellipsoid at 45°, from tables: 1 852.2 m along the meridian, 1 314.2 m along the parallel.
    #[test]
    fn minutes_of_arc_have_the_tabulated_lengths() {
        let origin = Origin::new(450_000_000, 100_000_000);
        let [x, y] = origin.place(&at(450_166_667, 100_166_667));
        assert!((x - 1314.2).abs() < 0.2 && (y - 1852.2).abs() < 0.2, "{x} {y}");
        let [x, _] = Origin::new(0, 1_799_999_000).place(&at(0, -1_799_999_000));
        assert!((x - 2000.0 * 0.011_131_9).abs() < 0.01, "{x}");
    }
}
