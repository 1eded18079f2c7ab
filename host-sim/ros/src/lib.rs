//! Messages of ROS 2, in CDR and in MCAP files: for exporting runs to Foxglove, rerun and rosbag tools, and for importing
//! recordings.
//!
//! This crate does not depend on filters or logs. A message is a plain struct with the fields of its definition, in the same
//! order and units.
//!
//! | file | |
//! |---|---|
//! | `time.rs` | time stamps in nanoseconds |
//! | `definition.rs` | definitions in the format of files, each with all types in it |
//! | `cdr.rs` | encoding of messages |
//! | `messages/` | a family of messages in each file |
//! | `cloud.rs` | the numbers in a `PointCloud2` |
//! | `write.rs`, `read.rs` | MCAP files; `unpack.rs`: compressed chunks, messages and files |
//!
//! Damaged or truncated data, or data of another type, give an error with its place; there are no panics.

mod cdr;
mod cloud;
mod definition;
pub mod messages;
mod read;
mod time;
mod unpack;
mod write;

pub use cdr::{CdrError, decode, encode};
pub use cloud::{Cloud, CloudError, cloud};
pub use definition::{Definition, Field, Kind, Message, full_text};
pub use read::{Channel, ReadError, ReadProblem, Reader, Record};
pub use time::{Duration, Time, TimeError};
pub use unpack::{message as unpacked_message, unpacked};
pub use write::{WriteError, Writer};
