//! Fixes: measurements of the pose.

use crate::array::{Number, row};
use crate::error::{InputError, SettingError, of_model, wrong_type};
use crate::keywords::{Keywords, object};
use crate::tuning;
use nalgebra::Vector2;
use pyo3::prelude::*;
use scphd::Real;
use scphd::fixes::FixRule;
use scphd::models::{HeadingFix as Compass, ModelError, PlanarPose, PositionFix as Receiver};
use scphd_vehicle::{Description, FixSpec};

/// A position fix: the position (x, y m) of an antenna, for example of a GNSS receiver.
///
/// Parameters
/// ----------
/// sigma_m : float
///     Standard deviation along each axis, m.
/// gate : float, optional
///     Squared Mahalanobis distance beyond which a fix is an outlier; by default there is no gate.
/// antenna_forward_m, antenna_left_m : float
///     Position of the antenna relative to the pose, m.
/// watch_patience_s : float, optional
///     For a JointFilter: minimum time since the first rejected fix, s. If all fixes are rejected for this time and agree with
///     each other, the filter has diverged, and is moved to them. By default it never is.
/// watch_fewest : int
///     Minimum number of fixes rejected in a row before the filter is moved.
#[pyclass(frozen, module = "scphd")]
pub struct PositionFix(FixSpec<f64>);

/// A heading fix, for example of a compass: the heading, rad, from the x axis towards the y axis.
///
/// Parameters
/// ----------
/// sigma_rad : float
///     Standard deviation, rad.
/// gate, watch_patience_s, watch_fewest
///     As for `PositionFix`.
#[pyclass(frozen, module = "scphd")]
pub struct HeadingFix(FixSpec<f64>);

/// The rule by which rejected fixes show that the filter has diverged.
fn watch(patience_s: Option<f64>, fewest: u16) -> PyResult<Option<FixRule<f64>>> {
    let Some(patience_s) = patience_s else { return Ok(None) };
    if patience_s.is_nan() || patience_s < 0.0 {
        return Err(SettingError::new_err("watch_patience_s must be at least 0, or infinite"));
    }
    if !(3..=1000).contains(&fewest) {
        return Err(SettingError::new_err("watch_fewest must be between 3 and 1000"));
    }
    Ok(Some(FixRule { patience_s, fewest }))
}

/// A description of fixes in the precision of a filter.
fn cast<T: Real>(spec: &FixSpec<f64>) -> PyResult<FixSpec<T>> {
    let description = tuning::cast(&Description { position: Some(*spec), ..Description::robot() })?;
    description.position.ok_or_else(|| InputError::new_err("no fix"))
}

/// The model of position fixes.
fn receiver(spec: &FixSpec<f32>) -> Result<Receiver<f32>, ModelError> {
    let [forward_m, left_m] = spec.antenna_m;
    let fix = Receiver::new(spec.sigma)?.gated(spec.gate)?;
    if spec.antenna_m == [0.0; 2] { Ok(fix) } else { fix.mounted(forward_m, left_m) }
}

/// The model of heading fixes.
fn compass(spec: &FixSpec<f32>) -> Result<Compass<PlanarPose<f32>>, ModelError> {
    Compass::new(spec.sigma).and_then(|fix| fix.gated(spec.gate))
}

/// Converts an error of a model, with the parameter's name in Python.
fn named(error: ModelError) -> PyErr {
    of_model(error, &[("forward_m", "antenna_forward_m"), ("left_m", "antenna_left_m")])
}

#[pymethods]
impl PositionFix {
    #[new]
    #[pyo3(signature = (*, sigma_m, gate=None, antenna_forward_m=0.0, antenna_left_m=0.0, watch_patience_s=None, watch_fewest=5))]
    fn new(
        sigma_m: f64,
        gate: Option<f64>,
        antenna_forward_m: f64,
        antenna_left_m: f64,
        watch_patience_s: Option<f64>,
        watch_fewest: u16,
    ) -> PyResult<Self> {
        let antenna_m = [antenna_forward_m, antenna_left_m];
        let watch = watch(watch_patience_s, watch_fewest)?;
        let spec = FixSpec { sigma: sigma_m, antenna_m, gate: gate.unwrap_or(f64::INFINITY), watch };
        receiver(&cast(&spec)?).map_err(named)?;
        Ok(Self(spec))
    }
}

#[pymethods]
impl HeadingFix {
    #[new]
    #[pyo3(signature = (*, sigma_rad, gate=None, watch_patience_s=None, watch_fewest=5))]
    fn new(sigma_rad: f64, gate: Option<f64>, watch_patience_s: Option<f64>, watch_fewest: u16) -> PyResult<Self> {
        let watch = watch(watch_patience_s, watch_fewest)?;
        let spec = FixSpec { sigma: sigma_rad, antenna_m: [0.0; 2], gate: gate.unwrap_or(f64::INFINITY), watch };
        compass(&cast(&spec)?).map_err(named)?;
        Ok(Self(spec))
    }
}

/// The keywords of the gate and of the rule for rejected fixes.
fn of_rule(keywords: Keywords, spec: &FixSpec<f64>) -> Keywords {
    let keywords = if spec.gate.is_finite() { keywords.number("gate", spec.gate) } else { keywords };
    match spec.watch {
        Some(rule) => keywords.number("watch_patience_s", rule.patience_s).count("watch_fewest", rule.fewest),
        None => keywords,
    }
}

object! { PositionFix, |spec| {
    let [forward_m, left_m] = spec.antenna_m;
    let keywords = Keywords::default().number("sigma_m", spec.sigma);
    of_rule(keywords.number("antenna_forward_m", forward_m).number("antenna_left_m", left_m), spec)
} }
object! { HeadingFix, |spec| of_rule(Keywords::default().number("sigma_rad", spec.sigma), spec) }

/// A fix: description and measurement.
pub enum Measured<T> {
    /// A position, m.
    Position(FixSpec<T>, Vector2<T>),
    /// A heading, rad.
    Heading(FixSpec<T>, T),
}

impl<T: Number> Measured<T> {
    /// Converts two Python objects.
    pub fn of(fix: &Bound<'_, PyAny>, measurement: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(position) = fix.cast::<PositionFix>() {
            let measured: [T; 2] = row("measurement (x_m, y_m)", measurement)?;
            return Ok(Self::Position(cast(&position.get().0)?, measured.into()));
        }
        if let Ok(heading) = fix.cast::<HeadingFix>() {
            let measured: f64 = measurement
                .extract()
                .map_err(|_| InputError::new_err("measurement of a heading must be a number, rad"))?;
            return Ok(Self::Heading(cast(&heading.get().0)?, T::from_f64(measured)));
        }
        Err(wrong_type("fix", "a PositionFix or a HeadingFix", fix))
    }
}

/// The model of a fix for `Filter`.
pub enum Single {
    /// Of positions.
    Position(Receiver<f32>),
    /// Of headings.
    Heading(Compass<PlanarPose<f32>>),
}

impl Measured<f32> {
    /// The model; an error for fixes with `watch_patience_s`.
    pub fn model(&self) -> PyResult<Single> {
        let (Self::Position(spec, _) | Self::Heading(spec, _)) = self;
        if spec.watch.is_some() {
            return Err(SettingError::new_err("watch_patience_s is of a JointFilter alone"));
        }
        match self {
            Self::Position(spec, _) => receiver(spec).map(Single::Position).map_err(named),
            Self::Heading(spec, _) => compass(spec).map(Single::Heading).map_err(named),
        }
    }
}
