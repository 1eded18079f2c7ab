//! Where a sensor sits.

use crate::error::Refusal;
use pyo3::prelude::*;

/// Where a sensor sits on its vehicle, seen from where the pose is, and how it is turned.
///
/// Parameters
/// ----------
/// forward_m, left_m : float
///     Ahead and to the left, m.
/// yaw_rad : float
///     Turned to the left, rad.
#[pyclass(frozen, module = "scphd")]
pub struct Mounting {
    seat: scphd::models::Mounting<f32>,
    is_none: bool,
}

#[pymethods]
impl Mounting {
    #[new]
    #[pyo3(signature = (*, forward_m=0.0, left_m=0.0, yaw_rad=0.0))]
    fn new(forward_m: f32, left_m: f32, yaw_rad: f32) -> PyResult<Self> {
        let seat = scphd::models::Mounting::in_plane(forward_m, left_m, yaw_rad).map_err(Refusal::raised)?;
        Ok(Self { seat, is_none: [forward_m, left_m, yaw_rad] == [0.0; 3] })
    }
}

impl Mounting {
    /// `None` where the sensor's pose is the vehicle's, which spares the filter some work.
    pub fn seat(&self) -> Option<scphd::models::Mounting<f32>> {
        (!self.is_none).then_some(self.seat)
    }
}
