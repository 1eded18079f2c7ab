//! Messages of ROS 2, in CDR, in MCAP files: what a run is written with for Foxglove, rerun and rosbag tools, and what a recording
//! is read from.
//!
//! Nothing here knows of filters or logs. A message is a plain struct with the fields of its definition, in their order and with their
//! units.
//!
//! | file | |
//! |---|---|
//! | `time.rs` | stamps in nanoseconds |
//! | `definition.rs` | definitions as a file has them, each with all that it is made of |
//! | `cdr.rs` | bytes of a message |
//! | `messages/` | one family of messages each |
//! | `cloud.rs` | the numbers in a `PointCloud2` |
//! | `write.rs`, `read.rs` | MCAP files; `unpack.rs`: compressed chunks, messages and files |
//!
//! What is damaged, torn off or of another type is an error that says where; nothing panics.

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
pub use definition::{Definition, Message, full_text};
pub use read::{Channel, ReadError, ReadProblem, Reader, Record};
pub use time::{Duration, Time, TimeError};
pub use unpack::{message as unpacked_message, unpacked};
pub use write::{WriteError, Writer};
