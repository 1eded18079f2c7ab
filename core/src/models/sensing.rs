//! All that is modelled of one kind of sensor: what it measures, where it sees, what it takes for a feature.

use super::{Clutter, FieldOfView, ModelError, Mounted, MountedFrame, MountedView, Mounting, Pose, Sensor, require};
use crate::{PositionOf, ScalarOf, TangentOf, Vector};

/// The models of one kind of sensor, as one type: what [`Sensing`] is to generic code.
pub trait MeasurementModel {
    /// The vehicle state.
    type Pose: Pose;
    /// What is measured of a feature.
    type Measurement: Vector<Scalar = ScalarOf<Self::Pose>>;
    /// The sensor at a pose.
    type Frame;
    /// What is measured of a feature, and with what noise.
    type Sensor: Sensor<Pose = Self::Pose, Measurement = Self::Measurement, Frame = Self::Frame>;
    /// Where features are detected, and with what probability.
    type FieldOfView: FieldOfView<Self::Frame, PositionOf<Self::Pose>, Self::Measurement>;
    /// What is measured where there is no feature.
    type Clutter: Clutter<Self::Measurement>;

    /// What is measured of a feature, and with what noise.
    fn sensor(&self) -> &Self::Sensor;
    /// Where features are detected, and with what probability.
    fn field_of_view(&self) -> &Self::FieldOfView;
    /// What is measured where there is no feature.
    fn clutter(&self) -> &Self::Clutter;

    /// The parameter that one of them cannot work with, if any.
    ///
    /// # Errors
    /// Names the parameter and its range.
    fn check(&self) -> Result<(), ModelError> {
        self.sensor().check()?;
        self.field_of_view().check()?;
        self.clutter().check()?;
        require(self.sensor().noise().factor().is_some(), "noise", "positive definite")
    }
}

/// The models of one sensor.
///
/// Models that come with the crate are checked where they are made. Those of a user are asked by
/// [`Detector::new`](crate::Detector::new) and [`Detector::retune`](crate::Detector::retune) whether they can be worked with (`check` of each
/// trait). Whatever they return later, no weight and no stored feature becomes NaN of it, and no loop goes on for ever:
///
/// | returned | taken for |
/// |---|---|
/// | p_D of 1 or more | 1 less a rounding error |
/// | p_D not above zero, NaN | out of view |
/// | ln κ that is NaN or +∞ | no clutter |
/// | an expected measurement, a Jacobian, an innovation that is not finite | a feature that meets no measurement |
/// | an inverse that is not finite | a measurement without birth |
/// | a component of the birth intensity that is not finite or not positive definite | none |
/// | more of those than `VIEW` of the static maps | none, and counted as lost |
/// | a covariance of one measurement that is not positive definite | that of all |
/// | a covariance of the measurement noise that is not positive definite | [`ScanError::SensorNoise`](crate::ScanError::SensorNoise) |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensing<S, V, C> {
    /// What is measured: h, its inverse and their noise.
    pub sensor: S,
    /// Where the sensor sees: p_D(m | x).
    pub field_of_view: V,
    /// What it measures though nothing is there: κ(z).
    pub clutter: C,
}

impl<S, V, C> MeasurementModel for Sensing<S, V, C>
where
    S: Sensor,
    V: FieldOfView<S::Frame, PositionOf<S::Pose>, S::Measurement>,
    C: Clutter<S::Measurement>,
{
    type Pose = S::Pose;
    type Measurement = S::Measurement;
    type Frame = S::Frame;
    type Sensor = S;
    type FieldOfView = V;
    type Clutter = C;

    fn sensor(&self) -> &S {
        &self.sensor
    }

    fn field_of_view(&self) -> &V {
        &self.field_of_view
    }

    fn clutter(&self) -> &C {
        &self.clutter
    }
}

/// The models of a sensor where it sits on the vehicle: speak of the vehicle's pose.
#[derive(Debug)]
pub(crate) struct OnVehicle<'a, X: MeasurementModel> {
    pub(crate) sensor: Mounted<'a, X::Sensor>,
    pub(crate) field_of_view: MountedView<'a, X::FieldOfView>,
    pub(crate) clutter: &'a X::Clutter,
}

impl<'a, X: MeasurementModel> OnVehicle<'a, X> {
    /// Models that speak of the sensor's pose; that of the vehicle where it is not mounted elsewhere.
    pub(crate) fn of(models: &'a X, mounting: Option<Mounting<ScalarOf<X::Pose>>>) -> Self {
        Self {
            sensor: Mounted { sensor: models.sensor(), mounting },
            field_of_view: MountedView { field_of_view: models.field_of_view() },
            clutter: models.clutter(),
        }
    }
}

impl<'a, X: MeasurementModel> MeasurementModel for OnVehicle<'a, X> {
    type Pose = X::Pose;
    type Measurement = X::Measurement;
    type Frame = MountedFrame<X::Frame, TangentOf<X::Pose>>;
    type Sensor = Mounted<'a, X::Sensor>;
    type FieldOfView = MountedView<'a, X::FieldOfView>;
    type Clutter = X::Clutter;

    fn sensor(&self) -> &Self::Sensor {
        &self.sensor
    }

    fn field_of_view(&self) -> &Self::FieldOfView {
        &self.field_of_view
    }

    fn clutter(&self) -> &X::Clutter {
        self.clutter
    }
}
