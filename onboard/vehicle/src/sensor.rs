//! A sensor, and its detector.

use crate::PlanarState;
use core::fmt::Debug;
use nalgebra::{Vector1, Vector2};
use scphd::models::{
    BearingOnly, ModelError, Mounting, NoiseModel, PolarBirths, PolarGrid, RangeBearing, RangeBearingLimits,
    RangeBearingWindow, RangeNoise, Sensing, UniformClutter, WithNoise,
};
use scphd::{Births, Detector, Real};

/// The measurement of a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorModel {
    /// Range and bearing.
    RangeBearing,
    /// Bearings only: for mixtures.
    Bearing,
}

/// A sensor: its model, noise, field of view, clutter, birth intensities and mounting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor<T> {
    /// The sensor model.
    pub model: SensorModel,
    /// Standard deviation of the range, m.
    pub range_sigma_m: T,
    /// Standard deviation of the range divided by the range; adds in quadrature.
    pub range_sigma_ratio: T,
    /// Standard deviation of the bearing, rad.
    pub bearing_sigma_rad: T,
    /// Field of view, with the probability of detection.
    pub window: RangeBearingLimits<T>,
    /// Mean number of false measurements in a scan.
    pub clutter_per_scan: T,
    /// Birth intensities of a sensor of range and bearing.
    pub births: Births<T>,
    /// Birth intensity of a bearing-only sensor.
    pub grid: PolarGrid<T>,
    /// Position of the sensor ahead and to the left of the pose, m.
    pub seat_m: [T; 2],
    /// Rotation of the sensor to the left, rad.
    pub yaw_rad: T,
}

/// The measurements of one scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measurements<'a, T> {
    /// Range, m, and bearing, rad.
    RangeBearing(&'a [Vector2<T>]),
    /// Bearing, rad.
    Bearing(&'a [Vector1<T>]),
}

/// A detector of range and bearing for this state, with this noise.
pub type Polar<P, T, N = RangeNoise<T>> = Detector<
    Sensing<<P as PlanarState>::Seen<WithNoise<RangeBearing<T>, N>>, RangeBearingWindow<T>, UniformClutter<T>>,
>;
/// A bearing-only detector for this state.
pub type Direction<P, T> = Detector<
    Sensing<<P as PlanarState>::Seen<BearingOnly<T, PolarBirths<T>>>, RangeBearingWindow<T>, UniformClutter<T>>,
>;

impl<T: Real> Sensor<T> {
    /// A sensor of range and bearing with a full circle of this radius, m, with this probability of detection and these standard
    /// deviations, m and rad; a mean of one false measurement per scan and one new feature in ten scans, no moving births, at the
    /// pose of the vehicle.
    #[must_use]
    pub fn range_bearing(range_max_m: T, probability: T, [range_sigma_m, bearing_sigma_rad]: [T; 2]) -> Self {
        let turn = T::PI + T::PI;
        Self {
            model: SensorModel::RangeBearing,
            range_sigma_m,
            range_sigma_ratio: T::ZERO,
            bearing_sigma_rad,
            window: RangeBearingLimits::full_circle(range_max_m, probability),
            clutter_per_scan: T::ONE,
            births: Births::of_static(T::from_f64(0.1) / (range_max_m * turn)),
            grid: PolarGrid {
                nearest_m: T::from_f64(0.1) * range_max_m,
                farthest_m: range_max_m,
                rings: 4,
                sectors: 24,
                weight: T::from_f64(0.001),
            },
            seat_m: [T::ZERO; 2],
            yaw_rad: T::ZERO,
        }
    }

    fn mounting(&self) -> Result<Option<Mounting<T>>, ModelError> {
        let [forward_m, left_m] = self.seat_m;
        let elsewhere = [forward_m, left_m, self.yaw_rad].iter().any(|number| *number != T::ZERO);
        elsewhere.then(|| Mounting::in_plane(forward_m, left_m, self.yaw_rad)).transpose()
    }

    /// The detector of range and bearing, for a program with more detectors than a description.
    ///
    /// # Errors
    /// A number is out of range.
    pub fn polar<P: PlanarState<Scalar = T>>(&self) -> Result<Polar<P, T>, ModelError> {
        self.with::<P, _>(RangeNoise::new(self.range_sigma_ratio)?)
    }

    pub(crate) fn with<P: PlanarState<Scalar = T>, N: NoiseModel<RangeBearing<T>> + Debug>(
        &self,
        noise: N,
    ) -> Result<Polar<P, T, N>, ModelError> {
        let field_of_view = RangeBearingWindow::new(self.window)?;
        let sensor = RangeBearing::new(self.range_sigma_m, self.bearing_sigma_rad)?;
        let sensor = P::seen(WithNoise { sensor, noise });
        let clutter = UniformClutter::of_scan(self.clutter_per_scan, field_of_view.measure())?;
        let detector = Detector::new(Sensing { sensor, field_of_view, clutter }, self.births)?;
        match self.mounting()? {
            Some(mounting) => detector.mounted(mounting),
            None => Ok(detector),
        }
    }

    /// The bearing-only detector.
    ///
    /// # Errors
    /// A number is out of range.
    pub fn direction<P: PlanarState<Scalar = T>>(&self) -> Result<Direction<P, T>, ModelError> {
        let field_of_view = RangeBearingWindow::new(self.window)?;
        let sensor = P::seen(BearingOnly::new(self.bearing_sigma_rad, PolarBirths::new(self.grid)?)?);
        let half_width_rad = self.window.bearing_half_width_rad.at_most(T::PI);
        let clutter = UniformClutter::of_scan(self.clutter_per_scan, half_width_rad + half_width_rad)?;
        let detector = Detector::new(Sensing { sensor, field_of_view, clutter }, Births::NONE)?;
        match self.mounting()? {
            Some(mounting) => detector.mounted(mounting),
            None => Ok(detector),
        }
    }

    /// Checks the models.
    pub(crate) fn check<P: PlanarState<Scalar = T>>(&self) -> Result<(), ModelError> {
        match self.model {
            SensorModel::RangeBearing => self.polar::<P>().map(|_| ()),
            SensorModel::Bearing => self.direction::<P>().map(|_| ()),
        }
    }
}
