//! Estimates, as arrays.

use crate::array::square;
use nalgebra::{Vector2, Vector4};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use scphd::models::PlanarPose;
use scphd::numerics::Vector;
use scphd::{Component, MapEstimate, PoseEstimate, Real};

/// Where the vehicle is, and how well that is known.
#[pyclass(frozen, module = "scphd")]
pub struct Pose(PoseEstimate<PlanarPose<f32>>);

impl From<PoseEstimate<PlanarPose<f32>>> for Pose {
    fn from(estimate: PoseEstimate<PlanarPose<f32>>) -> Self {
        Self(estimate)
    }
}

#[pymethods]
impl Pose {
    /// float: x, m.
    #[getter]
    fn x_m(&self) -> f32 {
        self.0.mean.x_m
    }

    /// float: y, m.
    #[getter]
    fn y_m(&self) -> f32 {
        self.0.mean.y_m
    }

    /// float: from the x axis towards the y axis, rad.
    #[getter]
    fn heading_rad(&self) -> f32 {
        self.0.mean.heading_rad
    }

    /// numpy.ndarray of float32, shape (3,): x m, y m, heading rad.
    #[getter]
    fn mean<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        let PlanarPose { x_m, y_m, heading_rad } = self.0.mean;
        PyArray1::from_slice(py, &[x_m, y_m, heading_rad])
    }

    /// numpy.ndarray of float32, shape (3, 3): covariance of (x m, y m, heading rad).
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        square(py, &self.0.covariance)
    }

    fn __repr__(&self) -> String {
        let PlanarPose { x_m, y_m, heading_rad } = self.0.mean;
        format!("Pose(x_m={x_m}, y_m={y_m}, heading_rad={heading_rad})")
    }
}

/// The estimated features that stand still: n of them.
#[pyclass(frozen, module = "scphd")]
pub struct Map(Vec<Component<Vector2<f32>>>, f32);

/// The estimated features that move: n of them, where they are by now.
#[pyclass(frozen, module = "scphd")]
pub struct Movers(Vec<Component<Vector4<f32>>>, f32);

/// Has the library write all components that there are.
pub fn all<V: Vector<Scalar = f32>>(
    estimate: impl Fn(&mut [Component<V>]) -> MapEstimate<f32>,
) -> (Vec<Component<V>>, f32) {
    let mut room = vec![Component::ZERO; 64];
    let mut told = estimate(&mut room);
    if told.left_out > 0 {
        room = vec![Component::ZERO; told.features + told.left_out];
        told = estimate(&mut room);
    }
    room.truncate(told.features);
    (room, told.expected_features)
}

impl Map {
    /// What was estimated, and the expected number of features.
    pub fn of((features, expected): (Vec<Component<Vector2<f32>>>, f32)) -> Self {
        Self(features, expected)
    }
}

impl Movers {
    /// What was estimated, and the expected number of features.
    pub fn of((features, expected): (Vec<Component<Vector4<f32>>>, f32)) -> Self {
        Self(features, expected)
    }
}

/// What both have in common.
macro_rules! features {
    ($($name:ident, $dimension:literal, $of_all:literal { $($more:tt)* })+) => { $(
        #[pymethods]
        impl $name {
            /// numpy.ndarray of uint32, shape (n,): names each feature from scan to scan.
            #[getter]
            fn labels<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
                PyArray1::from_iter(py, self.0.iter().map(|feature| feature.label))
            }

            /// numpy.ndarray of float32, shape (n,): how many features each stands for; of a joint map the probability that it is there.
            #[getter]
            fn weights<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
                PyArray1::from_iter(py, self.0.iter().map(|feature| Real::exp(feature.ln_weight)))
            }

            /// numpy.ndarray of float32, shape (n, 2): x and y, m.
            #[getter]
            fn positions_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
                let numbers = self.0.iter().flat_map(|feature| [feature.mean.x, feature.mean.y]);
                PyArray1::from_iter(py, numbers).reshape([self.0.len(), 2])
            }

            #[doc = $of_all]
            #[getter]
            fn covariances<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
                let places = || (0..$dimension * $dimension).map(|at| (at / $dimension, at % $dimension));
                let of_each = self.0.iter().map(|feature| &feature.covariance);
                let numbers = of_each.flat_map(|covariance| places().map(|(row, column)| covariance.get(row, column)));
                PyArray1::from_iter(py, numbers).reshape([self.0.len(), $dimension, $dimension])
            }

            $($more)*

            /// float: the expected number of features.
            #[getter]
            fn expected_features(&self) -> f32 {
                self.1
            }

            fn __len__(&self) -> usize {
                self.0.len()
            }

            fn __repr__(&self) -> String {
                format!("{}({} features)", stringify!($name), self.0.len())
            }
        }
    )+ };
}

features! {
    Map, 2, "numpy.ndarray of float32, shape (n, 2, 2): covariances of (x, y), m^2." {}
    Movers, 4, "numpy.ndarray of float32, shape (n, 4, 4): covariances of (x m, y m, vx m/s, vy m/s)." {
        /// numpy.ndarray of float32, shape (n, 2): along x and y, m/s.
        #[getter]
        fn velocities_mps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
            let numbers = self.0.iter().flat_map(|feature| [feature.mean.z, feature.mean.w]);
            PyArray1::from_iter(py, numbers).reshape([self.0.len(), 2])
        }
    }
}
