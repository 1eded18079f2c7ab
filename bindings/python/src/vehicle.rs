//! Vehicles in the plane: what Python makes of them, and all of them as one motion.

use crate::array::row;
use crate::error::{SettingError, of_model, wrong_type};
use nalgebra::{Matrix3, Vector3};
use pyo3::prelude::*;
use scphd::models::{
    AckermannControl, AckermannGeometry, ControlNoise, HolonomicControl, Linearised, Motion, PlanarControl,
    PlanarMotion, PlanarPose, Rates, Step, UnicycleControl,
};
use scphd::numerics::{Noise, Symmetric};

/// Odometry is never exact, and a filter that takes it to be follows it blindly.
fn some_noise(noise: &ControlNoise<f32>) -> PyResult<()> {
    if noise.is_none() {
        return Err(SettingError::new_err("odometry without any noise: a sigma or a ratio must be above zero"));
    }
    Ok(())
}

/// A robot that turns in place: its control is its speed (m/s) and its turn rate (rad/s, to the left).
///
/// Without arguments it has the noise of a wheeled vehicle that nobody has measured.
///
/// Parameters
/// ----------
/// speed_sigma_mps : float
///     Standard deviation of the speed, m/s.
/// speed_sigma_ratio : float
///     The same as a share of the speed; adds in quadrature.
/// turn_sigma : float
///     Standard deviation of the turn rate, rad/s.
/// turn_sigma_ratio : float
///     The same as a share of it; adds in quadrature.
/// noise_interval_s : float
///     How long an error lasts, s; 0: it is drawn anew in every prediction.
/// step : str
///     'arc': it goes along the exact arc. 'euler': straight ahead, and turns then.
#[pyclass(frozen, module = "scphd")]
pub struct Unicycle(scphd::models::Unicycle<f32>);

#[pymethods]
impl Unicycle {
    #[new]
    #[pyo3(signature = (*, speed_sigma_mps=0.02, speed_sigma_ratio=0.1, turn_sigma=0.02, turn_sigma_ratio=0.1,
                        noise_interval_s=0.5, step="arc"))]
    fn new(
        speed_sigma_mps: f32,
        speed_sigma_ratio: f32,
        turn_sigma: f32,
        turn_sigma_ratio: f32,
        noise_interval_s: f32,
        step: &str,
    ) -> PyResult<Self> {
        let step = match step {
            "arc" => Step::Arc,
            "euler" => Step::Euler,
            other => return Err(SettingError::new_err(format!("step must be 'arc' or 'euler', not '{other}'"))),
        };
        let noise = ControlNoise {
            speed_sigma_mps,
            speed_sigma_ratio,
            turn_sigma,
            turn_sigma_ratio,
            interval_s: noise_interval_s,
        };
        let names = [("interval_s", "noise_interval_s")];
        some_noise(&noise)?;
        scphd::models::Unicycle::new(step, noise).map(Self).map_err(|error| of_model(error, &names))
    }
}

/// A car: its control is the speed of a wheel's encoder (m/s) and its steering angle (rad, to the left).
///
/// Parameters
/// ----------
/// wheelbase_m : float
///     Wheelbase, m.
/// encoder_offset_m : float
///     How far left of the centreline the wheel of the encoder is, m.
/// pose_forward_m, pose_left_m : float
///     How far ahead of the rear axle and left of the centreline the pose is, m.
/// speed_sigma_mps : float
///     Standard deviation of the speed, m/s.
/// speed_sigma_ratio : float
///     The same as a share of the speed; adds in quadrature.
/// turn_sigma : float
///     Standard deviation of the steering angle, rad.
/// turn_sigma_ratio : float
///     The same as a share of it; adds in quadrature.
/// noise_interval_s : float
///     How long an error lasts, s; 0: it is drawn anew in every prediction.
#[pyclass(frozen, module = "scphd")]
pub struct Ackermann(scphd::models::Ackermann<f32>);

#[pymethods]
impl Ackermann {
    #[new]
    #[pyo3(signature = (*, wheelbase_m, encoder_offset_m=0.0, pose_forward_m=0.0, pose_left_m=0.0, speed_sigma_mps=0.02,
                        speed_sigma_ratio=0.1, turn_sigma=0.02, turn_sigma_ratio=0.1, noise_interval_s=0.5))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn new(
        wheelbase_m: f32,
        encoder_offset_m: f32,
        pose_forward_m: f32,
        pose_left_m: f32,
        speed_sigma_mps: f32,
        speed_sigma_ratio: f32,
        turn_sigma: f32,
        turn_sigma_ratio: f32,
        noise_interval_s: f32,
    ) -> PyResult<Self> {
        let geometry = AckermannGeometry {
            wheelbase_m,
            encoder_offset_m,
            sensor_forward_m: pose_forward_m,
            sensor_left_m: pose_left_m,
        };
        let noise = ControlNoise {
            speed_sigma_mps,
            speed_sigma_ratio,
            turn_sigma,
            turn_sigma_ratio,
            interval_s: noise_interval_s,
        };
        let names = [
            ("sensor_forward_m", "pose_forward_m"),
            ("sensor_left_m", "pose_left_m"),
            ("interval_s", "noise_interval_s"),
        ];
        some_noise(&noise)?;
        scphd::models::Ackermann::new(geometry, noise).map(Self).map_err(|error| of_model(error, &names))
    }
}

/// A vehicle that moves sideways too, on mecanum wheels or legs: its control is its speed ahead and to the left (m/s) and its turn rate
/// (rad/s, to the left).
///
/// Parameters
/// ----------
/// speed_sigma_mps : float
///     Standard deviation of the speed, m/s, the same in both directions.
/// speed_sigma_ratio : float
///     The same as a share of the speed over ground; adds in quadrature.
/// turn_sigma : float
///     Standard deviation of the turn rate, rad/s.
/// turn_sigma_ratio : float
///     The same as a share of it; adds in quadrature.
/// noise_interval_s : float
///     How long an error lasts, s; 0: it is drawn anew in every prediction.
#[pyclass(frozen, module = "scphd")]
pub struct Holonomic(scphd::models::Holonomic<f32>);

#[pymethods]
impl Holonomic {
    #[new]
    #[pyo3(signature = (*, speed_sigma_mps=0.02, speed_sigma_ratio=0.1, turn_sigma=0.02, turn_sigma_ratio=0.1,
                        noise_interval_s=0.5))]
    fn new(
        speed_sigma_mps: f32,
        speed_sigma_ratio: f32,
        turn_sigma: f32,
        turn_sigma_ratio: f32,
        noise_interval_s: f32,
    ) -> PyResult<Self> {
        let noise = ControlNoise {
            speed_sigma_mps,
            speed_sigma_ratio,
            turn_sigma,
            turn_sigma_ratio,
            interval_s: noise_interval_s,
        };
        some_noise(&noise)?;
        let names = [("interval_s", "noise_interval_s")];
        scphd::models::Holonomic::new(noise).map(Self).map_err(|error| of_model(error, &names))
    }
}

/// A vehicle whose pose is known: its control is the pose (x m, y m, heading rad) at the end of the step. With one particle a
/// `Filter` over it is a Gaussian-mixture PHD filter, for tracking from a known place.
#[pyclass(frozen, module = "scphd")]
pub struct KnownPose;

#[pymethods]
impl KnownPose {
    #[new]
    fn new() -> Self {
        Self
    }
}

/// Any of them.
#[derive(Debug, Clone, Copy)]
pub enum Vehicle {
    /// One that moves by its odometry.
    Driven(PlanarMotion<f32>),
    /// One whose pose is known.
    Known(scphd::models::KnownPose<PlanarPose<f32>>),
}

/// The control of any of them.
#[derive(Debug, Clone, Copy)]
pub enum Control {
    /// Of one that moves by its odometry.
    Driven(PlanarControl<f32>),
    /// Of one whose pose is known.
    Known(PlanarPose<f32>),
}

impl Vehicle {
    /// What an object of Python is.
    pub fn of(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(robot) = object.cast::<Unicycle>() {
            return Ok(Self::Driven(PlanarMotion::Unicycle(robot.get().0)));
        }
        if let Ok(car) = object.cast::<Ackermann>() {
            return Ok(Self::Driven(PlanarMotion::Ackermann(car.get().0)));
        }
        if let Ok(vehicle) = object.cast::<Holonomic>() {
            return Ok(Self::Driven(PlanarMotion::Holonomic(vehicle.get().0)));
        }
        if object.cast::<KnownPose>().is_ok() {
            return Ok(Self::Known(scphd::models::KnownPose::new()));
        }
        Err(wrong_type("vehicle", "a Unicycle, an Ackermann, a Holonomic or a KnownPose", object))
    }

    /// The control that an array stands for.
    pub fn control(&self, array: &Bound<'_, PyAny>) -> PyResult<Control> {
        Ok(match self {
            Self::Driven(PlanarMotion::Unicycle(_)) => {
                let [speed_mps, rate_radps] = row("control (speed_mps, turn_rate_radps)", array)?;
                Control::Driven(PlanarControl::Unicycle(UnicycleControl { speed_mps, rate_radps }))
            }
            Self::Driven(PlanarMotion::Ackermann(_)) => {
                let [speed_mps, steering_rad] = row("control (speed_mps, steering_rad)", array)?;
                Control::Driven(PlanarControl::Ackermann(AckermannControl { speed_mps, steering_rad }))
            }
            Self::Driven(PlanarMotion::Holonomic(_)) => {
                let [forward_mps, left_mps, rate_radps] =
                    row("control (forward_mps, left_mps, turn_rate_radps)", array)?;
                Control::Driven(PlanarControl::Holonomic(HolonomicControl { forward_mps, left_mps, rate_radps }))
            }
            Self::Known(_) => {
                let [x_m, y_m, heading_rad] = row("control (x_m, y_m, heading_rad)", array)?;
                Control::Known(PlanarPose::new(x_m, y_m, heading_rad))
            }
        })
    }
}

/// Does the same with a vehicle and a control of its kind; `$other` where it is of another one.
macro_rules! each {
    ($vehicle:expr, $control:expr, |$motion:ident, $of_kind:ident| $done:expr, else $other:expr) => {
        match ($vehicle, $control) {
            (Self::Driven($motion), Control::Driven($of_kind)) => $done,
            (Self::Known($motion), Control::Known($of_kind)) => $done,
            _ => $other,
        }
    };
}

impl Motion for Vehicle {
    type Pose = PlanarPose<f32>;
    type Control = Control;

    /// So are the others; a known pose has no speed, so that no step of it is short.
    const TRANSLATION_INVARIANT: bool = true;

    fn admits(&self, control: &Control) -> bool {
        each!(self, control, |motion, control| motion.admits(control), else false)
    }

    fn rates(&self, control: &Control) -> Rates<f32> {
        each!(self, control, |motion, control| motion.rates(control), else Rates::NONE)
    }

    fn propagate(&self, pose: &PlanarPose<f32>, control: &Control, dt: f32) -> PlanarPose<f32> {
        each!(self, control, |motion, control| motion.propagate(pose, control, dt), else *pose)
    }

    fn sample(&self, pose: &PlanarPose<f32>, control: &Control, dt: f32, noise: &mut Noise) -> PlanarPose<f32> {
        each!(self, control, |motion, control| motion.sample(pose, control, dt, noise), else *pose)
    }

    fn linearise(&self, pose: &PlanarPose<f32>, control: &Control, dt: f32) -> Linearised<Vector3<f32>> {
        each!(self, control, |motion, control| motion.linearise(pose, control, dt),
            else Linearised { transition: Matrix3::identity(), noise: Symmetric::ZERO })
    }
}
