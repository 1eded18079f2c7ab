//! What the sensor measures, as a trait.

use super::ModelError;
use crate::{Component, Linear, Pose, PositionOf, ScalarOf, Symmetric, TangentOf, Vector};

/// What the sensor measures of a feature: h(m, x), its inverse, and their noise (sections 5.1, 5.2.1).
///
/// The pose that it speaks of is the sensor's own: where one is [mounted](crate::Mounting) elsewhere than where the vehicle's pose is, the
/// library works its pose out, and the derivatives by the vehicle's.
///
/// An implementation must be a pure function of its
/// arguments, and take its transcendental functions from [`Real`](crate::Real). Several cores may ask it at the same time.
pub trait Sensor: Sync {
    /// The vehicle state it works from.
    type Pose: Pose;
    /// What it measures of a feature.
    type Measurement: Vector<Scalar = ScalarOf<Self::Pose>>;
    /// Whatever can be computed once per pose instead of once per feature, such as the heading's sine and cosine.
    type Frame;

    /// The coordinate of the measurement by which measurements are sorted, below its dimension: a feature then meets only the
    /// measurements near it. Choose the one that separates features best.
    const SORTED_BY: usize;
    /// Whether that coordinate is an angle that wraps at ±π.
    const SORTED_BY_ANGLE: bool;
    /// Another coordinate along which the innovation is z − ẑ itself: one that does not wrap. It tells most of the
    /// measurements near in the order from those near in all, at the cost of a subtraction. None where there is no such
    /// coordinate.
    const SIFTED_BY: Option<usize> = None;

    /// The parameter that the model cannot work with, if any: asked by [`Detector::new`](crate::Detector::new) and
    /// [`Detector::retune`](crate::Detector::retune).
    ///
    /// # Errors
    /// Names the parameter and its range. None unless the model says otherwise.
    fn check(&self) -> Result<(), ModelError> {
        Ok(())
    }

    /// The frame of a pose.
    fn frame(&self, pose: &Self::Pose) -> Self::Frame;

    /// The measurement ẑ = h(m, x) to expect of a feature at `feature`, with H = ∂h/∂m; `None` where the feature
    /// cannot be measured from there at all.
    fn expect(&self, frame: &Self::Frame, feature: &PositionOf<Self::Pose>) -> Option<ExpectedOf<Self>>;

    /// z ⊖ ẑ: the difference of two measurements, angles wrapped.
    fn innovation(&self, measured: &Self::Measurement, expected: &Self::Measurement) -> Self::Measurement;

    /// Whether what was measured stands before a feature of which `expected` is expected, so that the feature may be hidden.
    /// Never, unless the sensor says otherwise.
    fn occludes(&self, _measured: &Self::Measurement, _expected: &Self::Measurement) -> bool {
        false
    }

    /// R, the covariance of the measurement noise.
    fn noise(&self) -> &Symmetric<Self::Measurement>;

    /// The birth intensity that does not wait for measurements (5.2.1), for a sensor whose measurement cannot be
    /// inverted: its component of that index, in map coordinates, as seen from the frame; `None` past the last. These
    /// components are part of every predicted static map, without being stored. There are as many from every frame, and no more
    /// than `VIEW` of the static maps. None by default: features are then born from measurements.
    fn expected_birth(&self, _frame: &Self::Frame, _index: usize) -> Option<Component<PositionOf<Self::Pose>>> {
        None
    }

    /// The feature h⁻¹(z, x) that would give the measurement, with H* = ∂h⁻¹/∂z; `None` where there is none.
    fn invert(&self, frame: &Self::Frame, measured: &Self::Measurement) -> Option<InverseOf<Self>>;

    /// ∂h/∂x of what is expected of the feature at `feature`, in the coordinates of
    /// [`Pose::difference`](crate::Pose::difference). The informed proposal and joint maps need it; a sensor for a filter with neither
    /// may return zero.
    fn by_pose(
        &self,
        frame: &Self::Frame,
        feature: &PositionOf<Self::Pose>,
        expected: &ExpectedOf<Self>,
    ) -> Linear<Self::Measurement, TangentOf<Self::Pose>>;
}

/// What a sensor expects to measure.
pub type ExpectedOf<S> = Expected<PositionOf<<S as Sensor>::Pose>, <S as Sensor>::Measurement>;
/// A measurement of a sensor, turned into a feature.
pub type InverseOf<S> = Inverse<PositionOf<<S as Sensor>::Pose>, <S as Sensor>::Measurement>;

/// An expected measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected<D: Vector, Z: Vector> {
    /// ẑ.
    pub measurement: Z,
    /// H = ∂h/∂m.
    pub jacobian: Linear<Z, D>,
}

/// A measurement turned into a feature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inverse<D: Vector, Z: Vector> {
    /// Position of the feature, m.
    pub feature: D,
    /// H* = ∂h⁻¹/∂z.
    pub jacobian: Linear<D, Z>,
}
