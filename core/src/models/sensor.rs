//! What the sensor measures, as a trait.

use super::ModelError;
use crate::{Component, Dim, Packed, Real, Symmetric};
use nalgebra::{SMatrix, SVector};

/// What the sensor measures of a feature: h(m, x), its inverse, and their noise (sections 5.1, 5.2.1).
///
/// The pose that it speaks of is the sensor's own: where one is [mounted](crate::Mounting) elsewhere than where the vehicle's pose is, the
/// library works its pose out, and the derivatives by the vehicle's.
///
/// D is the dimension of the map, Z that of a measurement. An implementation must be a pure function of its
/// arguments, and take its transcendental functions from [`Real`]. Several cores may ask it at the same time.
pub trait Sensor<T: Real, const D: usize, const Z: usize>: Sync
where
    Dim<D>: Packed,
    Dim<Z>: Packed,
{
    /// The vehicle state it works from.
    type Pose;
    /// Whatever can be computed once per pose instead of once per feature, such as the heading's sine and cosine.
    type Frame;

    /// The coordinate of the measurement by which measurements are sorted, below Z: a feature then meets only the
    /// measurements near it. Choose the one that separates features best.
    const SORTED_BY: usize;
    /// Whether that coordinate is an angle that wraps at ±π.
    const SORTED_BY_ANGLE: bool;
    /// Another coordinate, below Z, along which the innovation is z − ẑ itself: one that does not wrap. It tells most of the
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
    fn expect(&self, frame: &Self::Frame, feature: &SVector<T, D>) -> Option<Expected<T, D, Z>>;

    /// z ⊖ ẑ: the difference of two measurements, angles wrapped.
    fn innovation(&self, measured: &SVector<T, Z>, expected: &SVector<T, Z>) -> SVector<T, Z>;

    /// Whether what was measured stands before a feature of which `expected` is expected, so that the feature may be hidden.
    /// Never, unless the sensor says otherwise.
    fn hides(&self, _measured: &SVector<T, Z>, _expected: &SVector<T, Z>) -> bool {
        false
    }

    /// R, the covariance of the measurement noise.
    fn noise(&self) -> &Symmetric<T, Z>;

    /// The birth intensity that does not wait for measurements (5.2.1), for a sensor whose measurement cannot be
    /// inverted: its component of that index, in map coordinates, as seen from the frame; `None` past the last. These
    /// components are part of every predicted static map, without being stored. There are as many from every frame, and no more
    /// than `VIEW` of the static maps. None by default: features are then born from measurements.
    fn expected_birth(&self, _frame: &Self::Frame, _index: usize) -> Option<Component<T, D>> {
        None
    }

    /// The feature h⁻¹(z, x) that would give the measurement, with H* = ∂h⁻¹/∂z; `None` where there is none.
    fn invert(&self, frame: &Self::Frame, measured: &SVector<T, Z>) -> Option<Inverse<T, D, Z>>;
}

/// A sensor that tells where its vehicle is: one whose measurements can be differentiated by the pose, which has K degrees
/// of freedom. The informed proposal needs it.
pub trait Locating<T: Real, const K: usize, const D: usize, const Z: usize>: Sensor<T, D, Z>
where
    Dim<D>: Packed,
    Dim<Z>: Packed,
{
    /// ∂h/∂x of what is expected of the feature at `feature`, in the coordinates of
    /// [`Pose::difference`](crate::Pose::difference).
    fn by_pose(&self, frame: &Self::Frame, feature: &SVector<T, D>, expected: &Expected<T, D, Z>) -> SMatrix<T, Z, K>;
}

/// An expected measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected<T, const D: usize, const Z: usize> {
    /// ẑ.
    pub measurement: SVector<T, Z>,
    /// H = ∂h/∂m.
    pub jacobian: SMatrix<T, Z, D>,
}

/// A measurement turned into a feature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inverse<T, const D: usize, const Z: usize> {
    /// Position of the feature, m.
    pub feature: SVector<T, D>,
    /// H* = ∂h⁻¹/∂z.
    pub jacobian: SMatrix<T, D, Z>,
}
