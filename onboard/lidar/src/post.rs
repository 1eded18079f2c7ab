//! A detected post.

/// Position of a post, seen from the lidar at the time of the beam.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Post {
    /// Range of its axis, m.
    pub range_m: f32,
    /// Bearing of its axis, rad to the left of the lidar's axis (the arrow on an LD06), from −π to π.
    pub bearing_rad: f32,
    /// Time from the measurement to the end of the scan, s.
    pub before_end_s: f32,
    /// Number of beams on it.
    pub points: u16,
    /// Greatest intensity.
    pub intensity: f32,
}

impl Post {
    /// Range (m) and bearing (rad) at the end of the scan, for a vehicle that has moved since the measurement with this speed
    /// (m/s, of the lidar, along its axis) and turn rate (rad/s): all posts of a scan then have the same time.
    #[must_use]
    pub fn at_end(&self, speed_mps: f32, rate_radps: f32) -> [f32; 2] {
        let turned = rate_radps * self.before_end_s;
        // The arc length is used as the length of the chord; the relative error is turned²/24.
        let way = speed_mps * self.before_end_s;
        let x = self.range_m * libm::cosf(self.bearing_rad) - way * libm::cosf(0.5 * turned);
        let y = self.range_m * libm::sinf(self.bearing_rad) - way * libm::sinf(0.5 * turned);
        [libm::hypotf(x, y), wrap(libm::atan2f(y, x) - turned)]
    }
}

/// The same angle in [−π, π).
pub(crate) fn wrap(angle_rad: f32) -> f32 {
    use core::f32::consts::{PI, TAU};
    let turns = libm::floorf((angle_rad + PI) / TAU);
    angle_rad - turns * TAU
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::{FRAC_PI_2, PI};

    #[test]
    fn motion_since_the_measurement_is_compensated() {
        let post = Post { range_m: 5.0, bearing_rad: 0.0, before_end_s: 0.1, ..Post::default() };
        let close = |[range, bearing]: [f32; 2], expected: [f32; 2]| {
            assert!((range - expected[0]).abs() < 1e-4 && (bearing - expected[1]).abs() < 1e-4, "{range} {bearing}");
        };
        close(post.at_end(0.0, 0.0), [5.0, 0.0]);
        close(post.at_end(2.0, 0.0), [4.8, 0.0]);
        close(post.at_end(0.0, 1.0), [5.0, -0.1]);
        // A quarter of a circle of radius 1 m to the left ends at (1, 1), turned by 90°; its chord is √2, not π/2.
        let far = Post { before_end_s: 1.0, ..post };
        let [range, bearing] = far.at_end(FRAC_PI_2, FRAC_PI_2);
        assert!((range - 4.123).abs() < 0.2 && (bearing + FRAC_PI_2 + 0.245).abs() < 0.05, "{range} {bearing}");
    }

    #[test]
    fn angles_are_wrapped() {
        for (angle, wrapped) in [(0.0, 0.0), (3.0 * PI + 0.1, -PI + 0.1), (-PI - 0.1, PI - 0.1), (1.0, 1.0)] {
            assert!((wrap(angle) - wrapped).abs() < 1e-5, "{angle}");
        }
    }
}
