//! Vehicles in the plane: the Python classes, and `Vehicle`, a motion model for all of them.

use crate::array::{Number, row};
use crate::error::{SettingError, of_model, wrong_type};
use crate::keywords::{Keywords, object};
use crate::tuning;
use nalgebra::{Matrix3, Vector3};
use pyo3::prelude::*;
use scphd::Real;
use scphd::models::{
    AckermannGeometry, ControlNoise, Linearised, Motion, PlanarControl, PlanarMotion, PlanarPose, Rates,
};
use scphd::numerics::{Noise, Symmetric};
use scphd_vehicle::{Description, VehicleKind};

/// The description of a vehicle that moves by its odometry.
pub type Driven<T> = scphd_vehicle::Vehicle<T>;

/// A vehicle in the precision of a filter.
fn cast<T: Real>(vehicle: &Driven<f64>) -> PyResult<Driven<T>> {
    Ok(tuning::cast(&Description { vehicle: *vehicle, ..Description::robot() })?.vehicle)
}

/// Lengths of vehicles other than cars.
const NO_LENGTHS: AckermannGeometry<f64> =
    AckermannGeometry { wheelbase_m: 1.0, encoder_offset_m: 0.0, sensor_forward_m: 0.0, sensor_left_m: 0.0 };

/// A vehicle whose parameters are in range, also in single precision. Noise is required, because a filter without it would follow
/// the odometry without correction.
fn checked(kind: VehicleKind, geometry: AckermannGeometry<f64>, noise: ControlNoise<f64>) -> PyResult<Driven<f64>> {
    if noise.is_none() {
        return Err(SettingError::new_err("odometry without any noise: a sigma or a ratio must be above zero"));
    }
    let names =
        [("sensor_forward_m", "pose_forward_m"), ("sensor_left_m", "pose_left_m"), ("interval_s", "noise_interval_s")];
    let vehicle = Driven { kind, geometry, noise };
    cast::<f32>(&vehicle)?.drive().map_err(|error| of_model(error, &names))?;
    Ok(vehicle)
}

/// The keywords that all vehicles have.
fn of_noise(noise: &ControlNoise<f64>) -> Keywords {
    Keywords::default()
        .number("speed_sigma_mps", noise.speed_sigma_mps)
        .number("speed_sigma_ratio", noise.speed_sigma_ratio)
        .number("turn_sigma", noise.turn_sigma)
        .number("turn_sigma_ratio", noise.turn_sigma_ratio)
        .number("noise_interval_s", noise.interval_s)
}

/// A robot that turns in place, for example with a differential drive. Its control is the speed (m/s) and the turn rate (rad/s,
/// to the left).
///
/// The default noise is that of a wheeled vehicle whose noise was not measured.
///
/// Parameters
/// ----------
/// speed_sigma_mps : float
///     Standard deviation of the speed, m/s.
/// speed_sigma_ratio : float
///     Standard deviation as a fraction of the speed; added in quadrature.
/// turn_sigma : float
///     Standard deviation of the turn rate, rad/s.
/// turn_sigma_ratio : float
///     Standard deviation as a fraction of the turn rate; added in quadrature.
/// noise_interval_s : float
///     Correlation time of the noise, s; 0: independent noise in every prediction.
/// step : str
///     'arc': motion on the exact arc. 'euler': straight ahead, then the turn.
#[pyclass(frozen, module = "scphd")]
pub struct Unicycle(Driven<f64>);

#[pymethods]
impl Unicycle {
    #[new]
    #[pyo3(signature = (*, speed_sigma_mps=0.02, speed_sigma_ratio=0.1, turn_sigma=0.02, turn_sigma_ratio=0.1,
                        noise_interval_s=0.5, step="arc"))]
    fn new(
        speed_sigma_mps: f64,
        speed_sigma_ratio: f64,
        turn_sigma: f64,
        turn_sigma_ratio: f64,
        noise_interval_s: f64,
        step: &str,
    ) -> PyResult<Self> {
        let kind = match step {
            "arc" => VehicleKind::Unicycle,
            "euler" => VehicleKind::UnicycleEuler,
            other => return Err(SettingError::new_err(format!("step must be 'arc' or 'euler', not '{other}'"))),
        };
        let noise = ControlNoise {
            speed_sigma_mps,
            speed_sigma_ratio,
            turn_sigma,
            turn_sigma_ratio,
            interval_s: noise_interval_s,
        };
        checked(kind, NO_LENGTHS, noise).map(Self)
    }
}

/// A car. Its control is the speed of the wheel with the encoder (m/s) and the steering angle (rad, to the left).
///
/// Parameters
/// ----------
/// wheelbase_m : float
///     Wheelbase, m.
/// encoder_offset_m : float
///     Distance of the wheel with the encoder from the centreline, to the left, m.
/// pose_forward_m, pose_left_m : float
///     Position of the pose ahead of the rear axle and left of the centreline, m.
/// speed_sigma_mps : float
///     Standard deviation of the speed, m/s.
/// speed_sigma_ratio : float
///     Standard deviation as a fraction of the speed; added in quadrature.
/// turn_sigma : float
///     Standard deviation of the steering angle, rad.
/// turn_sigma_ratio : float
///     Standard deviation as a fraction of the steering angle; added in quadrature.
/// noise_interval_s : float
///     Correlation time of the noise, s; 0: independent noise in every prediction.
#[pyclass(frozen, module = "scphd")]
pub struct Ackermann(Driven<f64>);

#[pymethods]
impl Ackermann {
    #[new]
    #[pyo3(signature = (*, wheelbase_m, encoder_offset_m=0.0, pose_forward_m=0.0, pose_left_m=0.0, speed_sigma_mps=0.02,
                        speed_sigma_ratio=0.1, turn_sigma=0.02, turn_sigma_ratio=0.1, noise_interval_s=0.5))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn new(
        wheelbase_m: f64,
        encoder_offset_m: f64,
        pose_forward_m: f64,
        pose_left_m: f64,
        speed_sigma_mps: f64,
        speed_sigma_ratio: f64,
        turn_sigma: f64,
        turn_sigma_ratio: f64,
        noise_interval_s: f64,
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
        checked(VehicleKind::Ackermann, geometry, noise).map(Self)
    }
}

/// A vehicle that can also move sideways, with mecanum wheels or legs. Its control is the speed ahead and to the left (m/s) and
/// the turn rate (rad/s, to the left).
///
/// Parameters
/// ----------
/// speed_sigma_mps : float
///     Standard deviation of the speed, m/s, the same along both axes.
/// speed_sigma_ratio : float
///     Standard deviation as a fraction of the speed over ground; added in quadrature.
/// turn_sigma : float
///     Standard deviation of the turn rate, rad/s.
/// turn_sigma_ratio : float
///     Standard deviation as a fraction of the turn rate; added in quadrature.
/// noise_interval_s : float
///     Correlation time of the noise, s; 0: independent noise in every prediction.
#[pyclass(frozen, module = "scphd")]
pub struct Holonomic(Driven<f64>);

#[pymethods]
impl Holonomic {
    #[new]
    #[pyo3(signature = (*, speed_sigma_mps=0.02, speed_sigma_ratio=0.1, turn_sigma=0.02, turn_sigma_ratio=0.1,
                        noise_interval_s=0.5))]
    fn new(
        speed_sigma_mps: f64,
        speed_sigma_ratio: f64,
        turn_sigma: f64,
        turn_sigma_ratio: f64,
        noise_interval_s: f64,
    ) -> PyResult<Self> {
        let noise = ControlNoise {
            speed_sigma_mps,
            speed_sigma_ratio,
            turn_sigma,
            turn_sigma_ratio,
            interval_s: noise_interval_s,
        };
        checked(VehicleKind::Holonomic, NO_LENGTHS, noise).map(Self)
    }
}

/// A vehicle whose pose is known: its control is the pose (x m, y m, heading rad) at the end of the step. A `Filter` with one
/// particle is then a Gaussian-mixture PHD filter, for tracking from a known pose.
#[pyclass(frozen, module = "scphd")]
pub struct KnownPose;

#[pymethods]
impl KnownPose {
    #[new]
    fn new() -> Self {
        Self
    }
}

object! { Unicycle, |vehicle| {
    let step = if vehicle.kind == VehicleKind::UnicycleEuler { "euler" } else { "arc" };
    of_noise(&vehicle.noise).word("step", step)
} }
object! { Ackermann, |vehicle| of_noise(&vehicle.noise)
.number("wheelbase_m", vehicle.geometry.wheelbase_m)
.number("encoder_offset_m", vehicle.geometry.encoder_offset_m)
.number("pose_forward_m", vehicle.geometry.sensor_forward_m)
.number("pose_left_m", vehicle.geometry.sensor_left_m) }
object! { Holonomic, |vehicle| of_noise(&vehicle.noise) }

/// The vehicle of a Python object, if it moves by its odometry.
pub fn driven(object: &Bound<'_, PyAny>) -> Option<Driven<f64>> {
    let unicycle = object.cast::<Unicycle>().ok().map(|robot| robot.get().0);
    let ackermann = || object.cast::<Ackermann>().ok().map(|car| car.get().0);
    let holonomic = || object.cast::<Holonomic>().ok().map(|vehicle| vehicle.get().0);
    unicycle.or_else(ackermann).or_else(holonomic)
}

/// Converts an array to the control of a vehicle of this kind.
pub fn control<T: Number>(kind: VehicleKind, array: &Bound<'_, PyAny>) -> PyResult<scphd_vehicle::Control<T>> {
    let what = match kind {
        VehicleKind::Ackermann => "control (speed_mps, steering_rad)",
        VehicleKind::Unicycle | VehicleKind::UnicycleEuler => "control (speed_mps, turn_rate_radps)",
        VehicleKind::Holonomic => {
            let [speed_mps, left_mps, turn] = row("control (forward_mps, left_mps, turn_rate_radps)", array)?;
            return Ok(scphd_vehicle::Control { speed_mps, left_mps, turn });
        }
    };
    let [speed_mps, turn] = row(what, array)?;
    Ok(scphd_vehicle::Control { speed_mps, left_mps: T::ZERO, turn })
}

/// A vehicle of any kind.
#[derive(Debug, Clone, Copy)]
pub enum Vehicle {
    /// A vehicle that moves by its odometry.
    Driven(VehicleKind, PlanarMotion<f32>),
    /// A vehicle whose pose is known.
    Known(scphd::models::KnownPose<PlanarPose<f32>>),
}

/// The control of a vehicle of any kind.
#[derive(Debug, Clone, Copy)]
pub enum Control {
    /// Of a vehicle that moves by its odometry.
    Driven(PlanarControl<f32>),
    /// Of a vehicle whose pose is known.
    Known(PlanarPose<f32>),
}

impl Vehicle {
    /// Converts a Python object.
    pub fn of(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Some(vehicle) = driven(object) {
            let motion = cast(&vehicle)?.drive().map_err(|error| of_model(error, &[]))?;
            return Ok(Self::Driven(vehicle.kind, motion));
        }
        if object.cast::<KnownPose>().is_ok() {
            return Ok(Self::Known(scphd::models::KnownPose::new()));
        }
        Err(wrong_type("vehicle", "a Unicycle, an Ackermann, a Holonomic or a KnownPose", object))
    }

    /// Converts an array to a control of this vehicle.
    pub fn control(&self, array: &Bound<'_, PyAny>) -> PyResult<Control> {
        Ok(match self {
            Self::Driven(kind, _) => Control::Driven(kind.control(&control(*kind, array)?)),
            Self::Known(_) => {
                let [x_m, y_m, heading_rad] = row("control (x_m, y_m, heading_rad)", array)?;
                Control::Known(PlanarPose::new(x_m, y_m, heading_rad))
            }
        })
    }
}

/// Evaluates an expression with a vehicle and a control of the same kind; `$other` if the kinds differ.
macro_rules! each {
    ($vehicle:expr, $control:expr, |$motion:ident, $of_kind:ident| $done:expr, else $other:expr) => {
        match ($vehicle, $control) {
            (Self::Driven(_, $motion), Control::Driven($of_kind)) => $done,
            (Self::Known($motion), Control::Known($of_kind)) => $done,
            _ => $other,
        }
    };
}

impl Motion for Vehicle {
    type Pose = PlanarPose<f32>;
    type Control = Control;

    /// All kinds are invariant to translation. A known pose has no speed, so that none of its steps counts as short.
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
