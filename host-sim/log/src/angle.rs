//! Angles.

use std::f64::consts::PI;

/// The angle (rad) wrapped to (−π, π]. Angles in this interval are returned bit for bit.
pub fn wrap(angle_rad: f64) -> f64 {
    if angle_rad > -PI && angle_rad <= PI {
        return angle_rad;
    }
    let wrapped = angle_rad - 2.0 * PI * ((angle_rad - PI) / (2.0 * PI)).ceil();
    // Rounding may give a result just outside the interval.
    if wrapped <= -PI || wrapped > PI { PI } else { wrapped }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_wrapped_to_the_half_open_interval() {
        assert_eq!(wrap(0.3), 0.3);
        assert_eq!(wrap(PI), PI);
        assert_eq!(wrap(-PI), PI);
        assert!((wrap(1.5 * PI) + 0.5 * PI).abs() < 1e-15);
        assert!((wrap(-1.5 * PI) - 0.5 * PI).abs() < 1e-15);
        for k in -40..=40 {
            let a = wrap(0.7 + 2.0 * PI * f64::from(k));
            assert!((a - 0.7).abs() < 1e-13);
            let edge = wrap(PI * f64::from(k));
            assert!(edge > -PI && edge <= PI);
        }
    }
}
