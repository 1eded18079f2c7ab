//! Builds a SLAM filter from a description of a vehicle in the plane.
//!
//! [`Description`] has only numbers: motion model, kind of filter, sensors, measurements of the pose (fixes), initial pose.
//! [`Description::check`] returns the first setting that is out of range. [`Setting::all`] lists the settings with name, unit, range
//! and meaning; [`Description::get`] and [`Description::set`] read and write one. Bindings and documents are generated from this list.
//!
//! A [`Backing`] is the static memory of a filter. [`joint_backing!`] and [`mixture_backing!`] declare a type of it with given capacities;
//! [`sets`] has ready ones. [`Backing::start`] builds the filter from a description. [`Slam`] has the calls of a loop, the same for both
//! filters, and [`Services`] has those outside of it.
//!
//! ```
//! use nalgebra::Vector2;
//! use scphd_vehicle::{Backing, Control, Description, Measurements, Sensor, Slam, sets::Joint40};
//!
//! let mut robot = Description::<f32>::robot();
//! robot.sensors[0] = Some(Sensor::range_bearing(15.0, 0.9, [0.2, 0.02]));
//! let mut memory = Box::new(Joint40::new());
//! let mut slam = memory.start(&robot).unwrap();
//! slam.reset(&robot.start)?;
//! slam.predict(Control { speed_mps: 1.0, ..Control::STILL }, 0.1)?;
//! slam.scan(0, Measurements::RangeBearing(&[Vector2::new(5.0, 0.3)])).unwrap();
//! assert!(slam.pose().is_some());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

mod backing;
mod description;
mod detectors;
mod drive;
mod error;
mod field;
mod fix_spec;
mod fixes;
mod joint;
mod list;
mod mixture;
mod numbers;
mod optional;
mod planar;
mod ranging;
mod rooms;
mod sensor;
pub mod sets;
mod setting;
mod settings;
mod slam;

pub use backing::{Backing, JointBacking};
#[doc(hidden)]
pub use backing::{MixtureState, numbers};
pub use description::{Description, Filter, JointSettings, SENSORS, Start};
pub use drive::{Control, Vehicle, VehicleKind};
pub use error::{Invalid, Refused, StartError};
pub use fix_spec::FixSpec;
pub use fixes::{Fixes, Watched};
pub use joint::Joint;
pub use mixture::Mixture;
pub use numbers::numbers_of_sensor;
#[doc(hidden)]
pub use optional::Empty;
pub use optional::{ArchiveMemory, HypothesesMemory, MoversMemory};
pub use planar::PlanarState;
pub use ranging::{Ranging, SameNoise};
pub use rooms::{BearingRooms, PolarRooms, Rooms};
pub use sensor::{Direction, Measurements, Polar, Sensor, SensorModel};
pub use setting::Setting;
pub use slam::{Recordable, Scanned, Services, Sink, Slam, Source};

#[doc(hidden)]
pub use scphd;
