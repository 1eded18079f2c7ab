//! Angles on the circle.

use std::f64::consts::{PI, TAU};

/// The same direction in (−π, π], rad.
pub(super) fn wrap(angle: f64) -> f64 {
    angle - TAU * ((angle - PI) / TAU).ceil()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_of_the_interval() {
        assert_eq!(wrap(PI), PI);
        assert_eq!(wrap(-PI), PI);
        assert_eq!(wrap(0.0), 0.0);
    }

    #[test]
    fn direction_is_kept() {
        for k in -400..400 {
            let angle = 0.1 * f64::from(k);
            let wrapped = wrap(angle);
            assert!(wrapped > -PI && wrapped <= PI, "{angle} became {wrapped}");
            assert!((wrapped.sin() - angle.sin()).abs() < 1e-13);
            assert!((wrapped.cos() - angle.cos()).abs() < 1e-13);
        }
    }
}
