//! A run as an MCAP file with messages of ROS 2; docs/logs.md lists topics, types, frames and units.
//!
//! | file | |
//! |---|---|
//! | `names.rs` | frames, topics and joints |
//! | `shape.rs` | poses, covariances and ellipses of messages |
//! | `kind.rs` | what a kind of vehicle adds: its sensors, what it was told |
//! | `run.rs` | the file |

mod kind;
mod names;
mod run;
pub mod shape;

pub use kind::Exported;
pub use names::{BASE, JOINTS, MAP, ODOM, UNKNOWN, topic};
pub use run::{Attached, ExportError, check, features, inputs, write};
