//! The models of a sensor with its mounting on the vehicle.

use super::{ExpectedOf, FieldOfView, InverseOf, ModelError, Mounting, Pose, Sensor, sensor::as_inner_sensor};
use crate::numerics::vector::applied;
use crate::{Bounds, Component, Linear, Matrix, PositionOf, ScalarOf, Symmetric, TangentOf, Vector};

/// A sensor with its mounting: it takes the pose of the vehicle, and passes its own pose to the model.
#[derive(Debug)]
pub(crate) struct Mounted<'a, S: Sensor> {
    pub(crate) sensor: &'a S,
    /// `None` if the sensor's pose is that of the vehicle.
    pub(crate) mounting: Option<Mounting<ScalarOf<S::Pose>>>,
}

/// The field of view of a mounted sensor.
#[derive(Debug)]
pub(crate) struct MountedView<'a, V> {
    pub(crate) field_of_view: &'a V,
}

/// The frame of a mounted sensor.
#[derive(Debug)]
pub(crate) struct MountedFrame<F, K> {
    frame: F,
    /// The derivative of the sensor's pose with respect to the vehicle's heading; `None` without a mounting.
    by_heading: Option<K>,
}

impl<S: Sensor> Mounted<'_, S> {
    /// The frame of a sensor with a mounting. Not inlined, so that a sensor without one does not need its stack.
    #[inline(never)]
    fn seated(&self, mounting: &Mounting<ScalarOf<S::Pose>>, pose: &S::Pose) -> <Self as Sensor>::Frame {
        let (seat, by_heading) = pose.mounted(mounting);
        MountedFrame { frame: self.sensor.frame(&seat), by_heading: Some(by_heading) }
    }
}

/// ∂h/∂x with respect to the vehicle's pose, from that with respect to the sensor's pose: the column of the heading differs.
#[inline(never)]
fn swung<P: Pose, Z: Vector<Scalar = P::Scalar>>(
    by_seat: Linear<Z, P::Tangent>,
    by_heading: &P::Tangent,
) -> Linear<Z, P::Tangent> {
    let column = applied::<Z, P::Tangent>(&by_seat, by_heading);
    Matrix::with(|row, k| if P::HEADING == Some(k) { column.at(row) } else { by_seat.at(row, k) })
}

impl<S: Sensor> Sensor for Mounted<'_, S> {
    type Pose = S::Pose;
    type Measurement = S::Measurement;
    type Frame = MountedFrame<S::Frame, TangentOf<S::Pose>>;

    as_inner_sensor!(S, sensor);

    #[inline]
    fn frame(&self, pose: &S::Pose) -> Self::Frame {
        match &self.mounting {
            None => MountedFrame { frame: self.sensor.frame(pose), by_heading: None },
            Some(mounting) => self.seated(mounting, pose),
        }
    }

    #[inline(always)]
    fn expect(&self, frame: &Self::Frame, feature: &PositionOf<S::Pose>) -> Option<ExpectedOf<S>> {
        self.sensor.expect(&frame.frame, feature)
    }

    #[inline(always)]
    fn noise_of(&self, measured: &S::Measurement, expected: &S::Measurement) -> Option<Symmetric<S::Measurement>> {
        self.sensor.noise_of(measured, expected)
    }

    fn expected_birth(&self, frame: &Self::Frame, index: usize) -> Option<Component<PositionOf<S::Pose>>> {
        self.sensor.expected_birth(&frame.frame, index)
    }

    fn invert(&self, frame: &Self::Frame, measured: &S::Measurement) -> Option<InverseOf<S>> {
        self.sensor.invert(&frame.frame, measured)
    }

    #[inline]
    fn by_pose(
        &self,
        frame: &Self::Frame,
        feature: &PositionOf<S::Pose>,
        expected: &ExpectedOf<S>,
    ) -> Linear<S::Measurement, TangentOf<S::Pose>> {
        let by_seat = self.sensor.by_pose(&frame.frame, feature, expected);
        match &frame.by_heading {
            None => by_seat,
            Some(by_heading) => swung::<S::Pose, S::Measurement>(by_seat, by_heading),
        }
    }
}

impl<F, K, D: Vector, Z: Vector, V: FieldOfView<F, D, Z>> FieldOfView<MountedFrame<F, K>, D, Z> for MountedView<'_, V> {
    fn check(&self) -> Result<(), ModelError> {
        self.field_of_view.check()
    }

    #[inline(always)]
    fn detection_probability(&self, frame: &MountedFrame<F, K>, feature: &D, expected: &Z) -> D::Scalar {
        self.field_of_view.detection_probability(&frame.frame, feature, expected)
    }

    #[inline(always)]
    fn may_see(&self, frame: &MountedFrame<F, K>, feature: &D) -> bool {
        self.field_of_view.may_see(&frame.frame, feature)
    }

    fn bounds(&self, frame: &MountedFrame<F, K>) -> Bounds<D> {
        self.field_of_view.bounds(&frame.frame)
    }
}
