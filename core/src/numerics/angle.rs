//! Angles on the circle.

use crate::Real;

/// The angle in (−π, π] that differs from `angle_rad` by whole turns.
///
/// ```
/// let a = scphd::numerics::wrap(3.5_f64);
/// assert!((a - (3.5 - core::f64::consts::TAU)).abs() < 1e-15);
/// assert_eq!(scphd::numerics::wrap(0.25_f32), 0.25);
/// ```
#[inline]
#[must_use]
pub fn wrap<T: Real>(angle_rad: T) -> T {
    // Most angles are in range already and must be returned unchanged to the bit.
    if angle_rad > -T::PI && angle_rad <= T::PI {
        return angle_rad;
    }
    let turn = T::PI + T::PI;
    // Sums and differences of two angles in range are at most one turn out of range.
    let nearest = if angle_rad > T::ZERO { angle_rad - turn } else { angle_rad + turn };
    if nearest > -T::PI && nearest <= T::PI {
        return nearest;
    }
    let wrapped = angle_rad - turn * ((angle_rad + T::PI) / turn).floor();
    // The subtraction gives a result in [−π, π); −π, and results out of range by rounding, become π.
    if wrapped > -T::PI { wrapped.at_most(T::PI) } else { T::PI }
}

#[cfg(test)]
mod tests {
    use super::wrap;
    use core::f64::consts::{PI, TAU};

    #[test]
    fn wraps_to_the_half_open_turn() {
        assert_eq!(wrap(0.0_f64), 0.0);
        assert_eq!(wrap(PI), PI);
        assert_eq!(wrap(-PI), PI);
        for k in -5..=5 {
            for step in -31..=31 {
                let angle = f64::from(step) * 0.1;
                let back = wrap(angle + TAU * f64::from(k));
                assert!((back - angle).abs() < 1e-13, "{angle} + {k} turns became {back}");
            }
        }
    }

    #[test]
    fn nan_stays_nan() {
        assert!(!(wrap(f64::INFINITY).abs() < PI));
    }
}
