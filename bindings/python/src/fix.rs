//! Fixes: the pose itself is measured.

use crate::array::row;
use crate::error::{InputError, of_model, wrong_type};
use nalgebra::{Vector1, Vector2};
use pyo3::prelude::*;
use scphd::models::PlanarPose;

/// A receiver that measures the position (x, y m) of its antenna.
///
/// Parameters
/// ----------
/// sigma_m : float
///     Standard deviation along either axis, m.
/// gate : float, optional
///     Squared Mahalanobis distance beyond which a fix is an outlier; left out: none is.
/// antenna_forward_m, antenna_left_m : float
///     Where the antenna is, seen from the pose, m.
#[pyclass(frozen, module = "scphd")]
pub struct PositionFix(scphd::models::PositionFix<f32>);

#[pymethods]
impl PositionFix {
    #[new]
    #[pyo3(signature = (*, sigma_m, gate=None, antenna_forward_m=0.0, antenna_left_m=0.0))]
    fn new(sigma_m: f32, gate: Option<f32>, antenna_forward_m: f32, antenna_left_m: f32) -> PyResult<Self> {
        let fix = || {
            let fix = scphd::models::PositionFix::new(sigma_m)?.gated(gate.unwrap_or(f32::INFINITY))?;
            let at_the_pose = [antenna_forward_m, antenna_left_m] == [0.0; 2];
            if at_the_pose { Ok(fix) } else { fix.mounted(antenna_forward_m, antenna_left_m) }
        };
        let names = [("forward_m", "antenna_forward_m"), ("left_m", "antenna_left_m")];
        fix().map(Self).map_err(|error| of_model(error, &names))
    }
}

/// A compass: measures the heading, rad, from the x axis towards the y axis.
///
/// Parameters
/// ----------
/// sigma_rad : float
///     Standard deviation, rad.
/// gate : float, optional
///     As of a `PositionFix`.
#[pyclass(frozen, module = "scphd")]
pub struct HeadingFix(scphd::models::HeadingFix<PlanarPose<f32>>);

#[pymethods]
impl HeadingFix {
    #[new]
    #[pyo3(signature = (*, sigma_rad, gate=None))]
    fn new(sigma_rad: f32, gate: Option<f32>) -> PyResult<Self> {
        let fix = scphd::models::HeadingFix::new(sigma_rad).and_then(|fix| fix.gated(gate.unwrap_or(f32::INFINITY)));
        fix.map(Self).map_err(|error| of_model(error, &[]))
    }
}

/// A fix with what it has measured.
pub enum Measured {
    /// A position, m.
    Position(scphd::models::PositionFix<f32>, Vector2<f32>),
    /// A heading, rad.
    Heading(scphd::models::HeadingFix<PlanarPose<f32>>, Vector1<f32>),
}

impl Measured {
    /// What two objects of Python are.
    pub fn of(fix: &Bound<'_, PyAny>, measurement: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(position) = fix.cast::<PositionFix>() {
            let measured: [f32; 2] = row("measurement (x_m, y_m)", measurement)?;
            return Ok(Self::Position(position.get().0, measured.into()));
        }
        if let Ok(heading) = fix.cast::<HeadingFix>() {
            let measured: f32 = measurement
                .extract()
                .map_err(|_| InputError::new_err("measurement of a heading must be a number, rad"))?;
            return Ok(Self::Heading(heading.get().0, [measured].into()));
        }
        Err(wrong_type("fix", "a PositionFix or a HeadingFix", fix))
    }
}
