//! MAVLink 2 messages between a filter and PX4 or ArduPilot: the pose of the filter, and the inputs that they have for it.
//!
//! A [`Sender`] makes frames of [`Odometry`], [`VisionPosition`], [`Heartbeat`] and [`TimeSync`]; a [`Receiver`] finds
//! [`Incoming`] messages in the bytes of a serial line or of UDP. A [`ResetCounter`] counts jumps of the pose, a [`Clock`]
//! converts time stamps to our clock.
//!
//! All values are in our axes: x ahead or east, y left or north, z up, angles to the left. [`MapFrame`] selects the corresponding
//! frame of MAVLink, and transforms positions, angles and covariances in both directions. Every loop is bounded by the number of
//! bytes, and data that cannot be used is counted.
//!
//! ```
//! use scphd_mavlink::{Incoming, MapFrame, Odometry, OffPlane, Pose, Receiver, ResetCounter, Sender};
//!
//! let mut resets = ResetCounter::new(0.5, 0.1);
//! let (before, after) = ([3.0, 1.0, 0.1], [3.9, 1.2, 0.1]); // x, y, heading before a scan and after it
//! resets.between(before, after);
//! let pose = Pose::planar(after, &[[0.04, 0.0, 0.0], [0.0, 0.09, 0.0], [0.0, 0.0, 0.01]], OffPlane::FLAT);
//! let odometry =
//!     Odometry { time_us: 1_000_000, frame: MapFrame::Local, pose, twist: None, reset_counter: resets.value() };
//! let frame = Sender::new(1, Sender::VISUAL_ODOMETRY).frame(&odometry); // its bytes go to the flight stack
//!
//! let (mut receiver, mut bytes) = (Receiver::new(), &frame[..]);
//! let received = receiver.read(&mut bytes).unwrap();
//! let Incoming::Odometry(read) = received.message else { panic!() };
//! assert_eq!((read.reset_counter, read.pose.covariance), (1, pose.covariance));
//! ```
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

#[cfg(test)]
extern crate std;

mod axes;
mod bytes;
mod clock;
mod frame;
mod heartbeat;
mod pose;
mod receiver;
mod reset;
mod satellite;
mod target;

pub use axes::MapFrame;
pub use clock::{Clock, TimeSync};
pub use frame::{FRAME, Outgoing, Payload, Sender};
pub use heartbeat::Heartbeat;
pub use pose::{Odometry, OffPlane, Pose, Twist, VisionPosition};
pub use receiver::{Incoming, Received, Receiver, Report};
pub use reset::ResetCounter;
pub use satellite::{Origin, Satellite};
pub use target::Target;
