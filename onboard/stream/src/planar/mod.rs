//! Streams of planar vehicles that measure range and bearing.

mod description;
mod fix;
#[cfg(feature = "flips")]
mod flips;
mod joint;
mod mixture;
mod odometry;
mod onboard;

pub use description::NotRecorded;
pub use fix::Fix;
pub use joint::{
    BlackBoxArchive, BlackBoxCalibrated, BlackBoxHypotheses, BlackBoxJoint, BlackBoxMovers, PlanarHypotheses,
    PlanarJoint, PlanarJoint40, PlanarJoint40Movers, PlanarJointMovers,
};
pub use mixture::BlackBox;
pub use odometry::Odometry;
pub use onboard::{MEASUREMENTS, Memory, OnBoard};

use crate::kind::Kind;

/// The kind of streams of planar vehicles, and its mixture filter without a black box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Planar;

/// The numbers of a sensor: [`scphd_vehicle::Sensor::numbers`].
pub type Sensor = [f64; scphd_vehicle::Sensor::<f64>::NUMBERS];

impl Kind for Planar {
    /// A description has all of them.
    type Models = [f64; 0];
    type Input = Odometry;
    /// Range (m) and bearing (rad).
    type Measurement = [f64; 2];
    /// x (m), y (m) and heading (rad).
    type Pose = [f64; 3];
    type Fix = Fix;
    type Sensor = Sensor;
    type Full = [f64; 3];
    type Covariance = [f64; 6];
    type Feature = [f64; 7];

    const DETECTORS: u8 = scphd_vehicle::SENSORS as u8;
    const CODE: u8 = 0;
}
