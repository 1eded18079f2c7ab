//! The sensor model, as a trait.

use super::ModelError;
use crate::{Component, Linear, Pose, PositionOf, ScalarOf, Symmetric, TangentOf, Vector};

/// The sensor model: measurement of a feature h(m, x), its inverse, and their noise (sections 5.1, 5.2.1).
///
/// The pose `x` is that of the sensor. If the sensor has a [mounting](crate::Mounting), the library computes the sensor's pose from
/// that of the vehicle, and the derivatives with respect to the vehicle's pose.
///
/// An implementation must be a pure function of its arguments, and take its transcendental functions from [`Real`](crate::Real).
/// Several cores may call it at the same time.
pub trait Sensor: Sync {
    /// The pose of the sensor.
    type Pose: Pose;
    /// A measurement of a feature.
    type Measurement: Vector<Scalar = ScalarOf<Self::Pose>>;
    /// Data that is computed once per pose instead of once per feature, for example the sine and cosine of the heading.
    type Frame;

    /// Index of the coordinate by which measurements are sorted, so that a feature is compared only with measurements near it.
    /// Choose the coordinate that separates features best.
    const SORTED_BY: usize;
    /// Whether that coordinate is an angle that wraps at ±π.
    const SORTED_BY_ANGLE: bool;
    /// Another coordinate whose innovation is z − ẑ, without wrapping. Among measurements that are near in
    /// the sorted coordinate, it excludes most of those that are not near in all coordinates, at the cost of one subtraction.
    /// `None` if there is no such coordinate.
    const SIFTED_BY: Option<usize> = None;

    /// Checks the parameters of the model. [`Detector::new`](crate::Detector::new) and
    /// [`Detector::retune`](crate::Detector::retune) call it.
    ///
    /// # Errors
    /// Names the first parameter out of range, and its range. No errors by default.
    fn check(&self) -> Result<(), ModelError> {
        Ok(())
    }

    /// The frame of a pose.
    fn frame(&self, pose: &Self::Pose) -> Self::Frame;

    /// Predicted measurement ẑ = h(m, x) of a feature at `feature`, with H = ∂h/∂m; `None` if the feature cannot be measured from
    /// this pose.
    fn expect(&self, frame: &Self::Frame, feature: &PositionOf<Self::Pose>) -> Option<ExpectedOf<Self>>;

    /// z ⊖ ẑ: the difference of two measurements, angles wrapped.
    fn innovation(&self, measured: &Self::Measurement, expected: &Self::Measurement) -> Self::Measurement;

    /// Whether an object at `measured` is in front of a feature with the predicted measurement `expected` and may occlude it.
    /// `false` by default.
    fn occludes(&self, _measured: &Self::Measurement, _expected: &Self::Measurement) -> bool {
        false
    }

    /// R, the covariance of the measurement noise.
    fn noise(&self) -> &Symmetric<Self::Measurement>;

    /// R of one measurement, if it is not the same for all measurements: for the measurement `measured` of a feature whose
    /// predicted measurement is `expected`. Noise that depends on the range should use `expected`, because `measured` contains the
    /// noise; a covariance that a driver reports belongs to `measured`. Both are the same when a feature is initiated and when
    /// there is no measurement.
    ///
    /// None by default: R is [`noise`](Self::noise). [`WithNoise`](crate::models::WithNoise) adds this to a sensor.
    fn noise_of(
        &self,
        _measured: &Self::Measurement,
        _expected: &Self::Measurement,
    ) -> Option<Symmetric<Self::Measurement>> {
        None
    }

    /// The birth intensity that does not depend on the measurements (5.2.1), for a sensor whose measurement has no inverse: its
    /// component with this index, in map coordinates, for this frame; `None` behind the last. These components are added to every
    /// predicted static map without being stored. Their number must be the same for every frame, and at most `VIEW` of the static
    /// maps. None by default: features are then born from measurements.
    fn expected_birth(&self, _frame: &Self::Frame, _index: usize) -> Option<Component<PositionOf<Self::Pose>>> {
        None
    }

    /// The feature h⁻¹(z, x) of a measurement, with H* = ∂h⁻¹/∂z; `None` if there is none.
    fn invert(&self, frame: &Self::Frame, measured: &Self::Measurement) -> Option<InverseOf<Self>>;

    /// ∂h/∂x of the predicted measurement of the feature at `feature`, in the coordinates of
    /// [`Pose::difference`](crate::Pose::difference). The informed proposal and joint maps need it; for a filter with neither, it
    /// may return zero.
    fn by_pose(
        &self,
        frame: &Self::Frame,
        feature: &PositionOf<Self::Pose>,
        expected: &ExpectedOf<Self>,
    ) -> Linear<Self::Measurement, TangentOf<Self::Pose>>;
}

/// The predicted measurement of a sensor.
pub type ExpectedOf<S> = Expected<PositionOf<<S as Sensor>::Pose>, <S as Sensor>::Measurement>;
/// The feature computed from a measurement of a sensor.
pub type InverseOf<S> = Inverse<PositionOf<<S as Sensor>::Pose>, <S as Sensor>::Measurement>;

/// A predicted measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected<D: Vector, Z: Vector> {
    /// ẑ.
    pub measurement: Z,
    /// H = ∂h/∂m.
    pub jacobian: Linear<Z, D>,
}

/// The feature computed from a measurement (inverse sensor model).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inverse<D: Vector, Z: Vector> {
    /// Position of the feature, m.
    pub feature: D,
    /// H* = ∂h⁻¹/∂z.
    pub jacobian: Linear<D, Z>,
}

/// What a sensor with another one, of type `$S` in the field `$sensor`, has in common with it.
macro_rules! as_inner_sensor {
    ($S:ident, $sensor:tt) => {
        const SORTED_BY: usize = $S::SORTED_BY;
        const SORTED_BY_ANGLE: bool = $S::SORTED_BY_ANGLE;
        const SIFTED_BY: Option<usize> = $S::SIFTED_BY;

        fn check(&self) -> Result<(), ModelError> {
            self.$sensor.check()
        }

        #[inline(always)]
        fn innovation(&self, measured: &$S::Measurement, expected: &$S::Measurement) -> $S::Measurement {
            self.$sensor.innovation(measured, expected)
        }

        fn occludes(&self, measured: &$S::Measurement, expected: &$S::Measurement) -> bool {
            self.$sensor.occludes(measured, expected)
        }

        #[inline(always)]
        fn noise(&self) -> &Symmetric<$S::Measurement> {
            self.$sensor.noise()
        }
    };
}
pub(super) use as_inner_sensor;
