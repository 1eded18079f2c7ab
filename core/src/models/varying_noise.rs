//! Sensors whose noise differs between measurements: it depends on the range, or the driver reports it with each measurement.

use super::{ExpectedOf, InverseOf, ModelError, Sensor, require, sensor::as_inner_sensor};
use crate::{Component, Factor, Linear, PositionOf, Symmetric, TangentOf, Vector, Zero};

/// Covariance of the noise of a measurement of a sensor `S`. A closure of the predicted measurement implements it.
pub trait NoiseModel<S: Sensor>: Sync {
    /// As for [`Sensor::noise_of`].
    fn covariance(
        &self,
        sensor: &S,
        measured: &S::Measurement,
        expected: &S::Measurement,
    ) -> Option<Symmetric<S::Measurement>>;
}

impl<S: Sensor, N: Fn(&S::Measurement) -> Symmetric<S::Measurement> + Sync> NoiseModel<S> for N {
    fn covariance(
        &self,
        _sensor: &S,
        _measured: &S::Measurement,
        expected: &S::Measurement,
    ) -> Option<Symmetric<S::Measurement>> {
        Some(self(expected))
    }
}

/// A sensor with another noise model.
///
/// A lidar whose standard deviation of the range grows with the range, σ = a + b r:
///
/// ```
/// use nalgebra::Vector2;
/// use scphd::models::{RangeBearing, Sensor, WithNoise};
/// use scphd::numerics::Symmetric;
///
/// let (a_m, b, bearing_sigma_rad) = (0.01_f32, 0.005, 0.002);
/// let by_range = move |z: &Vector2<f32>| {
///     let range_sigma_m = a_m + b * z.x;
///     Symmetric::from_diagonal([range_sigma_m * range_sigma_m, bearing_sigma_rad * bearing_sigma_rad])
/// };
/// // The noise of the sensor itself is used for occlusion and for fixes of beacons: give it for the middle of the view.
/// let lidar = WithNoise { sensor: RangeBearing::new(0.06, bearing_sigma_rad)?, noise: by_range };
/// let far = lidar.noise_of(&Vector2::new(20.4, 0.3), &Vector2::new(20.0, 0.3)).unwrap();
/// assert!((far.get(0, 0) - 0.11 * 0.11).abs() < 1e-6);
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WithNoise<S, N> {
    /// The sensor.
    pub sensor: S,
    /// The noise model: a closure of the predicted measurement, [`RangeNoise`](super::RangeNoise) or [`ReportedNoise`].
    pub noise: N,
}

impl<S: Sensor, N: NoiseModel<S>> Sensor for WithNoise<S, N> {
    type Pose = S::Pose;
    type Measurement = S::Measurement;
    type Frame = S::Frame;

    as_inner_sensor!(S, sensor);

    #[inline(always)]
    fn frame(&self, pose: &S::Pose) -> S::Frame {
        self.sensor.frame(pose)
    }

    #[inline(always)]
    fn expect(&self, frame: &S::Frame, feature: &PositionOf<S::Pose>) -> Option<ExpectedOf<S>> {
        self.sensor.expect(frame, feature)
    }

    #[inline(always)]
    fn noise_of(&self, measured: &S::Measurement, expected: &S::Measurement) -> Option<Symmetric<S::Measurement>> {
        self.noise.covariance(&self.sensor, measured, expected)
    }

    fn expected_birth(&self, frame: &S::Frame, index: usize) -> Option<Component<PositionOf<S::Pose>>> {
        self.sensor.expected_birth(frame, index)
    }

    fn invert(&self, frame: &S::Frame, measured: &S::Measurement) -> Option<InverseOf<S>> {
        self.sensor.invert(frame, measured)
    }

    fn by_pose(
        &self,
        frame: &S::Frame,
        feature: &PositionOf<S::Pose>,
        expected: &ExpectedOf<S>,
    ) -> Linear<S::Measurement, TangentOf<S::Pose>> {
        self.sensor.by_pose(frame, feature, expected)
    }
}

/// Covariances that a driver reports with the measurements of one scan, at most `N`.
///
/// R of a predicted measurement, and in [`ScPhd`](crate::ScPhd) of all measurements of a feature, is that of the nearest
/// measurement of the scan, with distances in the standard deviations of that measurement: the feature most probably caused that
/// one. In a scan without measurements R is [`Sensor::noise`].
///
/// ```
/// use nalgebra::Vector2;
/// use scphd::models::{RangeBearing, RangeBearingWindow, ReportedNoise, Sensing, UniformClutter, WithNoise};
/// use scphd::numerics::Symmetric;
/// use scphd::{Births, Detector};
///
/// let window = RangeBearingWindow::full_circle(20.0_f32, 0.9)?;
/// let radar = |noise: ReportedNoise<Vector2<f32>, 16>| -> Result<_, Box<dyn std::error::Error>> {
///     let sensor = WithNoise { sensor: RangeBearing::new(0.3, 0.02)?, noise };
///     let clutter = UniformClutter::of_scan(1.0, window.measure())?;
///     Ok(Sensing { sensor, field_of_view: window, clutter })
/// };
/// let mut detector = Detector::new(radar(ReportedNoise::default())?, Births::of_static(0.01))?;
/// // With every scan, before it is handed to the filter.
/// let scan = [Vector2::new(8.0, 0.1), Vector2::new(12.0, -0.4)];
/// let reported = [Symmetric::from_diagonal([0.01, 1e-4]), Symmetric::from_diagonal([0.25, 4e-4])];
/// detector.retune(radar(ReportedNoise::of(&scan, &reported)?)?)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReportedNoise<Z: Vector, const N: usize> {
    reported: [(Z, Symmetric<Z>); N],
    len: usize,
}

impl<Z: Vector, const N: usize> ReportedNoise<Z, N> {
    /// The noise of the measurements of a scan, with one covariance for each.
    ///
    /// # Errors
    /// There are more than `N` measurements, the numbers of covariances and measurements differ, or a covariance is not positive
    /// definite.
    pub fn of(measurements: &[Z], covariances: &[Symmetric<Z>]) -> Result<Self, ModelError> {
        let len = measurements.len();
        require(len <= N && len == covariances.len(), "covariances", "as many as measurements, and at most N")?;
        let mut noise = Self::default();
        for ((slot, z), covariance) in noise.reported.iter_mut().zip(measurements).zip(covariances) {
            require(covariance.factor().is_some(), "covariances", "positive definite")?;
            *slot = (*z, *covariance);
        }
        noise.len = len;
        Ok(noise)
    }
}

impl<Z: Vector, const N: usize> Default for ReportedNoise<Z, N> {
    /// The noise of a scan without measurements.
    fn default() -> Self {
        Self { reported: [(Z::ZERO, Symmetric::ZERO); N], len: 0 }
    }
}

impl<S: Sensor<Measurement: Sync>, const N: usize> NoiseModel<S> for ReportedNoise<S::Measurement, N>
where
    Symmetric<S::Measurement>: Sync,
{
    fn covariance(
        &self,
        sensor: &S,
        measured: &S::Measurement,
        _expected: &S::Measurement,
    ) -> Option<Symmetric<S::Measurement>> {
        let zero = <<S::Measurement as Vector>::Scalar as Zero>::ZERO;
        let distance = |(z, covariance): &(S::Measurement, Symmetric<S::Measurement>)| {
            let apart = sensor.innovation(z, measured);
            (0..S::Measurement::DIMENSION).fold(zero, |sum, k| sum + apart.at(k) * apart.at(k) / covariance.get(k, k))
        };
        let mut nearest = None;
        for one in self.reported.iter().take(self.len) {
            let distance = distance(one);
            if nearest.is_none_or(|(least, _)| distance < least) {
                nearest = Some((distance, one.1));
            }
        }
        nearest.map(|(_, covariance)| covariance)
    }
}

/// The covariance R of one measurement, if the sensor has an individual one for it.
#[derive(Debug)]
pub(crate) struct OwnNoise<Z: Vector> {
    /// R.
    pub(crate) covariance: Symmetric<Z>,
    /// Its Cholesky factor.
    pub(crate) factor: Factor<Z>,
}

impl<Z: Vector> OwnNoise<Z> {
    /// `None` if the sensor has no individual covariance for it, or one that is not positive definite.
    #[inline(always)]
    pub(crate) fn of<S: Sensor<Measurement = Z>>(sensor: &S, measured: &Z, expected: &Z) -> Option<Self> {
        let covariance = sensor.noise_of(measured, expected)?;
        Some(Self { covariance, factor: covariance.factor()? })
    }
}

/// R from either a measurement or a predicted measurement: its individual covariance, or that of all measurements.
#[inline(always)]
pub(crate) fn noise_at<S: Sensor>(sensor: &S, measurement: &S::Measurement) -> Symmetric<S::Measurement> {
    OwnNoise::of(sensor, measurement, measurement).map_or(*sensor.noise(), |own| own.covariance)
}
