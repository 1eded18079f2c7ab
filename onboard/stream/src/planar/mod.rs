//! Streams of planar vehicles that measure range and bearing.

mod black_box;
mod description;
mod fix;
#[cfg(feature = "flips")]
mod flips;
mod joint;
mod models;
mod onboard;
mod vehicle;

pub use black_box::{BlackBox, BlackBoxArchive, BlackBoxHypotheses, BlackBoxJoint, BlackBoxMovers};
pub use description::NotRecorded;
pub use fix::Fix;
pub use joint::{PlanarHypotheses, PlanarJoint, PlanarJoint40, PlanarJoint40Movers, PlanarJointMovers};
pub use models::{Models, Sensor, SensorModels};
pub use onboard::{MEASUREMENTS, Memory};
pub use vehicle::{Odometry, Planar, Vehicle};

use crate::kind::Kind;

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
