//! The field of view: the probability of detecting a feature at a position.

use super::angle::wrap;
use super::gaussian::Vector;
use super::sensor::range_bearing;
use std::f64::consts::PI;

/// A window of ranges and bearings with soft edges (5.15, softened).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldOfView {
    /// Least range, m; 0: no near edge.
    pub range_min_m: f64,
    /// Greatest range, m.
    pub range_max_m: f64,
    /// Half width of the edges in range, m; 0: hard edges.
    pub range_edge_m: f64,
    /// Centre of the bearing window, rad.
    pub bearing_center_rad: f64,
    /// Half width of the bearing window, rad; π or more is a full circle.
    pub bearing_half_width_rad: f64,
    /// Half width of the edges in bearing, rad; 0: hard edges.
    pub bearing_edge_rad: f64,
    /// Probability of detection at range 0.
    pub p_near: f64,
    /// Probability of detection at the greatest range and beyond.
    pub p_far: f64,
}

impl FieldOfView {
    /// p_D(m | x) for a feature at a position (m) seen from a pose (m, m, rad). A feature at the sensor itself cannot be
    /// observed.
    pub fn detection_probability(&self, position: Vector, pose: [f64; 3]) -> f64 {
        let [range, bearing] = range_bearing(position, pose);
        if range.is_nan() || range <= 0.0 {
            return 0.0;
        }
        let mut probability = self.nominal(range) * soft(self.range_max_m - range, self.range_edge_m);
        if self.range_min_m > 0.0 {
            probability *= soft(range - self.range_min_m, self.range_edge_m);
        }
        if self.bearing_half_width_rad < PI {
            let off_center = wrap(bearing - self.bearing_center_rad).abs();
            probability *= soft(self.bearing_half_width_rad - off_center, self.bearing_edge_rad);
        }
        probability
    }

    /// κ in 1/(m·rad) of `clutter_per_scan` false measurements, uniform over the window.
    pub fn clutter_intensity(&self, clutter_per_scan: f64) -> f64 {
        let bearings = 2.0 * self.bearing_half_width_rad.min(PI);
        clutter_per_scan / ((self.range_max_m - self.range_min_m) * bearings)
    }

    /// p(r): linear from `p_near` at range 0 to `p_far` at the greatest range.
    fn nominal(&self, range: f64) -> f64 {
        self.p_near + (self.p_far - self.p_near) * (range / self.range_max_m).min(1.0)
    }
}

/// s: 0 outside, 1 inside, a cubic step over twice the edge between them; `distance` is positive inside.
fn soft(distance: f64, edge: f64) -> f64 {
    if edge == 0.0 {
        return if distance >= 0.0 { 1.0 } else { 0.0 };
    }
    let t = ((1.0 + distance / edge) / 2.0).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: FieldOfView = FieldOfView {
        range_min_m: 1.0,
        range_max_m: 10.0,
        range_edge_m: 0.5,
        bearing_center_rad: 0.2,
        bearing_half_width_rad: 1.0,
        bearing_edge_rad: 0.1,
        p_near: 0.9,
        p_far: 0.5,
    };

    fn seen(view: &FieldOfView, range: f64, bearing: f64) -> f64 {
        let pose = [2.0, -3.0, 2.5];
        let (sin, cos) = f64::sin_cos(pose[2] + bearing);
        view.detection_probability([pose[0] + range * cos, pose[1] + range * sin], pose)
    }

    #[test]
    fn p_d_decreases_linearly_inside() {
        assert!((seen(&VIEW, 5.0, 0.2) - 0.7).abs() < 1e-12);
        assert!((seen(&VIEW, 2.5, -0.5) - 0.8).abs() < 1e-12);
    }

    #[test]
    fn edges_are_one_half_at_the_limit_and_zero_outside() {
        assert!((seen(&VIEW, 10.0, 0.2) - 0.25).abs() < 1e-12);
        assert!((seen(&VIEW, 1.0, 0.2) - 0.86 / 2.0).abs() < 1e-12);
        assert!((seen(&VIEW, 5.0, 1.2) - 0.35).abs() < 1e-12);
        assert!((seen(&VIEW, 5.0, -0.8) - 0.35).abs() < 1e-12);
        assert_eq!(seen(&VIEW, 10.51, 0.2), 0.0);
        assert_eq!(seen(&VIEW, 0.49, 0.2), 0.0);
        assert_eq!(seen(&VIEW, 5.0, 1.31), 0.0);
        // Beyond the greatest range the nominal probability is constant; at a quarter of the edge, s = 5/32.
        assert!((seen(&VIEW, 10.25, 0.2) - 0.5 * 5.0 / 32.0).abs() < 1e-12);
    }

    #[test]
    fn a_window_from_range_zero_has_no_near_edge() {
        let from_zero = FieldOfView { range_min_m: 0.0, ..VIEW };
        assert!((seen(&from_zero, 0.25, 0.2) - 0.89).abs() < 1e-12);
    }

    #[test]
    fn hard_edges_include_the_limit() {
        let hard = FieldOfView {
            range_min_m: 0.0,
            range_edge_m: 0.0,
            bearing_half_width_rad: PI,
            p_near: 0.95,
            p_far: 0.95,
            ..VIEW
        };
        let at = |x: f64| hard.detection_probability([x, 0.0], [0.0; 3]);
        assert_eq!(at(10.0), 0.95);
        assert_eq!(at(10.000_001), 0.0);
        assert_eq!(at(-1e-9), 0.95);
        assert_eq!(at(0.0), 0.0);
    }

    #[test]
    fn window_across_bearing_pi() {
        let astern = FieldOfView { bearing_center_rad: PI, ..VIEW };
        assert!((seen(&astern, 5.0, PI - 0.5) - 0.7).abs() < 1e-12);
        assert!((seen(&astern, 5.0, -PI + 0.5) - 0.7).abs() < 1e-12);
        assert_eq!(seen(&astern, 5.0, 0.0), 0.0);
    }
}
