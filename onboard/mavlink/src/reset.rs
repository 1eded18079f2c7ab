//! The reset counter, which tells a flight stack that the pose has jumped and that this was no motion.

use crate::axes::wrap;

/// Counts jumps of the pose: corrections of the filter above a limit, for example by a loop closure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResetCounter {
    limit_m: f32,
    limit_rad: f32,
    counter: u8,
}

impl ResetCounter {
    /// Corrections of at most this size, m and rad, are no jumps.
    pub const fn new(limit_m: f32, limit_rad: f32) -> Self {
        Self { limit_m, limit_rad, counter: 0 }
    }

    /// The value to send; it wraps after 255.
    pub const fn value(&self) -> u8 {
        self.counter
    }

    /// Adds a correction with this size, m and rad, as returned by `SmoothOdometry::correct`. Returns whether it is a jump; NaN
    /// is one.
    pub fn correct(&mut self, distance_m: f32, angle_rad: f32) -> bool {
        let is_small = distance_m <= self.limit_m && angle_rad.abs() <= self.limit_rad;
        if !is_small {
            self.raise();
        }
        !is_small
    }

    /// Adds the correction between the poses (x, y, heading) before and after a scan or a fix.
    pub fn between(&mut self, before: [f32; 3], after: [f32; 3]) -> bool {
        let ([x, y, heading], [nx, ny, turned]) = (before, after);
        self.correct(libm::hypotf(nx - x, ny - y), wrap(turned - heading))
    }

    /// To be called when the vehicle was relocated, or the filter was reset.
    pub fn raise(&mut self) {
        self.counter = self.counter.wrapping_add(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::PI;

    #[test]
    fn jumps_are_counted() {
        let mut counter = ResetCounter::new(0.5, 0.2);
        assert!(!counter.between([1.0, 2.0, 3.1], [1.3, 2.3, -3.1]));
        assert!(counter.between([1.0, 2.0, 0.0], [1.4, 2.4, 0.0]));
        assert!(counter.between([1.0, 2.0, 0.0], [1.0, 2.0, -0.3]));
        assert!(counter.between([0.0; 3], [0.0, 0.0, PI]));
        assert!(counter.correct(f32::NAN, 0.0) && counter.correct(0.0, f32::NAN));
        assert_eq!(counter.value(), 5);
        (0..251).for_each(|_| counter.raise());
        assert_eq!(counter.value(), 0);
    }
}
