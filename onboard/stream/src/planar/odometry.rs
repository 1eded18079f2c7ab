//! A prediction in the plane.

use crate::kind::Input;
use crate::numbers::Numbers;
use crate::scalar::Scalar;
use scphd::Real;
use scphd_vehicle::Control;

/// A prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Odometry {
    /// Speed (m/s); steering angle (rad) or turn rate (rad/s); speed to the left of a holonomic vehicle (m/s), else 0.
    pub control: [f64; 3],
    /// Its duration, s.
    pub dt_s: f64,
}

/// The part of a vehicle that moves sideways.
const LEFT: u8 = 1;

impl Odometry {
    /// A prediction with this control.
    #[must_use]
    pub fn of<T: Real>(control: Control<T>, dt_s: T) -> Self {
        Self { control: [control.speed_mps, control.turn, control.left_mps].map(T::to_f64), dt_s: dt_s.to_f64() }
    }

    /// The control, and its duration, s.
    pub(crate) fn input<T: Real>(&self) -> (Control<T>, T) {
        let [speed_mps, turn, left_mps] = self.control.map(T::from_f64);
        (Control { speed_mps, left_mps, turn }, T::from_f64(self.dt_s))
    }
}

impl Input for Odometry {
    fn parts(&self) -> u8 {
        let [_, _, left_mps] = self.control;
        if left_mps.to_bits() == 0 { 0 } else { LEFT }
    }

    fn count(parts: u8) -> Option<usize> {
        (parts <= LEFT).then_some(3 + usize::from(parts))
    }

    fn scalar(of_stream: Scalar) -> Scalar {
        of_stream
    }

    fn put(&self, sink: &mut impl FnMut(f64)) {
        let [speed_mps, turn, left_mps] = self.control;
        [speed_mps, turn, self.dt_s].put(sink);
        if self.parts() == LEFT {
            left_mps.put(sink);
        }
    }

    fn take(parts: u8, source: &mut impl FnMut() -> Option<f64>) -> Option<Self> {
        let [speed_mps, turn, dt_s] = Numbers::take(source)?;
        let left_mps = if parts == LEFT { source()? } else { 0.0 };
        Some(Self { control: [speed_mps, turn, left_mps], dt_s })
    }
}
