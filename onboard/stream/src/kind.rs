//! What streams of different vehicles differ in.

use crate::numbers::Numbers;
use crate::scalar::Scalar;
use core::fmt::Debug;

/// A kind of stream: what its head says of the vehicle, and what its records hold.
pub trait Kind: Copy + Debug + PartialEq {
    /// The motion model, of those that vehicles of this kind may have.
    type Vehicle: Copy + Debug + PartialEq;
    /// The numbers of the models in the head.
    type Models: Numbers + Debug + PartialEq;
    /// What a record of a prediction says.
    type Input: Input;
    /// One measurement of a scan.
    type Measurement: Numbers + Debug;
    /// Coordinates of an estimated pose.
    type Pose: Numbers + Debug + PartialEq;
    /// A measurement of the pose itself, and how good it is.
    type Fix: Input;
    /// The models of a detector beyond the first, which is that of the head.
    type Sensor: Numbers + Debug + PartialEq;
    /// All numbers of a pose, as [`scphd::models::Pose::to_numbers`] has them.
    type Full: Numbers + Debug + AsRef<[f64]> + AsMut<[f64]>;
    /// Lower triangle of the covariance of a pose, row after row.
    type Covariance: Numbers + Debug + AsRef<[f64]> + AsMut<[f64]>;
    /// A feature of a map: label, ln w, mean, lower triangle of the covariance.
    type Feature: Numbers + Debug + AsRef<[f64]> + AsMut<[f64]>;

    /// How many detectors a vehicle may have.
    const DETECTORS: u8;

    /// The vehicle of a head that says nothing.
    const VEHICLE: Self::Vehicle;

    /// The byte that stands for a vehicle: no two of any kinds have the same.
    fn code(vehicle: Self::Vehicle) -> u8;

    /// The vehicle that a byte stands for, if it is of this kind.
    fn vehicle(code: u8) -> Option<Self::Vehicle>;
}

/// What a record of a prediction, or of a fix, says.
pub trait Input: Copy + Debug + PartialEq {
    /// Which of its parts there are, a bit for each, where not all need be.
    fn parts(&self) -> u8;

    /// Numbers of a record with these parts; `None` for parts that are none.
    fn count(parts: u8) -> Option<usize>;

    /// The type of its numbers in a stream of this type.
    fn scalar(of_stream: Scalar) -> Scalar;

    /// Hands on the numbers of its parts.
    fn put(&self, sink: &mut impl FnMut(f64));

    /// Makes it of its parts' numbers; `None` where they run out.
    fn take(parts: u8, source: &mut impl FnMut() -> Option<f64>) -> Option<Self>;
}
