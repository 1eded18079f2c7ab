//! A sensor, and the detector that is made of it.

use crate::PlanarState;
use nalgebra::{Vector1, Vector2};
use scphd::models::{
    BearingOnly, ModelError, Mounting, PolarBirths, PolarGrid, RangeBearing, RangeBearingLimits, RangeBearingWindow,
    Sensing, UniformClutter,
};
use scphd::{Births, Detector, Real};

/// What a sensor measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorModel {
    /// Range and bearing.
    RangeBearing,
    /// Bearings alone: for mixtures.
    Bearing,
}

/// A sensor: its model, its noise, where it sees, its clutter and births, and where it sits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor<T> {
    /// What it measures.
    pub model: SensorModel,
    /// Standard deviation of the range, m.
    pub range_sigma_m: T,
    /// Standard deviation of the bearing, rad.
    pub bearing_sigma_rad: T,
    /// Where it sees, and with what probability of detection.
    pub window: RangeBearingLimits<T>,
    /// False measurements to expect of a scan.
    pub clutter_per_scan: T,
    /// Births of range and bearing.
    pub births: Births<T>,
    /// Births of bearings alone.
    pub grid: PolarGrid<T>,
    /// How far ahead of the pose and how far to its left the sensor sits, m.
    pub seat_m: [T; 2],
    /// Where it looks, to the left, rad.
    pub yaw_rad: T,
}

/// One scan, as its sensor measures it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measurements<'a, T> {
    /// Range, m, and bearing, rad.
    RangeBearing(&'a [Vector2<T>]),
    /// Bearing, rad.
    Bearing(&'a [Vector1<T>]),
}

/// A detector of range and bearing for poses of a kind.
pub type Polar<P, T> =
    Detector<Sensing<<P as PlanarState>::Seen<RangeBearing<T>>, RangeBearingWindow<T>, UniformClutter<T>>>;
/// A detector of bearings for poses of a kind.
pub type Direction<P, T> = Detector<
    Sensing<<P as PlanarState>::Seen<BearingOnly<T, PolarBirths<T>>>, RangeBearingWindow<T>, UniformClutter<T>>,
>;

impl<T: Real> Sensor<T> {
    /// A sensor of range and bearing that sees all around, as far as this, m, with this probability of detection and these standard deviations, m and
    /// rad: one false measurement a scan, one in ten scans of a feature that is new, none that moves, seated where the pose is.
    #[must_use]
    pub fn range_bearing(range_max_m: T, probability: T, [range_sigma_m, bearing_sigma_rad]: [T; 2]) -> Self {
        let turn = T::PI + T::PI;
        Self {
            model: SensorModel::RangeBearing,
            range_sigma_m,
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

    /// The detector of range and bearing.
    ///
    /// # Errors
    /// A number is out of range.
    pub fn polar<P: PlanarState<Scalar = T>>(&self) -> Result<Polar<P, T>, ModelError> {
        let field_of_view = RangeBearingWindow::new(self.window)?;
        let sensor = P::seen(RangeBearing::new(self.range_sigma_m, self.bearing_sigma_rad)?);
        let clutter = UniformClutter::of_scan(self.clutter_per_scan, field_of_view.measure())?;
        let detector = Detector::new(Sensing { sensor, field_of_view, clutter }, self.births)?;
        match self.mounting()? {
            Some(mounting) => detector.mounted(mounting),
            None => Ok(detector),
        }
    }

    /// The detector of bearings.
    pub(crate) fn direction<P: PlanarState<Scalar = T>>(&self) -> Result<Direction<P, T>, ModelError> {
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

    /// Whether its models can be made.
    pub(crate) fn check<P: PlanarState<Scalar = T>>(&self) -> Result<(), ModelError> {
        match self.model {
            SensorModel::RangeBearing => self.polar::<P>().map(|_| ()),
            SensorModel::Bearing => self.direction::<P>().map(|_| ()),
        }
    }
}
