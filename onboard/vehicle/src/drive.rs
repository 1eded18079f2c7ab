//! How a vehicle moves: each motion in the plane as one.

use nalgebra::{Matrix3, Vector3};
use scphd::Real;
use scphd::models::{
    Ackermann, AckermannControl, AckermannGeometry, ByOdometry, ControlNoise, Holonomic, HolonomicControl, Linearised,
    ModelError, Motion, OdometryCorrection, PlanarPose, Rates, Step, Unicycle, UnicycleControl,
};
use scphd::numerics::Noise;

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

    fn ackermann(&self) -> AckermannControl<T> {
        AckermannControl { speed_mps: self.speed_mps, steering_rad: self.turn }
    }

    fn unicycle(&self) -> UnicycleControl<T> {
        UnicycleControl { speed_mps: self.speed_mps, rate_radps: self.turn }
    }

    fn holonomic(&self) -> HolonomicControl<T> {
        HolonomicControl { forward_mps: self.speed_mps, left_mps: self.left_mps, rate_radps: self.turn }
    }
}

/// The motion of any vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive<T> {
    /// Of a car.
    Ackermann(Ackermann<T>),
    /// Of a robot that turns in place.
    Unicycle(Unicycle<T>),
    /// Of one that moves aside.
    Holonomic(Holonomic<T>),
}

impl<T: Real> Vehicle<T> {
    /// The motion.
    ///
    /// # Errors
    /// A length or a noise is out of range.
    pub fn drive(&self) -> Result<Drive<T>, ModelError> {
        Ok(match self.kind {
            VehicleKind::Ackermann => Drive::Ackermann(Ackermann::new(self.geometry, self.noise)?),
            VehicleKind::Unicycle => Drive::Unicycle(Unicycle::new(Step::Arc, self.noise)?),
            VehicleKind::UnicycleEuler => Drive::Unicycle(Unicycle::new(Step::Euler, self.noise)?),
            VehicleKind::Holonomic => Drive::Holonomic(Holonomic::new(self.noise)?),
        })
    }
}

/// Hands a call to the motion that it is, with the control in its own type.
macro_rules! each {
    ($drive:expr, $control:expr, |$motion:ident, $own:ident| $call:expr) => {
        match $drive {
            Drive::Ackermann($motion) => {
                let $own = &$control.ackermann();
                $call
            }
            Drive::Unicycle($motion) => {
                let $own = &$control.unicycle();
                $call
            }
            Drive::Holonomic($motion) => {
                let $own = &$control.holonomic();
                $call
            }
        }
    };
}

impl<T: Real> Motion for Drive<T> {
    type Pose = PlanarPose<T>;
    type Control = Control<T>;

    const TRANSLATION_INVARIANT: bool = true;

    fn admits(&self, control: &Control<T>) -> bool {
        let aside = matches!(self, Self::Holonomic(_)) || control.left_mps == T::ZERO;
        aside && each!(self, control, |motion, own| motion.admits(own))
    }

    fn rates(&self, control: &Control<T>) -> Rates<T> {
        each!(self, control, |motion, own| motion.rates(own))
    }

    fn propagate(&self, pose: &PlanarPose<T>, control: &Control<T>, dt: T) -> PlanarPose<T> {
        each!(self, control, |motion, own| motion.propagate(pose, own, dt))
    }

    fn sample(&self, pose: &PlanarPose<T>, control: &Control<T>, dt: T, noise: &mut Noise) -> PlanarPose<T> {
        each!(self, control, |motion, own| motion.sample(pose, own, dt, noise))
    }

    fn linearise(&self, pose: &PlanarPose<T>, control: &Control<T>, dt: T) -> Linearised<Vector3<T>> {
        each!(self, control, |motion, own| motion.linearise(pose, own, dt))
    }
}

impl<T: Real> ByOdometry for Drive<T> {
    /// Of a vehicle that moves aside the size of the wheels scales both speeds, as [`Holonomic`] has it.
    fn corrected(control: &Control<T>, odometry: &OdometryCorrection<T>) -> Control<T> {
        let HolonomicControl { forward_mps, left_mps, rate_radps } =
            Holonomic::corrected(&control.holonomic(), odometry);
        Control { speed_mps: forward_mps, left_mps, turn: rate_radps }
    }

    fn by_odometry(&self, pose: &PlanarPose<T>, control: &Control<T>, corrected: &Control<T>, dt: T) -> Matrix3<T> {
        match self {
            Self::Ackermann(car) => car.by_odometry(pose, &control.ackermann(), &corrected.ackermann(), dt),
            Self::Unicycle(robot) => robot.by_odometry(pose, &control.unicycle(), &corrected.unicycle(), dt),
            Self::Holonomic(robot) => robot.by_odometry(pose, &control.holonomic(), &corrected.holonomic(), dt),
        }
    }
}
