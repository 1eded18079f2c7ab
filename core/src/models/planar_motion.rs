//! A motion model in the plane whose type is chosen at run time.

use super::{
    Ackermann, AckermannControl, ByOdometry, Holonomic, HolonomicControl, Linearised, ModelError, Motion,
    OdometryCorrection, PlanarPose, Unicycle, UnicycleControl,
};
use crate::{Noise, Rates, Real, Symmetric};
use nalgebra::{Matrix3, Vector3};

/// A vehicle in the plane whose type is chosen at run time, for example by a settings file: a filter with it is compiled once for
/// all types.
///
/// ```
/// use scphd::models::{
///     ControlNoise, Motion, PlanarControl, PlanarMotion, PlanarPose, Step, Unicycle, UnicycleControl,
/// };
///
/// let robot = PlanarMotion::Unicycle(Unicycle::new(Step::Arc, ControlNoise::NONE)?);
/// let ahead = PlanarControl::Unicycle(UnicycleControl { speed_mps: 2.0, rate_radps: 0.0 });
/// assert_eq!(robot.propagate(&PlanarPose::new(1.0, 0.0, 0.0), &ahead, 0.5_f32), PlanarPose::new(2.0, 0.0, 0.0));
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlanarMotion<T> {
    /// A car: speed of the wheel with the encoder, and steering angle.
    Ackermann(Ackermann<T>),
    /// A robot: speed and turn rate.
    Unicycle(Unicycle<T>),
    /// A holonomic vehicle: speed ahead and to the left, and turn rate.
    Holonomic(Holonomic<T>),
}

/// The control of a [`PlanarMotion`]. A control of another type than that of the motion is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlanarControl<T> {
    /// Control of a car.
    Ackermann(AckermannControl<T>),
    /// Control of a robot.
    Unicycle(UnicycleControl<T>),
    /// Control of a holonomic vehicle.
    Holonomic(HolonomicControl<T>),
}

/// Evaluates an expression with the motion and the control of its type; `$other` if their types differ.
macro_rules! each {
    ($motion:expr, $control:expr, |$vehicle:ident, $own:ident| $done:expr, else $other:expr) => {
        match ($motion, $control) {
            (Self::Ackermann($vehicle), PlanarControl::Ackermann($own)) => $done,
            (Self::Unicycle($vehicle), PlanarControl::Unicycle($own)) => $done,
            (Self::Holonomic($vehicle), PlanarControl::Holonomic($own)) => $done,
            _ => $other,
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
        each!(self, control, |vehicle, own| vehicle.admits(own), else false)
    }

    fn rates(&self, control: &Self::Control) -> Rates<T> {
        each!(self, control, |vehicle, own| vehicle.rates(own), else Rates::NONE)
    }

    fn propagate(&self, pose: &Self::Pose, control: &Self::Control, dt: T) -> Self::Pose {
        each!(self, control, |vehicle, own| vehicle.propagate(pose, own, dt), else *pose)
    }

    fn sample(&self, pose: &Self::Pose, control: &Self::Control, dt: T, noise: &mut Noise) -> Self::Pose {
        each!(self, control, |vehicle, own| vehicle.sample(pose, own, dt, noise), else *pose)
    }

    fn linearise(&self, pose: &Self::Pose, control: &Self::Control, dt: T) -> Linearised<Vector3<T>> {
        each!(self, control, |vehicle, own| vehicle.linearise(pose, own, dt),
            else Linearised { transition: Matrix3::identity(), noise: Symmetric::ZERO })
    }
}

impl<T: Real> ByOdometry for PlanarMotion<T> {
    fn corrected(control: &Self::Control, odometry: &OdometryCorrection<T>) -> Self::Control {
        match control {
            PlanarControl::Ackermann(own) => PlanarControl::Ackermann(Ackermann::corrected(own, odometry)),
            PlanarControl::Unicycle(own) => PlanarControl::Unicycle(Unicycle::corrected(own, odometry)),
            PlanarControl::Holonomic(own) => PlanarControl::Holonomic(Holonomic::corrected(own, odometry)),
        }
    }

    fn by_odometry(&self, pose: &Self::Pose, control: &Self::Control, corrected: &Self::Control, dt: T) -> Matrix3<T> {
        match (self, control, corrected) {
            (Self::Ackermann(car), PlanarControl::Ackermann(control), PlanarControl::Ackermann(corrected)) => {
                car.by_odometry(pose, control, corrected, dt)
            }
            (Self::Unicycle(robot), PlanarControl::Unicycle(control), PlanarControl::Unicycle(corrected)) => {
                robot.by_odometry(pose, control, corrected, dt)
            }
            (Self::Holonomic(vehicle), PlanarControl::Holonomic(control), PlanarControl::Holonomic(corrected)) => {
                vehicle.by_odometry(pose, control, corrected, dt)
            }
            _ => Matrix3::zeros(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{PlanarControl, PlanarMotion};
    use crate::{
        Ackermann, AckermannControl, AckermannGeometry, ByOdometry, ControlNoise, Holonomic, HolonomicControl, Motion,
        Noise, OdometryCorrection, PlanarPose, Rates, Step, Unicycle, UnicycleControl,
    };

    const CAR: AckermannControl<f64> = AckermannControl { speed_mps: 1.7, steering_rad: 0.3 };
    const ROBOT: UnicycleControl<f64> = UnicycleControl { speed_mps: 1.7, rate_radps: 0.3 };
    const SIDEWAYS: HolonomicControl<f64> = HolonomicControl { forward_mps: 1.7, left_mps: -0.4, rate_radps: 0.3 };
    const CONTROLS: [PlanarControl<f64>; 3] =
        [PlanarControl::Ackermann(CAR), PlanarControl::Unicycle(ROBOT), PlanarControl::Holonomic(SIDEWAYS)];
    const CORRECTION: OdometryCorrection<f64> =
        OdometryCorrection { speed_scale: 0.03, turn_scale: -0.02, turn_offset: 0.01 };

    /// Compares all results with those of the vehicle itself, and checks that controls of other types are refused and have no
    /// effect.
    fn is_as<M: ByOdometry<Pose = PlanarPose<f64>>>(
        any: PlanarMotion<f64>,
        own: M,
        control: M::Control,
        wrap: fn(M::Control) -> PlanarControl<f64>,
    ) {
        let pose = PlanarPose::new(3.0, -2.0, 0.7);
        let of_any = wrap(control);
        assert_eq!(any.check(), own.check());
        assert!(any.admits(&of_any));
        assert_eq!(any.rates(&of_any), own.rates(&control));
        assert_eq!(any.propagate(&pose, &of_any, 0.2), own.propagate(&pose, &control, 0.2));
        let mut draws = [Noise::seeded(3), Noise::seeded(3)];
        let [one, other] = &mut draws;
        assert_eq!(any.sample(&pose, &of_any, 0.2, one), own.sample(&pose, &control, 0.2, other));
        assert_eq!(any.linearise(&pose, &of_any, 0.2), own.linearise(&pose, &control, 0.2));
        let corrected = M::corrected(&control, &CORRECTION);
        assert_eq!(PlanarMotion::corrected(&of_any, &CORRECTION), wrap(corrected));
        let by = any.by_odometry(&pose, &of_any, &wrap(corrected), 0.2);
        assert_eq!(by, own.by_odometry(&pose, &control, &corrected, 0.2));
        for wrong in CONTROLS.iter().filter(|other| core::mem::discriminant(*other) != core::mem::discriminant(&of_any))
        {
            assert!(!any.admits(wrong));
            assert_eq!(any.rates(wrong), Rates::NONE);
            assert_eq!(any.propagate(&pose, wrong, 0.2), pose);
        }
    }

    #[test]
    fn every_type_agrees_with_the_vehicle_itself() {
        let noise = ControlNoise { speed_sigma_ratio: 0.1, ..ControlNoise::white(0.1, 0.05) };
        let geometry =
            AckermannGeometry { wheelbase_m: 2.8, encoder_offset_m: 0.7, sensor_forward_m: 1.0, sensor_left_m: 0.2 };
        let car = Ackermann::new(geometry, noise).unwrap();
        is_as(PlanarMotion::Ackermann(car), car, CAR, PlanarControl::Ackermann);
        let robot = Unicycle::new(Step::Arc, noise).unwrap();
        is_as(PlanarMotion::Unicycle(robot), robot, ROBOT, PlanarControl::Unicycle);
        let vehicle = Holonomic::new(noise).unwrap();
        is_as(PlanarMotion::Holonomic(vehicle), vehicle, SIDEWAYS, PlanarControl::Holonomic);
    }
}
