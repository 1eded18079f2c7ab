//! The reset counter: how a flight stack is told that a pose has jumped, and is not to be taken for motion.

use crate::axes::wrap;

/// Counts jumps. A correction of the filter is one where it is greater than a limit: a loop closure, say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResetCounter {
    limit_m: f32,
    limit_rad: f32,
    counter: u8,
}

impl ResetCounter {
    /// Corrections of at most this size, m and rad, are none.
    #[must_use]
    pub const fn new(limit_m: f32, limit_rad: f32) -> Self {
        Self { limit_m, limit_rad, counter: 0 }
    }

    /// What messages carry; after 255 it is 0 again.
    #[must_use]
    pub const fn value(&self) -> u8 {
        self.counter
    }

    /// Takes a correction, as `SmoothOdometry::correct` returns its size, m and rad; whether it was a jump. One that is not a number is.
    pub fn correct(&mut self, distance_m: f32, angle_rad: f32) -> bool {
        let is_small = distance_m <= self.limit_m && angle_rad.abs() <= self.limit_rad;
        if !is_small {
            self.raise();
        }
        !is_small
    }

    /// The same of the pose (x, y, heading) before a scan or fix and after it.
    pub fn between(&mut self, before: [f32; 3], after: [f32; 3]) -> bool {
        let ([x, y, heading], [nx, ny, turned]) = (before, after);
        self.correct(libm::hypotf(nx - x, ny - y), wrap(turned - heading))
    }

    /// The vehicle was located anew, or the filter was reset.
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
