//! The pose of a sensor on its vehicle.

use crate::error::Refusal;
use crate::keywords::{Keywords, Printed, object};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;

/// The pose of a sensor on its vehicle, relative to the vehicle's pose.
///
/// Parameters
/// ----------
/// forward_m, left_m : float
///     Position ahead and to the left, m.
/// yaw_rad : float
///     Rotation to the left, rad.
#[pyclass(frozen, from_py_object, module = "scphd")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mounting(pub [f64; 3]);

impl Mounting {
    /// A sensor at the vehicle's pose.
    pub const NONE: Self = Self([0.0; 3]);
}

#[pymethods]
impl Mounting {
    #[new]
    #[pyo3(signature = (*, forward_m=0.0, left_m=0.0, yaw_rad=0.0))]
    fn new(forward_m: f64, left_m: f64, yaw_rad: f64) -> PyResult<Self> {
        let seat = [forward_m, left_m, yaw_rad];
        let [forward, left, yaw] = seat.map(|number| number as f32);
        scphd::models::Mounting::in_plane(forward, left, yaw).map_err(Refusal::raised)?;
        Ok(Self(seat))
    }
}

impl Printed for Mounting {
    fn in_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        (*self).into_bound_py_any(py)
    }

    fn text(&self) -> String {
        self.__repr__()
    }
}

object! { Mounting, |seat| Keywords::default()
.number("forward_m", seat[0])
.number("left_m", seat[1])
.number("yaw_rad", seat[2]) }
