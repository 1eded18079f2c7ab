//! Streams of vehicles in the plane that measure range and bearing.

mod black_box;
mod fix;
mod joint;
mod models;
mod onboard;

pub use black_box::{BlackBox, BlackBoxJoint};
pub use fix::Fix;
pub use joint::PlanarJoint;
pub use models::{Models, Sensor};
pub use onboard::{MEASUREMENTS, Memory};

use crate::header::Scalar;
use crate::kind::{Input, Kind};
use crate::numbers::{Numbers, numbers};

/// The kind of these streams.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Planar;

/// The motion model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Vehicle {
    /// Speed of the encoder's wheel and steering angle (5.25–5.27).
    Ackermann,
    /// Speed and turn rate, Euler step.
    Unicycle,
    /// Speed and turn rate, exact arc.
    UnicycleArc,
}

numbers! {
    /// The vehicle moved.
    Odometry {
        /// Speed (m/s), then steering angle (rad) or turn rate (rad/s).
        control: [f64; 2],
        /// For how long, s.
        dt_s: f64,
    }
}

impl Kind for Planar {
    type Vehicle = Vehicle;
    type Models = Models;
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

    const DETECTORS: u8 = 4;
    const VEHICLE: Vehicle = Vehicle::Ackermann;

    fn code(vehicle: Vehicle) -> u8 {
        match vehicle {
            Vehicle::Ackermann => 0,
            Vehicle::Unicycle => 1,
            Vehicle::UnicycleArc => 2,
        }
    }

    fn vehicle(code: u8) -> Option<Vehicle> {
        match code {
            0 => Some(Vehicle::Ackermann),
            1 => Some(Vehicle::Unicycle),
            2 => Some(Vehicle::UnicycleArc),
            _ => None,
        }
    }
}

/// Always whole.
impl Input for Odometry {
    fn parts(&self) -> u8 {
        0
    }

    fn count(parts: u8) -> Option<usize> {
        (parts == 0).then_some(Self::COUNT)
    }

    fn scalar(of_stream: Scalar) -> Scalar {
        of_stream
    }

    fn put(&self, sink: &mut impl FnMut(f64)) {
        Numbers::put(self, sink);
    }

    fn take(_parts: u8, source: &mut impl FnMut() -> Option<f64>) -> Option<Self> {
        Numbers::take(source)
    }
}
