//! Constructor arguments of a filter, for printing, copying and pickling it.

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyType};

/// A vehicle and keyword arguments.
pub struct Made {
    vehicle: Py<PyAny>,
    keywords: Py<PyDict>,
}

/// A function and its arguments, from which `copy` and `pickle` construct a filter.
pub type Parts<'py> = (Bound<'py, PyAny>, (Bound<'py, PyType>, Py<PyAny>, Py<PyDict>, Option<Bound<'py, PyBytes>>));

impl Made {
    /// This vehicle and a copy of these keyword arguments.
    pub fn of(vehicle: &Bound<'_, PyAny>, keywords: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let keywords = keywords.map_or_else(|| Ok(PyDict::new(vehicle.py())), |keywords| keywords.copy())?;
        Ok(Self { vehicle: vehicle.clone().unbind(), keywords: keywords.unbind() })
    }

    /// Adds a keyword argument.
    pub fn keep<'py>(&self, py: Python<'py>, name: &str, value: impl IntoPyObject<'py>) -> PyResult<()> {
        self.keywords.bind(py).set_item(name, value)
    }

    /// The constructor call as text.
    pub fn written(&self, py: Python<'_>, class: &str) -> PyResult<String> {
        let mut text = format!("{class}({}", self.vehicle.bind(py).repr()?);
        for (name, value) in self.keywords.bind(py) {
            text.push_str(&format!(", {name}={}", value.repr()?));
        }
        Ok(text + ")")
    }

    /// The parts from which `copy` and `pickle` construct a filter; its state is in the snapshot, if it was started.
    pub fn parts<'py>(&self, class: Bound<'py, PyType>, snapshot: Option<Bound<'py, PyBytes>>) -> PyResult<Parts<'py>> {
        let py = class.py();
        let resume = py.import("scphd._native")?.getattr("_resume")?;
        Ok((resume, (class, self.vehicle.clone_ref(py), self.keywords.clone_ref(py), snapshot)))
    }
}

/// Constructs a filter, and restores the snapshot.
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
