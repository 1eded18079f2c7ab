//! One description of a vehicle in the plane, and the filter that is assembled from it.
//!
//! [`Description`] has plain numbers alone: how the vehicle moves, which filter it has, its sensors, its fixes of the pose, where it starts.
//! [`Description::check`] names the first setting that is out of range. [`Setting::all`] lists every setting with its name, unit, range and
//! meaning; [`Description::get`] and [`Description::set`] read and write it. Other languages and documents are made from that list.
//!
//! A [`Backing`] is the static memory of a filter. [`joint_backing!`] and [`mixture_backing!`] name one with its capacities, and
//! [`sets`] has some. [`Backing::start`] assembles the filter that is described. [`Slam`] has the calls of a loop for both filters, [`Services`]
//! those that are rare.
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
mod beside;
mod description;
mod drive;
mod error;
mod field;
mod fix_spec;
mod fixes;
mod joint;
mod list;
mod mixture;
mod planar;
mod rooms;
mod sensor;
pub mod sets;
mod setting;
mod settings;
mod slam;

pub use backing::Backing;
#[doc(hidden)]
pub use backing::MixtureState;
#[doc(hidden)]
pub use beside::Empty;
pub use beside::{ArchiveMemory, Behind, MoversMemory};
pub use description::{Description, Filter, JointFilter, SENSORS, Start};
pub use drive::{Control, Vehicle, VehicleKind};
pub use error::{Invalid, Refused, StartError};
pub use fix_spec::FixSpec;
pub use fixes::{Fixes, Watched};
pub use joint::Joint;
pub use mixture::Mixture;
pub use planar::PlanarState;
pub use rooms::{BearingRooms, PolarRooms, Rooms};
pub use sensor::{Direction, Measurements, Polar, Sensor, SensorModel};
pub use setting::Setting;
pub use slam::{Scanned, Services, Sink, Slam, Source};

#[doc(hidden)]
pub use scphd;
