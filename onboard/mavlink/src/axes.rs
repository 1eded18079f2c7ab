//! Transformation between our axes and MAVLink's. Ours are x ahead or east, y left or north, z up; MAVLink's z is down.

use core::f32::consts::{FRAC_PI_2, PI, TAU};

/// Number of elements of a covariance of six states: the upper right triangle, row by row.
pub(crate) const TRIANGLE: usize = 21;

/// Directions of the axes of the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MapFrame {
    /// x and y are the directions at the start of the drive, or those of the map: MAVLink's `LOCAL_FRD`. ArduPilot accepts only
    /// this one.
    #[default]
    Local,
    /// x is east and y is north: MAVLink's `LOCAL_NED`.
    EastNorth,
}

impl MapFrame {
    pub(crate) const fn number(self) -> u8 {
        match self {
            Self::Local => 20,
            Self::EastNorth => 1,
        }
    }

    pub(crate) const fn of(number: u8) -> Option<Self> {
        match number {
            20 => Some(Self::Local),
            1 => Some(Self::EastNorth),
            _ => None,
        }
    }

    /// For each of MAVLink's states, the index of ours and the sign. The states are x, y, z, roll, pitch and heading.
    const fn turned(self) -> [(usize, f32); 6] {
        let [ahead, aside] = match self {
            Self::Local => [(0, 1.0), (1, -1.0)],
            Self::EastNorth => [(1, 1.0), (0, 1.0)],
        };
        [ahead, aside, (2, -1.0), (3, 1.0), (4, -1.0), (5, -1.0)]
    }

    /// Transforms a position; the transformation is its own inverse.
    pub(crate) fn place(self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Local => [x, -y, -z],
            Self::EastNorth => [y, x, -z],
        }
    }

    /// Transforms roll, pitch and heading; the transformation is its own inverse.
    pub(crate) fn attitude(self, [roll, pitch, heading]: [f32; 3]) -> [f32; 3] {
        let ahead = match self {
            Self::Local => 0.0,
            Self::EastNorth => FRAC_PI_2,
        };
        [roll, -pitch, wrap(ahead - heading)]
    }

    /// The triangle of a covariance in our axes.
    pub(crate) fn triangle(self, covariance: &[[f32; 6]; 6]) -> [f32; TRIANGLE] {
        let turned = self.turned();
        let mut triangle = [0.0; TRIANGLE];
        let pairs = (0..6).flat_map(|row| (row..6).map(move |column| (row, column)));
        for (slot, (row, column)) in triangle.iter_mut().zip(pairs) {
            let [(row, sign), (column, other)] = [row, column].map(|state| of(&turned, state));
            *slot = sign * other * at(covariance, row, column);
        }
        triangle
    }

    /// The covariance in our axes of a triangle in theirs; `None` if they do not know it.
    pub(crate) fn covariance(self, triangle: &[f32; TRIANGLE]) -> Option<[[f32; 6]; 6]> {
        if triangle.first().is_none_or(|first| first.is_nan()) {
            return None;
        }
        let turned = self.turned();
        let mut covariance = [[0.0; 6]; 6];
        let pairs = (0..6).flat_map(|row| (row..6).map(move |column| (row, column)));
        for (number, (row, column)) in triangle.iter().zip(pairs) {
            let [(row, sign), (column, other)] = [row, column].map(|state| of(&turned, state));
            for (row, column) in [(row, column), (column, row)] {
                if let Some(slot) = covariance.get_mut(row).and_then(|row| row.get_mut(column)) {
                    *slot = sign * other * number;
                }
            }
        }
        Some(covariance)
    }
}

fn of(turned: &[(usize, f32); 6], state: usize) -> (usize, f32) {
    turned.get(state).copied().unwrap_or((0, 0.0))
}

fn at(covariance: &[[f32; 6]; 6], row: usize, column: usize) -> f32 {
    covariance.get(row).and_then(|row| row.get(column)).copied().unwrap_or(0.0)
}

/// The same angle in [−π, π).
pub(crate) fn wrap(angle_rad: f32) -> f32 {
    angle_rad - libm::floorf((angle_rad + PI) / TAU) * TAU
}

/// The quaternion w, x, y, z of roll, pitch and heading; the rotations are heading, pitch, roll.
pub(crate) fn quaternion(attitude: [f32; 3]) -> [f32; 4] {
    let [(sr, cr), (sp, cp), (sh, ch)] = attitude.map(|angle| libm::sincosf(0.5 * angle));
    [cr * cp * ch + sr * sp * sh, sr * cp * ch - cr * sp * sh, cr * sp * ch + sr * cp * sh, cr * cp * sh - sr * sp * ch]
}

/// Roll, pitch and heading of a quaternion with any length except 0.
pub(crate) fn attitude([w, x, y, z]: [f32; 4]) -> [f32; 3] {
    let square = w * w + x * x + y * y + z * z;
    let roll = libm::atan2f(2.0 * (w * x + y * z), w * w - x * x - y * y + z * z);
    let pitch = libm::asinf((2.0 * (w * y - z * x) / square).clamp(-1.0, 1.0));
    let heading = libm::atan2f(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z);
    [roll, pitch, heading]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transformation_and_its_inverse_give_the_same_values() {
        let mut covariance = [[0.0_f32; 6]; 6];
        for (row, numbers) in covariance.iter_mut().enumerate() {
            for (column, number) in numbers.iter_mut().enumerate() {
                *number = (1 + row.min(column) + 10 * row.max(column)) as f32;
            }
        }
        for frame in [MapFrame::Local, MapFrame::EastNorth] {
            assert_eq!(MapFrame::of(frame.number()), Some(frame));
            assert_eq!(frame.place(frame.place([1.0, 2.0, 3.0])), [1.0, 2.0, 3.0]);
            let back = frame.attitude(frame.attitude([0.1, 0.2, -3.0]));
            assert!(back.iter().zip([0.1, 0.2, -3.0]).all(|(one, other)| (one - other).abs() < 1e-6));
            assert_eq!(frame.covariance(&frame.triangle(&covariance)), Some(covariance));
        }
        // Local: ahead and right, twice right, right and down, roll and heading; then north and east.
        let local = MapFrame::Local.triangle(&covariance);
        assert_eq!([local[0], local[1], local[6], local[8], local[20]], [1.0, -11.0, 12.0, -32.0, 56.0]);
        let earth = MapFrame::EastNorth.triangle(&covariance);
        assert_eq!([earth[0], earth[1], earth[2], earth[5], earth[6]], [12.0, 11.0, -22.0, -52.0, 1.0]);
        assert_eq!(MapFrame::Local.covariance(&[f32::NAN; TRIANGLE]), None);
    }

    #[test]
    fn a_vehicle_heading_east_has_a_compass_heading_of_ninety_degrees() {
        assert_eq!(MapFrame::EastNorth.place([3.0, 4.0, 1.0]), [4.0, 3.0, -1.0]);
        assert!((MapFrame::EastNorth.attitude([0.0, 0.0, 0.0])[2] - FRAC_PI_2).abs() < 1e-6);
        assert!(MapFrame::EastNorth.attitude([0.0, 0.0, FRAC_PI_2])[2].abs() < 1e-6);
    }

    #[test]
    fn quaternions_agree_with_angles() {
        for angles in [[0.0, 0.0, 0.0], [0.3, -0.5, 2.0], [-1.0, 1.2, -3.0], [3.0, 0.1, 0.5]] {
            let back = attitude(quaternion(angles).map(|number| 1.7 * number));
            assert!(back.iter().zip(angles).all(|(one, other)| wrap(one - other).abs() < 1e-5), "{angles:?} {back:?}");
        }
    }
}
