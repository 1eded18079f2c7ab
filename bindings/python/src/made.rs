//! What a filter was made of, so that it can be printed, copied and pickled.

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyType};

/// A vehicle and keywords.
pub struct Made {
    vehicle: Py<PyAny>,
    keywords: Py<PyDict>,
}

/// What a copy is made of: a function, its arguments.
pub type Parts<'py> = (Bound<'py, PyAny>, (Bound<'py, PyType>, Py<PyAny>, Py<PyDict>, Option<Bound<'py, PyBytes>>));

impl Made {
    /// This vehicle and a copy of these keywords.
    pub fn of(vehicle: &Bound<'_, PyAny>, keywords: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let keywords = keywords.map_or_else(|| Ok(PyDict::new(vehicle.py())), |keywords| keywords.copy())?;
        Ok(Self { vehicle: vehicle.clone().unbind(), keywords: keywords.unbind() })
    }

    /// One more keyword.
    pub fn keep<'py>(&self, py: Python<'py>, name: &str, value: impl IntoPyObject<'py>) -> PyResult<()> {
        self.keywords.bind(py).set_item(name, value)
    }

    /// As it is written.
    pub fn written(&self, py: Python<'_>, class: &str) -> PyResult<String> {
        let mut text = format!("{class}({}", self.vehicle.bind(py).repr()?);
        for (name, value) in self.keywords.bind(py) {
            text.push_str(&format!(", {name}={}", value.repr()?));
        }
        Ok(text + ")")
    }

    /// What `copy` and `pickle` make a filter anew from: the state is that of the snapshot, if it was started.
    pub fn parts<'py>(&self, class: Bound<'py, PyType>, snapshot: Option<Bound<'py, PyBytes>>) -> PyResult<Parts<'py>> {
        let py = class.py();
        let resume = py.import("scphd._native")?.getattr("_resume")?;
        Ok((resume, (class, self.vehicle.clone_ref(py), self.keywords.clone_ref(py), snapshot)))
    }
}

/// Makes a filter anew, and has it go on from a snapshot.
#[pyfunction]
pub fn _resume<'py>(
    class: &Bound<'py, PyType>,
    vehicle: &Bound<'py, PyAny>,
    keywords: &Bound<'py, PyDict>,
    snapshot: Option<&Bound<'py, PyBytes>>,
) -> PyResult<Bound<'py, PyAny>> {
    let filter = class.call((vehicle,), Some(keywords))?;
    if let Some(snapshot) = snapshot {
        filter.call_method1("restore", (snapshot,))?;
    }
    Ok(filter)
}
