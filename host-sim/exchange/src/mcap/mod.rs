//! A run as an MCAP file with messages of ROS 2; docs/logs.md lists topics, types, frames and units.
//!
//! | file | |
//! |---|---|
//! | `names.rs` | frames, topics and joints |
//! | `shape.rs` | poses, covariances and ellipses in messages |
//! | `kind.rs` | parts that depend on the kind of vehicle: sensors, inputs |
//! | `run.rs` | the file |

mod kind;
mod names;
mod run;
pub mod shape;

pub use kind::Exported;
pub use names::{BASE, JOINTS, MAP, ODOM, UNKNOWN, topic};
pub use run::{Attached, ExportError, check, features, inputs, write};
