//! The vehicle of a planar stream.

use crate::kind::Input;
use crate::numbers::{Numbers, numbers};
use crate::scalar::Scalar;

/// The kind of streams of planar vehicles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Planar;

/// The motion model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Vehicle {
    /// Speed of the encoder's wheel and steering angle (5.25–5.27).
    Ackermann,
    /// Speed and turn rate, Euler step.
    Unicycle,
    /// Speed and turn rate, exact arc.
    UnicycleArc,
}

numbers! {
    /// A prediction.
    Odometry {
        /// Speed (m/s), then steering angle (rad) or turn rate (rad/s).
        control: [f64; 2],
        /// Its duration, s.
        dt_s: f64,
    }
}

/// It has no optional parts.
impl Input for Odometry {
    fn parts(&self) -> u8 {
        0
    }

    fn count(parts: u8) -> Option<usize> {
        (parts == 0).then_some(Self::COUNT)
    }

    fn scalar(of_stream: Scalar) -> Scalar {
        of_stream
    }

    fn put(&self, sink: &mut impl FnMut(f64)) {
        Numbers::put(self, sink);
    }

    fn take(_parts: u8, source: &mut impl FnMut() -> Option<f64>) -> Option<Self> {
        Numbers::take(source)
    }
}
