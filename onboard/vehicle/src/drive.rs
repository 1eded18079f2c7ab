//! How a vehicle moves: each motion in the plane as one.

use scphd::Real;
use scphd::models::{
    Ackermann, AckermannControl, AckermannGeometry, ControlNoise, Holonomic, HolonomicControl, ModelError,
    PlanarControl, PlanarMotion, Step, Unicycle, UnicycleControl,
};

/// The motions that there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VehicleKind {
    /// A car: speed of a wheel's encoder and steering angle.
    Ackermann,
    /// A robot that turns in place, along exact arcs.
    Unicycle,
    /// The same, straight along its heading in every step.
    UnicycleEuler,
    /// A vehicle that moves aside as well as ahead.
    Holonomic,
}

/// A vehicle and the noise of its odometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vehicle<T> {
    /// How it moves.
    pub kind: VehicleKind,
    /// Of a car: its lengths.
    pub geometry: AckermannGeometry<T>,
    /// The noise of its controls.
    pub noise: ControlNoise<T>,
}

/// A control of any vehicle; what a vehicle does not have is zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Control<T> {
    /// Speed ahead, m/s.
    pub speed_mps: T,
    /// Speed to the left of a vehicle that moves aside, m/s.
    pub left_mps: T,
    /// Turn rate to the left, rad/s, or a car's steering angle, rad.
    pub turn: T,
}

impl<T: Real> Control<T> {
    /// A vehicle that stands.
    pub const STILL: Self = Self { speed_mps: T::ZERO, left_mps: T::ZERO, turn: T::ZERO };
}

impl<T: Real> Vehicle<T> {
    /// The motion.
    ///
    /// # Errors
    /// A length or a noise is out of range.
    pub fn drive(&self) -> Result<PlanarMotion<T>, ModelError> {
        // The noise is checked here first, and so only once in an image.
        let step = if self.kind == VehicleKind::UnicycleEuler { Step::Euler } else { Step::Arc };
        let unicycle = Unicycle::new(step, self.noise)?;
        Ok(match self.kind {
            VehicleKind::Ackermann => PlanarMotion::Ackermann(Ackermann::new(self.geometry, self.noise)?),
            VehicleKind::Unicycle | VehicleKind::UnicycleEuler => PlanarMotion::Unicycle(unicycle),
            VehicleKind::Holonomic => PlanarMotion::Holonomic(Holonomic::new(self.noise)?),
        })
    }
}

impl VehicleKind {
    /// A control as the motion takes it. One that moves a vehicle sideways which cannot is of another kind than its motion, which refuses it.
    #[must_use]
    pub fn control<T: Real>(self, control: &Control<T>) -> PlanarControl<T> {
        let &Control { speed_mps, left_mps, turn } = control;
        match self {
            Self::Ackermann if left_mps == T::ZERO => {
                PlanarControl::Ackermann(AckermannControl { speed_mps, steering_rad: turn })
            }
            Self::Unicycle | Self::UnicycleEuler if left_mps == T::ZERO => {
                PlanarControl::Unicycle(UnicycleControl { speed_mps, rate_radps: turn })
            }
            _ => PlanarControl::Holonomic(HolonomicControl { forward_mps: speed_mps, left_mps, rate_radps: turn }),
        }
    }
}
