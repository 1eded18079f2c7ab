//! Differences between streams of different vehicles.

use crate::numbers::Numbers;
use crate::scalar::Scalar;
use core::fmt::Debug;

/// A kind of stream: the parameters of the vehicle in its head, and the content of its records.
pub trait Kind: Copy + Debug + PartialEq {
    /// Numbers of the head in addition to the settings of a description.
    type Models: Numbers + Debug + PartialEq;
    /// The content of a record of a prediction.
    type Input: Input;
    /// One measurement of a scan.
    type Measurement: Numbers + Debug;
    /// Coordinates of an estimated pose.
    type Pose: Numbers + Debug + PartialEq;
    /// A measurement of the pose with its noise.
    type Fix: Input;
    /// The settings of a sensor.
    type Sensor: Numbers + Debug + PartialEq;
    /// All numbers of a pose, in the order of [`scphd::models::Pose::to_numbers`].
    type Full: Numbers + Debug + AsRef<[f64]> + AsMut<[f64]>;
    /// Lower triangle of the covariance of a pose, row after row.
    type Covariance: Numbers + Debug + AsRef<[f64]> + AsMut<[f64]>;
    /// A feature of a map: label, ln w, mean, lower triangle of the covariance.
    type Feature: Numbers + Debug + AsRef<[f64]> + AsMut<[f64]>;

    /// Maximum number of detectors of a vehicle.
    const DETECTORS: u8;

    /// The code of the kind in a head.
    const CODE: u8;
}

/// The content of a record of a prediction or a fix.
pub trait Input: Copy + Debug + PartialEq {
    /// Its parts, a bit for each, if some are optional.
    fn parts(&self) -> u8;

    /// Number of numbers of a record with these parts; `None` if the parts are invalid.
    fn count(parts: u8) -> Option<usize>;

    /// The type of its numbers in a stream of this type.
    fn scalar(of_stream: Scalar) -> Scalar;

    /// Passes the numbers of its parts to `sink`.
    fn put(&self, sink: &mut impl FnMut(f64));

    /// Constructs it from the numbers of its parts; `None` if there are too few.
    fn take(parts: u8, source: &mut impl FnMut() -> Option<f64>) -> Option<Self>;
}
