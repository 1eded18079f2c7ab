//! The motion of a vehicle: all planar motion models as one type.

use scphd::Real;
use scphd::models::{
    Ackermann, AckermannControl, AckermannGeometry, ControlNoise, Holonomic, HolonomicControl, ModelError,
    PlanarControl, PlanarMotion, Step, Unicycle, UnicycleControl,
};

/// The motion models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VehicleKind {
    /// A car: speed of a wheel's encoder and steering angle.
    Ackermann,
    /// A robot that turns in place, along exact arcs.
    Unicycle,
    /// The same, along straight Euler steps.
    UnicycleEuler,
    /// A vehicle that moves sideways as well as ahead.
    Holonomic,
}

/// A motion model with the noise of its odometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vehicle<T> {
    /// The motion model.
    pub kind: VehicleKind,
    /// Lengths of a car.
    pub geometry: AckermannGeometry<T>,
    /// Noise of the controls.
    pub noise: ControlNoise<T>,
}

/// A control of any vehicle; components that the vehicle does not have are zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Control<T> {
    /// Speed ahead, m/s.
    pub speed_mps: T,
    /// Speed to the left of a holonomic vehicle, m/s.
    pub left_mps: T,
    /// Turn rate to the left, rad/s, or a car's steering angle, rad.
    pub turn: T,
}

impl<T: Real> Control<T> {
    /// The control of a vehicle at rest.
    pub const STILL: Self = Self { speed_mps: T::ZERO, left_mps: T::ZERO, turn: T::ZERO };
}

impl<T: Real> Vehicle<T> {
    /// The motion model.
    ///
    /// # Errors
    /// A length or a noise is out of range.
    pub fn drive(&self) -> Result<PlanarMotion<T>, ModelError> {
        // The noise is checked here first, so that an image contains the check only once.
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
    /// The control for the motion model. A lateral speed of a vehicle that cannot move sideways gives a control of another type,
    /// which the motion model refuses.
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
