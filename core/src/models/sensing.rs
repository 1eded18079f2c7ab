//! The models of a sensor: measurement, field of view and clutter.

use super::{Clutter, FieldOfView, ModelError, Mounted, MountedFrame, MountedView, Mounting, Pose, RangeBearing};
use super::{RangeBearingWindow, Sensor, UniformClutter, require};
use crate::{PositionOf, Real, ScalarOf, TangentOf, Vector};

/// The models of one sensor as one type: the trait of [`Sensing`], for generic code.
pub trait MeasurementModel {
    /// The vehicle state.
    type Pose: Pose;
    /// A measurement of a feature.
    type Measurement: Vector<Scalar = ScalarOf<Self::Pose>>;
    /// The frame of the sensor at a pose.
    type Frame;
    /// The sensor model: predicted measurement of a feature, and its noise.
    type Sensor: Sensor<Pose = Self::Pose, Measurement = Self::Measurement, Frame = Self::Frame>;
    /// The field of view: probability of detection of a feature.
    type FieldOfView: FieldOfView<Self::Frame, PositionOf<Self::Pose>, Self::Measurement>;
    /// The clutter model: intensity of false measurements.
    type Clutter: Clutter<Self::Measurement>;

    /// The sensor model.
    fn sensor(&self) -> &Self::Sensor;
    /// The field of view.
    fn field_of_view(&self) -> &Self::FieldOfView;
    /// The clutter model.
    fn clutter(&self) -> &Self::Clutter;

    /// Checks the parameters of all models.
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
/// The models of the crate are checked when they are constructed. The models of a user are checked by
/// [`Detector::new`](crate::Detector::new) and [`Detector::retune`](crate::Detector::retune) (`check` of each trait). Invalid
/// values that they return later never make a weight or a stored feature NaN, and never cause an endless loop:
///
/// | returned value | treated as |
/// |---|---|
/// | p_D of 1 or more | 1 less a rounding error |
/// | p_D not above zero, NaN | out of view |
/// | ln κ that is NaN or +∞ | no clutter |
/// | a predicted measurement, a Jacobian, an innovation that is not finite | a feature without association to any measurement |
/// | an inverse that is not finite | a measurement without birth |
/// | a component of the birth intensity that is not finite or not positive definite | no component |
/// | more of those than `VIEW` of the static maps | no component, counted as lost |
/// | a covariance of one measurement that is not positive definite | that of [`Sensor::noise`] |
/// | a covariance of the measurement noise that is not positive definite | [`ScanError::SensorNoise`](crate::ScanError::SensorNoise) |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensing<S, V, C> {
    /// The sensor model: h, its inverse and their noise.
    pub sensor: S,
    /// The field of view: p_D(m | x).
    pub field_of_view: V,
    /// The clutter model: κ(z).
    pub clutter: C,
}

impl<T: Real> Sensing<RangeBearing<T>, RangeBearingWindow<T>, UniformClutter<T>> {
    /// A range and bearing sensor with these standard deviations of the noise, m and rad, and with clutter that is uniform over
    /// the field of view, of this expected number of false measurements per scan.
    ///
    /// # Errors
    /// As for [`RangeBearing::new`] and [`UniformClutter::of_scan`].
    pub fn range_bearing(
        [range_sigma_m, bearing_sigma_rad]: [T; 2],
        field_of_view: RangeBearingWindow<T>,
        clutter_per_scan: T,
    ) -> Result<Self, ModelError> {
        let sensor = RangeBearing::new(range_sigma_m, bearing_sigma_rad)?;
        let clutter = UniformClutter::of_scan(clutter_per_scan, field_of_view.measure())?;
        Ok(Self { sensor, field_of_view, clutter })
    }
}

impl<S: Sensor, V: FieldOfView<S::Frame, PositionOf<S::Pose>, S::Measurement>, C: Clutter<S::Measurement>>
    MeasurementModel for Sensing<S, V, C>
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

/// The models of a sensor with its mounting: they take the pose of the vehicle.
#[derive(Debug)]
pub(crate) struct OnVehicle<'a, X: MeasurementModel> {
    pub(crate) sensor: Mounted<'a, X::Sensor>,
    pub(crate) field_of_view: MountedView<'a, X::FieldOfView>,
    pub(crate) clutter: &'a X::Clutter,
}

impl<'a, X: MeasurementModel> OnVehicle<'a, X> {
    /// The models with this mounting; without one, the sensor's pose is that of the vehicle.
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
