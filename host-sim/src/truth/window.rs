//! What a sensor could see.

use crate::angle::wrap;
use crate::log::{Sensor, TruePose};
use crate::settings::SensorSettings;
use std::f64::consts::PI;

/// The part of the plane in view of a range-bearing sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    range_m: [f64; 2],
    bearing_rad: [f64; 2],
}

impl Window {
    /// As the head of a log has it.
    #[must_use]
    pub fn of_sensor(sensor: &Sensor) -> Self {
        Self {
            range_m: [sensor.range_min_m, sensor.range_max_m],
            bearing_rad: [sensor.bearing_min_rad, sensor.bearing_max_rad],
        }
    }

    /// As a filter takes it, without the soft edges.
    #[must_use]
    pub fn of_settings(sensor: &SensorSettings) -> Self {
        Self {
            range_m: [sensor.range_min_m, sensor.range_max_m],
            bearing_rad: [sensor.bearing_min_rad, sensor.bearing_max_rad],
        }
    }

    /// Whether the window of a sensor at `pose` holds `point` (m); `None` where that would take a heading that is
    /// not known.
    #[must_use]
    pub fn holds(&self, pose: &TruePose, point: [f64; 2]) -> Option<bool> {
        let (dx, dy) = (point[0] - pose.position[0], point[1] - pose.position[1]);
        let [near, far] = self.range_m;
        if !(near..=far).contains(&libm::hypot(dx, dy)) {
            return Some(false);
        }
        let [right, left] = self.bearing_rad;
        let half_width = 0.5 * (left - right);
        if half_width >= PI {
            return Some(true);
        }
        let off_centre = wrap(libm::atan2(dy, dx) - pose.heading_rad? - 0.5 * (right + left));
        Some(off_centre.abs() <= half_width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(heading_rad: Option<f64>) -> TruePose {
        TruePose { t_s: 0.0, position: [0.0, 0.0], heading_rad }
    }

    #[test]
    fn range_and_bearing() {
        let sensor = Sensor { range_min_m: 1.0, range_max_m: 10.0, bearing_min_rad: -0.5, bearing_max_rad: 1.5 };
        let window = Window::of_sensor(&sensor);
        let at = |point| window.holds(&pose(Some(PI)), point) == Some(true);
        assert!(at([-5.0, 0.0]));
        assert!(!at([-0.5, 0.0]), "too near");
        assert!(!at([-11.0, 0.0]), "too far");
        assert!(!at([5.0, 0.0]), "behind");
        assert!(at([-1.0, -5.0]), "left of a vehicle that drives west is south");
        assert!(!at([-1.0, 5.0]));
    }

    #[test]
    fn a_heading_is_needed_only_where_it_matters() {
        let mut sensor = Sensor { range_min_m: 0.0, range_max_m: 10.0, bearing_min_rad: -0.5, bearing_max_rad: 0.5 };
        assert_eq!(Window::of_sensor(&sensor).holds(&pose(None), [5.0, 0.0]), None);
        assert_eq!(Window::of_sensor(&sensor).holds(&pose(None), [15.0, 0.0]), Some(false));
        (sensor.bearing_min_rad, sensor.bearing_max_rad) = (-PI, PI);
        assert_eq!(Window::of_sensor(&sensor).holds(&pose(None), [-5.0, 0.0]), Some(true));
    }
}
