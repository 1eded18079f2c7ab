//! Sensors and fixes of a vehicle with online odometry calibration.

use super::{CalibratedPose, ExpectedOf, Fix, InverseOf, ModelError, PlanarPose, Sensor, sensor::as_inner_sensor};
use crate::{Component, Linear, Matrix, Real, Symmetric, TangentOf, Vector};
use nalgebra::Vector2;

/// A sensor or a fix of a [`PlanarPose`] as one of a [`CalibratedPose`]: the odometry correction has no effect on measurements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibrated<S>(pub S);

/// ∂h/∂x with zero columns for the odometry correction.
fn widened<T: Real, Z: Vector<Scalar = T>>(
    by_vehicle: &Linear<Z, TangentOf<PlanarPose<T>>>,
) -> Linear<Z, TangentOf<CalibratedPose<T>>> {
    Matrix::with(|row, column| by_vehicle.at(row, column))
}

impl<T: Real, S: Sensor<Pose = PlanarPose<T>>> Sensor for Calibrated<S> {
    type Pose = CalibratedPose<T>;
    type Measurement = S::Measurement;
    type Frame = S::Frame;

    as_inner_sensor!(S, 0);

    fn frame(&self, pose: &CalibratedPose<T>) -> S::Frame {
        self.0.frame(&pose.vehicle)
    }

    fn expect(&self, frame: &S::Frame, feature: &Vector2<T>) -> Option<ExpectedOf<S>> {
        self.0.expect(frame, feature)
    }

    fn noise_of(&self, measured: &S::Measurement, expected: &S::Measurement) -> Option<Symmetric<S::Measurement>> {
        self.0.noise_of(measured, expected)
    }

    fn expected_birth(&self, frame: &S::Frame, index: usize) -> Option<Component<Vector2<T>>> {
        self.0.expected_birth(frame, index)
    }

    fn invert(&self, frame: &S::Frame, measured: &S::Measurement) -> Option<InverseOf<S>> {
        self.0.invert(frame, measured)
    }

    fn by_pose(
        &self,
        frame: &S::Frame,
        feature: &Vector2<T>,
        expected: &ExpectedOf<S>,
    ) -> Linear<S::Measurement, TangentOf<CalibratedPose<T>>> {
        widened::<T, S::Measurement>(&self.0.by_pose(frame, feature, expected))
    }
}

impl<T: Real, F: Fix<Pose = PlanarPose<T>>> Fix for Calibrated<F> {
    type Pose = CalibratedPose<T>;
    type Measurement = F::Measurement;

    fn expect(&self, pose: &CalibratedPose<T>) -> Option<F::Measurement> {
        self.0.expect(&pose.vehicle)
    }

    fn by_pose(&self, pose: &CalibratedPose<T>) -> Linear<F::Measurement, TangentOf<CalibratedPose<T>>> {
        widened::<T, F::Measurement>(&self.0.by_pose(&pose.vehicle))
    }

    fn innovation(&self, measured: &F::Measurement, expected: &F::Measurement) -> F::Measurement {
        self.0.innovation(measured, expected)
    }

    fn noise(&self) -> &Symmetric<F::Measurement> {
        self.0.noise()
    }

    fn gate(&self) -> T {
        self.0.gate()
    }
}
