//! Angles on the circle.

use std::f64::consts::{PI, TAU};

/// The same direction in (−π, π], rad.
pub(super) fn wrap(angle: f64) -> f64 {
    angle - TAU * ((angle - PI) / TAU).ceil()
}
