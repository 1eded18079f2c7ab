//! How the noise of a range depends on the range.

use crate::{PlanarState, Polar, Sensor, SensorModel, Setting, StartError};
use core::fmt::Debug;
use core::marker::PhantomData;
use nalgebra::Vector2;
use scphd::Real;
use scphd::models::{NoiseModel, RangeBearing, RangeNoise};
use scphd::numerics::Symmetric;

/// How the noise of a range depends on the range: [`RangeNoise`], or [`SameNoise`] in a filter without the code for it.
pub trait Ranging<T: Real>: NoiseModel<RangeBearing<T>> + Copy + Debug {
    /// The noise of a sensor.
    ///
    /// # Errors
    /// Its ratio is out of range, or is not supported.
    fn of(sensor: &Sensor<T>) -> Result<Self, StartError>;
}

impl<T: Real> Ranging<T> for RangeNoise<T> {
    fn of(sensor: &Sensor<T>) -> Result<Self, StartError> {
        Ok(Self::new(sensor.range_sigma_ratio)?)
    }
}

/// Noise that is the same at every range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SameNoise<T>(PhantomData<T>);

impl<T: Real> NoiseModel<RangeBearing<T>> for SameNoise<T> {
    fn covariance(&self, _: &RangeBearing<T>, _: &Vector2<T>, _: &Vector2<T>) -> Option<Symmetric<Vector2<T>>> {
        None
    }
}

impl<T: Real> Ranging<T> for SameNoise<T> {
    fn of(sensor: &Sensor<T>) -> Result<Self, StartError> {
        let part = Setting::RANGE_RATIO;
        if sensor.range_sigma_ratio == T::ZERO { Ok(Self(PhantomData)) } else { Err(StartError::NoRoom { part }) }
    }
}

impl<T: Real> Sensor<T> {
    /// The detector of range and bearing with this kind of noise.
    pub(crate) fn seen<P: PlanarState<Scalar = T>, N: Ranging<T>>(&self) -> Result<Polar<P, T, N>, StartError> {
        match self.model {
            SensorModel::RangeBearing => Ok(self.with::<P, N>(N::of(self)?)?),
            SensorModel::Bearing => Err(StartError::NoRoom { part: Setting::SENSOR_MODEL }),
        }
    }
}
