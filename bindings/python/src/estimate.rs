//! Estimates, as NumPy arrays.

use crate::array::{Number, Precision, array, cast, covariance, elements, line, rows};
use crate::error::InputError;
use nalgebra::{Vector2, Vector3, Vector4};
use numpy::PyArray1;
use pyo3::prelude::*;
use scphd::models::{OdometryCorrection, PlanarPose};
use scphd::numerics::{Symmetric, Vector};
use scphd::{Component, MapEstimate, PoseEstimate, Real};

/// The estimated pose and its covariance.
#[pyclass(frozen, module = "scphd")]
pub struct Pose {
    precision: Precision,
    mean: [f64; 3],
    covariance: Symmetric<Vector3<f64>>,
}

impl<T: Number> From<PoseEstimate<PlanarPose<T>>> for Pose {
    fn from(estimate: PoseEstimate<PlanarPose<T>>) -> Self {
        let PlanarPose { x_m, y_m, heading_rad } = estimate.mean;
        let mean = [x_m, y_m, heading_rad].map(Real::to_f64);
        Self { precision: T::PRECISION, mean, covariance: cast(&estimate.covariance) }
    }
}

#[pymethods]
impl Pose {
    /// float: x, m.
    #[getter]
    fn x_m(&self) -> f64 {
        self.mean[0]
    }

    /// float: y, m.
    #[getter]
    fn y_m(&self) -> f64 {
        self.mean[1]
    }

    /// float: heading from the x axis towards the y axis, rad.
    #[getter]
    fn heading_rad(&self) -> f64 {
        self.mean[2]
    }

    /// numpy.ndarray, shape (3,): x m, y m, heading rad.
    #[getter]
    fn mean<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.precision, &[3], self.mean)
    }

    /// numpy.ndarray, shape (3, 3): covariance of (x m, y m, heading rad).
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.precision, &[3, 3], elements(&self.covariance))
    }

    fn __repr__(&self) -> String {
        let [x_m, y_m, heading_rad] = self.mean;
        format!("Pose(x_m={x_m}, y_m={y_m}, heading_rad={heading_rad})")
    }
}

/// The estimated odometry error: the controls are multiplied by 1 + scale, and the offset is added to the turn rate or steering
/// angle.
#[pyclass(frozen, module = "scphd", get_all)]
pub struct Odometry {
    /// float: relative correction of the speed, as for worn wheels.
    speed_scale: f64,
    /// float: relative correction of the turn rate or steering angle.
    turn_scale: f64,
    /// float: offset of the turn rate, rad/s, or of the steering angle, rad, such as the bias of a gyroscope.
    turn_offset: f64,
}

impl<T: Real> From<OdometryCorrection<T>> for Odometry {
    fn from(of: OdometryCorrection<T>) -> Self {
        let [speed_scale, turn_scale, turn_offset] = [of.speed_scale, of.turn_scale, of.turn_offset].map(Real::to_f64);
        Self { speed_scale, turn_scale, turn_offset }
    }
}

#[pymethods]
impl Odometry {
    fn __repr__(&self) -> String {
        let Self { speed_scale, turn_scale, turn_offset } = self;
        format!("Odometry(speed_scale={speed_scale}, turn_scale={turn_scale}, turn_offset={turn_offset})")
    }
}

/// A feature in double precision.
struct Feature<const N: usize> {
    label: u32,
    ln_weight: f64,
    mean: [f64; N],
    covariance: [[f64; N]; N],
}

/// Features, and the precision of their filter.
struct Features<const N: usize> {
    precision: Precision,
    features: Vec<Feature<N>>,
    weights: Vec<f64>,
    expected: f64,
}

impl<const N: usize> Features<N> {
    /// Features of an estimate, and their expected number.
    fn of<T: Number, V: Vector<Scalar = T> + Into<[T; N]>>((features, expected): (Vec<Component<V>>, T)) -> Self {
        let weights = features.iter().map(|feature| feature.ln_weight.exp().to_f64()).collect();
        let features = features.into_iter().map(|feature| {
            let at = |row, column| feature.covariance.get(row, column).to_f64();
            let covariance = std::array::from_fn(|row| std::array::from_fn(|column| at(row, column)));
            let (label, ln_weight) = (feature.label, feature.ln_weight.to_f64());
            Feature { label, ln_weight, mean: feature.mean.into().map(Real::to_f64), covariance }
        });
        Self { precision: T::PRECISION, features: features.collect(), weights, expected: expected.to_f64() }
    }

    /// An array of numbers of each feature, each of this shape.
    fn each<'py, I: IntoIterator<Item = f64>>(
        &self,
        py: Python<'py>,
        shape: &[usize],
        numbers: impl Fn(&Feature<N>) -> I,
    ) -> PyResult<Bound<'py, PyAny>> {
        let shape = [&[self.features.len()], shape].concat();
        array(py, self.precision, &shape, self.features.iter().flat_map(numbers))
    }
}

/// A map of n static features: an estimate, or the map of an earlier drive.
///
/// Parameters
/// ----------
/// positions_m : array_like, shape (n, 2)
///     Positions x and y, m.
/// covariances : array_like, shape (n, 2, 2)
///     Covariances of the positions, m^2.
/// weights : array_like, shape (n,), optional
///     Existence probabilities; by default 1.
/// labels : array_like of int, shape (n,), optional
///     By default 1, 2, ...
#[pyclass(frozen, module = "scphd")]
pub struct Map(Features<2>);

/// The n estimated moving features, at their present positions.
#[pyclass(frozen, module = "scphd")]
pub struct Movers(Features<4>);

/// Calls the estimate with enough memory for all components.
pub fn all<V: Vector>(
    estimate: impl FnMut(&mut [Component<V>]) -> MapEstimate<V::Scalar>,
) -> (Vec<Component<V>>, V::Scalar) {
    let mut estimate = estimate;
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
    /// Features of an estimate, and their expected number.
    pub fn of<T: Number>(estimate: (Vec<Component<Vector2<T>>>, T)) -> Self {
        Self(Features::of(estimate))
    }

    /// The features, in the precision of a filter.
    pub fn components<T: Number>(&self) -> Vec<Component<Vector2<T>>> {
        let of = |feature: &Feature<2>| {
            let covariance = Symmetric::from_fn(|row, column| T::from_f64(feature.covariance[row][column]));
            let (ln_weight, mean) = (T::from_f64(feature.ln_weight), feature.mean.map(T::from_f64).into());
            Component { label: feature.label, ln_weight, mean, covariance }
        };
        self.0.features.iter().map(of).collect()
    }
}

impl Movers {
    /// Features of an estimate, and their expected number.
    pub fn of<T: Number>(estimate: (Vec<Component<Vector4<T>>>, T)) -> Self {
        Self(Features::of(estimate))
    }
}

/// The methods that `Map` and `Movers` have in common.
macro_rules! features {
    ($($name:ident, $dimension:literal, $of_all:literal { $($more:tt)* })+) => { $(
        #[pymethods]
        impl $name {
            /// numpy.ndarray of uint32, shape (n,): identifies each feature from scan to scan.
            #[getter]
            fn labels<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
                PyArray1::from_iter(py, self.0.features.iter().map(|feature| feature.label))
            }

            /// numpy.ndarray, shape (n,): expected number of features that each component represents; in a joint map its
            /// existence probability.
            #[getter]
            fn weights<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                array(py, self.0.precision, &[self.0.weights.len()], self.0.weights.iter().copied())
            }

            /// numpy.ndarray, shape (n, 2): positions x and y, m.
            #[getter]
            fn positions_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                self.0.each(py, &[2], |&Feature { mean: [x, y, ..], .. }| [x, y])
            }

            #[doc = $of_all]
            #[getter]
            fn covariances<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                self.0.each(py, &[$dimension; 2], |feature| feature.covariance.into_iter().flatten())
            }

            /// float: the expected number of features.
            #[getter]
            fn expected_features(&self) -> f64 {
                self.0.expected
            }

            fn __len__(&self) -> usize {
                self.0.features.len()
            }

            fn __repr__(&self) -> String {
                format!("{}({} features)", stringify!($name), self.0.features.len())
            }

            $($more)*
        }
    )+ };
}

features! {
    Map, 2, "numpy.ndarray, shape (n, 2, 2): covariances of (x, y), m^2." {
        #[new]
        #[pyo3(signature = (positions_m, covariances, weights=None, labels=None))]
        fn new(
            positions_m: &Bound<'_, PyAny>,
            covariances: &Bound<'_, PyAny>,
            weights: Option<&Bound<'_, PyAny>>,
            labels: Option<Vec<u32>>,
        ) -> PyResult<Self> {
            let means = rows::<f64, 2>("positions_m", positions_m)?;
            let spread: Vec<Bound<'_, PyAny>> = covariances.try_iter()?.collect::<PyResult<_>>()?;
            let weights = weights.map_or_else(|| Ok(vec![1.0; means.len()]), |weights| line("weights", weights))?;
            let labels = labels.unwrap_or_else(|| (1..).take(means.len()).collect());
            if [spread.len(), weights.len(), labels.len()] != [means.len(); 3] {
                return Err(InputError::new_err("positions_m, covariances, weights and labels are not of one length"));
            }
            let mut features = Vec::new();
            for (((mean, spread), weight), label) in means.into_iter().zip(&spread).zip(&weights).zip(labels) {
                let spread: Symmetric<Vector2<f64>> = covariance("covariances", spread)?;
                let covariance = std::array::from_fn(|row| std::array::from_fn(|column| spread.get(row, column)));
                features.push(Feature { label, ln_weight: Real::ln(*weight), mean: mean.into(), covariance });
            }
            let expected = weights.iter().sum();
            Ok(Self(Features { precision: Precision::Double, features, weights, expected }))
        }

        fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, MapParts<'py>)> {
            let (map, py) = (slf.get(), slf.py());
            let parts = (map.positions_m(py)?, map.covariances(py)?, map.weights(py)?, slf.getattr("labels")?);
            Ok((slf.get_type().into_any(), parts))
        }
    }
    Movers, 4, "numpy.ndarray, shape (n, 4, 4): covariances of (x m, y m, vx m/s, vy m/s)." {
        /// numpy.ndarray, shape (n, 2): velocities along x and y, m/s.
        #[getter]
        fn velocities_mps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
            self.0.each(py, &[2], |&Feature { mean: [.., x, y], .. }| [x, y])
        }
    }
}

/// Arguments of the constructor of a map.
type MapParts<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);
