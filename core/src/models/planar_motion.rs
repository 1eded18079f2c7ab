//! Any vehicle in the plane as one motion, where its kind is known at run time.

use super::{
    Ackermann, AckermannControl, ByOdometry, Holonomic, HolonomicControl, Linearised, ModelError, Motion,
    OdometryCorrection, PlanarPose, Unicycle, UnicycleControl,
};
use crate::{Noise, Rates, Real};
use nalgebra::{Matrix3, Vector3};

/// A vehicle in the plane whose kind is chosen at run time, such as by a file of settings: a filter with it is compiled once for all kinds.
///
/// ```
/// use scphd::models::{ControlNoise, Motion, PlanarControl, PlanarMotion, PlanarPose, Step, Unicycle};
///
/// let robot = PlanarMotion::Unicycle(Unicycle::new(Step::Arc, ControlNoise::NONE)?);
/// let ahead = PlanarControl { speed_mps: 2.0, turn: 0.0, left_mps: 0.0 };
/// assert_eq!(robot.propagate(&PlanarPose::new(1.0, 0.0, 0.0), &ahead, 0.5_f32), PlanarPose::new(2.0, 0.0, 0.0));
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlanarMotion<T> {
    /// A car: speed of the encoder's wheel and steering angle.
    Ackermann(Ackermann<T>),
    /// A robot: speed and turn rate.
    Unicycle(Unicycle<T>),
    /// A vehicle that moves sideways too: speed ahead and to the left, and turn rate.
    Holonomic(Holonomic<T>),
}

/// The control of a [`PlanarMotion`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanarControl<T> {
    /// Speed ahead, m/s.
    pub speed_mps: T,
    /// Steering angle of a car, rad; turn rate of the others, rad/s.
    pub turn: T,
    /// Speed to the left, m/s; counts for [`Holonomic`] alone.
    pub left_mps: T,
}

impl<T: Copy> PlanarControl<T> {
    fn of_car(&self) -> AckermannControl<T> {
        AckermannControl { speed_mps: self.speed_mps, steering_rad: self.turn }
    }

    fn of_robot(&self) -> UnicycleControl<T> {
        UnicycleControl { speed_mps: self.speed_mps, rate_radps: self.turn }
    }

    fn of_holonomic(&self) -> HolonomicControl<T> {
        HolonomicControl { forward_mps: self.speed_mps, left_mps: self.left_mps, rate_radps: self.turn }
    }
}

/// Does the same with any kind, each with its own control.
macro_rules! each {
    ($motion:expr, $control:expr, $vehicle:ident, $own:ident => $done:expr) => {
        match $motion {
            PlanarMotion::Ackermann($vehicle) => {
                let $own = &$control.of_car();
                $done
            }
            PlanarMotion::Unicycle($vehicle) => {
                let $own = &$control.of_robot();
                $done
            }
            PlanarMotion::Holonomic($vehicle) => {
                let $own = &$control.of_holonomic();
                $done
            }
        }
    };
}

impl<T: Real> Motion for PlanarMotion<T> {
    type Pose = PlanarPose<T>;
    type Control = PlanarControl<T>;

    const TRANSLATION_INVARIANT: bool = true;

    fn check(&self) -> Result<(), ModelError> {
        match self {
            Self::Ackermann(car) => car.check(),
            Self::Unicycle(robot) => robot.check(),
            Self::Holonomic(vehicle) => vehicle.check(),
        }
    }

    fn admits(&self, control: &Self::Control) -> bool {
        each!(self, control, vehicle, own => vehicle.admits(own))
    }

    fn rates(&self, control: &Self::Control) -> Rates<T> {
        each!(self, control, vehicle, own => vehicle.rates(own))
    }

    fn propagate(&self, pose: &Self::Pose, control: &Self::Control, dt: T) -> Self::Pose {
        each!(self, control, vehicle, own => vehicle.propagate(pose, own, dt))
    }

    fn sample(&self, pose: &Self::Pose, control: &Self::Control, dt: T, noise: &mut Noise) -> Self::Pose {
        each!(self, control, vehicle, own => vehicle.sample(pose, own, dt, noise))
    }

    fn linearise(&self, pose: &Self::Pose, control: &Self::Control, dt: T) -> Linearised<Vector3<T>> {
        each!(self, control, vehicle, own => vehicle.linearise(pose, own, dt))
    }
}

impl<T: Real> ByOdometry for PlanarMotion<T> {
    fn corrected(control: &Self::Control, odometry: &OdometryCorrection<T>) -> Self::Control {
        let [speed_mps, turn] = odometry.corrected([control.speed_mps, control.turn]);
        let [left_mps, _] = odometry.corrected([control.left_mps, T::ZERO]);
        PlanarControl { speed_mps, turn, left_mps }
    }

    fn by_odometry(&self, pose: &Self::Pose, control: &Self::Control, corrected: &Self::Control, dt: T) -> Matrix3<T> {
        match self {
            Self::Ackermann(car) => car.by_odometry(pose, &control.of_car(), &corrected.of_car(), dt),
            Self::Unicycle(robot) => robot.by_odometry(pose, &control.of_robot(), &corrected.of_robot(), dt),
            Self::Holonomic(vehicle) => {
                vehicle.by_odometry(pose, &control.of_holonomic(), &corrected.of_holonomic(), dt)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{PlanarControl, PlanarMotion};
    use crate::{
        Ackermann, AckermannGeometry, ByOdometry, ControlNoise, Holonomic, Motion, Noise, OdometryCorrection,
        PlanarPose, Step, Unicycle,
    };

    const CONTROL: PlanarControl<f64> = PlanarControl { speed_mps: 1.7, turn: 0.3, left_mps: -0.4 };
    const CORRECTION: OdometryCorrection<f64> =
        OdometryCorrection { speed_scale: 0.03, turn_scale: -0.02, turn_offset: 0.01 };

    /// Every answer is that of the vehicle itself.
    fn is_as<M: ByOdometry<Pose = PlanarPose<f64>>>(any: PlanarMotion<f64>, own: M, control: M::Control)
    where
        M::Control: PartialEq + core::fmt::Debug,
    {
        let pose = PlanarPose::new(3.0, -2.0, 0.7);
        assert_eq!(any.check(), own.check());
        assert_eq!(any.admits(&CONTROL), own.admits(&control));
        assert!(!any.admits(&PlanarControl { speed_mps: f64::NAN, ..CONTROL }));
        assert_eq!(any.rates(&CONTROL), own.rates(&control));
        assert_eq!(any.propagate(&pose, &CONTROL, 0.2), own.propagate(&pose, &control, 0.2));
        let mut draws = [Noise::seeded(3), Noise::seeded(3)];
        let [one, other] = &mut draws;
        assert_eq!(any.sample(&pose, &CONTROL, 0.2, one), own.sample(&pose, &control, 0.2, other));
        assert_eq!(any.linearise(&pose, &CONTROL, 0.2), own.linearise(&pose, &control, 0.2));
        let corrected = (PlanarMotion::corrected(&CONTROL, &CORRECTION), M::corrected(&control, &CORRECTION));
        let by = any.by_odometry(&pose, &CONTROL, &corrected.0, 0.2);
        assert_eq!(by, own.by_odometry(&pose, &control, &corrected.1, 0.2));
        assert_eq!(any.propagate(&pose, &corrected.0, 0.2), own.propagate(&pose, &corrected.1, 0.2));
    }

    #[test]
    fn every_kind_is_the_vehicle_itself() {
        let noise = ControlNoise { speed_sigma_ratio: 0.1, ..ControlNoise::white(0.1, 0.05) };
        let geometry =
            AckermannGeometry { wheelbase_m: 2.8, encoder_offset_m: 0.7, sensor_forward_m: 1.0, sensor_left_m: 0.2 };
        let car = Ackermann::new(geometry, noise).unwrap();
        is_as(PlanarMotion::Ackermann(car), car, CONTROL.of_car());
        let robot = Unicycle::new(Step::Arc, noise).unwrap();
        is_as(PlanarMotion::Unicycle(robot), robot, CONTROL.of_robot());
        let vehicle = Holonomic::new(noise).unwrap();
        is_as(PlanarMotion::Holonomic(vehicle), vehicle, CONTROL.of_holonomic());
    }
}
