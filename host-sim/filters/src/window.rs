//! The view of a sensor.

use crate::settings::SensorSettings;
use scphd_log::angle::wrap;
use scphd_log::log::{Mounting, TruePose};
use std::f64::consts::PI;

/// The part of the plane in view of a range-bearing sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    range_m: [f64; 2],
    bearing_rad: [f64; 2],
    mounting: Mounting,
}

impl Window {
    /// The view of a filter's settings, without the soft edges.
    pub fn of_settings(sensor: &SensorSettings) -> Self {
        Self {
            range_m: [sensor.range_min_m, sensor.range_max_m],
            bearing_rad: [sensor.bearing_min_rad, sensor.bearing_max_rad],
            mounting: sensor.mounting(),
        }
    }

    /// Whether `point` (m) is in the view of the sensor of a vehicle at `pose`; `None` if this needs the heading and it is not
    /// known.
    pub fn holds(&self, pose: &TruePose, point: [f64; 2]) -> Option<bool> {
        let ([x, y], heading) = (pose.position, pose.heading_rad);
        let at_the_pose = self.mounting.forward_m == 0.0 && self.mounting.left_m == 0.0;
        if heading.is_none() && !at_the_pose {
            return None;
        }
        let [x, y, turned] = self.mounting.seat([x, y, heading.unwrap_or(0.0)]);
        let (dx, dy) = (point[0] - x, point[1] - y);
        let [near, far] = self.range_m;
        if !(near..=far).contains(&libm::hypot(dx, dy)) {
            return Some(false);
        }
        let [right, left] = self.bearing_rad;
        let half_width = 0.5 * (left - right);
        if half_width >= PI {
            return Some(true);
        }
        let off_centre = wrap(libm::atan2(dy, dx) - heading.map(|_| turned)? - 0.5 * (right + left));
        Some(off_centre.abs() <= half_width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(heading_rad: Option<f64>) -> TruePose {
        TruePose { t_s: 0.0, position: [0.0, 0.0], heading_rad }
    }

    fn window(range_m: [f64; 2], bearing_rad: [f64; 2]) -> Window {
        Window { range_m, bearing_rad, mounting: Mounting::NONE }
    }

    #[test]
    fn range_and_bearing() {
        let window = window([1.0, 10.0], [-0.5, 1.5]);
        let at = |point| window.holds(&pose(Some(PI)), point) == Some(true);
        assert!(at([-5.0, 0.0]));
        assert!(!at([-0.5, 0.0]), "too near");
        assert!(!at([-11.0, 0.0]), "too far");
        assert!(!at([5.0, 0.0]), "behind");
        assert!(at([-1.0, -5.0]), "left of a vehicle that drives west is south");
        assert!(!at([-1.0, 5.0]));
    }

    #[test]
    fn the_heading_is_needed_only_if_it_has_an_effect() {
        let narrow = window([0.0, 10.0], [-0.5, 0.5]);
        assert_eq!(narrow.holds(&pose(None), [5.0, 0.0]), None);
        assert_eq!(narrow.holds(&pose(None), [15.0, 0.0]), Some(false));
        assert_eq!(window([0.0, 10.0], [-PI, PI]).holds(&pose(None), [-5.0, 0.0]), Some(true));
    }
}
