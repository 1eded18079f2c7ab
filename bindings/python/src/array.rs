//! Conversion from and to NumPy arrays.

use crate::error::InputError;
use nalgebra::SVector;
use numpy::{AllowTypeChange, PyArray1, PyArrayLikeDyn, PyArrayMethods};
use pyo3::prelude::*;
use scphd::Real;
use scphd::numerics::{Symmetric, Vector};

/// The precision of a filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// f32.
    Single,
    /// f64.
    Double,
}

/// A scalar of NumPy and of a filter.
pub trait Number: Real + numpy::Element + for<'a, 'py> FromPyObject<'a, 'py> {
    /// Its precision.
    const PRECISION: Precision;
}

impl Number for f32 {
    const PRECISION: Precision = Precision::Single;
}

impl Number for f64 {
    const PRECISION: Precision = Precision::Double;
}

/// Numbers and shape of an object that NumPy can convert to an array.
fn numbers<T: Number>(what: &str, of: &Bound<'_, PyAny>) -> PyResult<(Vec<usize>, Vec<T>)> {
    let array: PyArrayLikeDyn<'_, T, AllowTypeChange> =
        of.extract().map_err(|error: PyErr| InputError::new_err(format!("{what}: no array of numbers: {error}")))?;
    let view = array.as_array();
    Ok((view.shape().to_vec(), view.iter().copied().collect()))
}

fn wrong_shape(what: &str, wanted: &str, found: &[usize]) -> PyErr {
    let found: Vec<String> = found.iter().map(ToString::to_string).collect();
    let comma = if found.len() == 1 { "," } else { "" };
    InputError::new_err(format!("{what} must have the shape {wanted}, not ({}{comma})", found.join(", ")))
}

/// A row of `N` numbers.
pub fn row<T: Number, const N: usize>(what: &str, of: &Bound<'_, PyAny>) -> PyResult<[T; N]> {
    let (shape, numbers) = numbers(what, of)?;
    match numbers.try_into() {
        Ok(row) if shape.len() == 1 => Ok(row),
        _ => Err(wrong_shape(what, &format!("({N},)"), &shape)),
    }
}

/// Any number of rows of `N` numbers each; an empty list has no rows.
pub fn rows<T: Number, const N: usize>(what: &str, of: &Bound<'_, PyAny>) -> PyResult<Vec<SVector<T, N>>> {
    let (shape, numbers) = numbers(what, of)?;
    match shape[..] {
        [0] => Ok(Vec::new()),
        [_, columns] if columns == N => Ok(numbers.as_chunks::<N>().0.iter().map(|row| (*row).into()).collect()),
        _ => Err(wrong_shape(what, &format!("(n, {N})"), &shape)),
    }
}

/// A list of numbers.
pub fn line<T: Number>(what: &str, of: &Bound<'_, PyAny>) -> PyResult<Vec<T>> {
    let (shape, numbers) = numbers(what, of)?;
    if shape.len() == 1 { Ok(numbers) } else { Err(wrong_shape(what, "(n,)", &shape)) }
}

/// A covariance, of shape (D, D).
pub fn covariance<V: Vector<Scalar: Number>>(what: &str, of: &Bound<'_, PyAny>) -> PyResult<Symmetric<V>> {
    let n = V::DIMENSION;
    let (shape, numbers) = numbers(what, of)?;
    let at = |row: usize, column: usize| numbers.get(row * n + column).copied();
    if shape != [n, n] {
        return Err(wrong_shape(what, &format!("({n}, {n})"), &shape));
    }
    let differ = |(one, other): (V::Scalar, V::Scalar)| {
        (one - other).abs() > V::Scalar::from_f64(1e-6) * (one.abs() + other.abs())
    };
    if (0..n).any(|row| (0..row).any(|column| at(row, column).zip(at(column, row)).is_none_or(differ))) {
        return Err(InputError::new_err(format!("{what} is not symmetric")));
    }
    Ok(Symmetric::from_fn(|row, column| at(row, column).unwrap_or_default()))
}

/// An array with this shape and the scalar type of this precision.
pub fn array<'py>(
    py: Python<'py>,
    precision: Precision,
    shape: &[usize],
    numbers: impl IntoIterator<Item = f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let numbers = numbers.into_iter();
    Ok(match precision {
        Precision::Single => PyArray1::from_iter(py, numbers.map(|number| number as f32)).reshape(shape)?.into_any(),
        Precision::Double => PyArray1::from_iter(py, numbers).reshape(shape)?.into_any(),
    })
}

/// A covariance in another precision.
pub fn cast<V: Vector, W: Vector>(of: &Symmetric<V>) -> Symmetric<W> {
    Symmetric::from_fn(|row, column| Real::from_f64(of.get(row, column).to_f64()))
}

/// The elements of a covariance, row after row.
pub fn elements<V: Vector>(of: &Symmetric<V>) -> impl Iterator<Item = f64> {
    let n = V::DIMENSION;
    (0..n * n).map(move |at| of.get(at / n, at % n).to_f64())
}
