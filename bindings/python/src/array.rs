//! Arrays of NumPy in and out.

use crate::error::InputError;
use nalgebra::SVector;
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLikeDyn, PyArrayMethods};
use pyo3::prelude::*;
use scphd::numerics::{Symmetric, Vector};

/// All numbers of what NumPy can make an array of, in single precision, with its shape.
fn numbers(what: &str, of: &Bound<'_, PyAny>) -> PyResult<(Vec<usize>, Vec<f32>)> {
    let array: PyArrayLikeDyn<'_, f32, AllowTypeChange> =
        of.extract().map_err(|error: PyErr| InputError::new_err(format!("{what}: no array of numbers: {error}")))?;
    let view = array.as_array();
    Ok((view.shape().to_vec(), view.iter().copied().collect()))
}

fn wrong_shape(what: &str, wanted: &str, found: &[usize]) -> PyErr {
    let found: Vec<String> = found.iter().map(ToString::to_string).collect();
    let comma = if found.len() == 1 { "," } else { "" };
    InputError::new_err(format!("{what} must have the shape {wanted}, not ({}{comma})", found.join(", ")))
}

/// One row of so many numbers.
pub fn row<const N: usize>(what: &str, of: &Bound<'_, PyAny>) -> PyResult<[f32; N]> {
    let (shape, numbers) = numbers(what, of)?;
    match numbers.try_into() {
        Ok(row) if shape.len() == 1 => Ok(row),
        _ => Err(wrong_shape(what, &format!("({N},)"), &shape)),
    }
}

/// Any number of rows of so many numbers; an empty list is none.
pub fn rows<const N: usize>(what: &str, of: &Bound<'_, PyAny>) -> PyResult<Vec<SVector<f32, N>>> {
    let (shape, numbers) = numbers(what, of)?;
    match shape[..] {
        [0] => Ok(Vec::new()),
        [_, columns] if columns == N => Ok(numbers.as_chunks::<N>().0.iter().map(|row| (*row).into()).collect()),
        _ => Err(wrong_shape(what, &format!("(n, {N})"), &shape)),
    }
}

/// A list of numbers.
pub fn line(what: &str, of: &Bound<'_, PyAny>) -> PyResult<Vec<SVector<f32, 1>>> {
    let (shape, numbers) = numbers(what, of)?;
    match shape[..] {
        [_] => Ok(numbers.into_iter().map(|number| [number].into()).collect()),
        _ => Err(wrong_shape(what, "(n,)", &shape)),
    }
}

/// The whole of a covariance, of shape (D, D).
pub fn square<'py, V: Vector<Scalar = f32>>(py: Python<'py>, of: &Symmetric<V>) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let n = V::DIMENSION;
    let elements = (0..n * n).map(|at| of.get(at / n, at % n));
    PyArray1::from_iter(py, elements).reshape([n, n])
}
