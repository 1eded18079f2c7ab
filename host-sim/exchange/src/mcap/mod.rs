//! A run as an MCAP file with messages of ROS 2; docs/logs.md lists topics, types, frames and units.
//!
//! | file | |
//! |---|---|
//! | `shape.rs` | poses, covariances and ellipses of messages |
//! | `kind.rs` | what a kind of vehicle adds: its sensors, what it was told |
//! | `run.rs` | the file |

mod kind;
mod run;
mod shape;

pub use kind::Exported;
pub use run::{Attached, ExportError, check, write};

/// The frame of the map.
pub(crate) const MAP: &str = "map";
/// The frame of the smooth odometry.
pub(crate) const ODOM: &str = "odom";
/// The frame of the vehicle's pose.
pub(crate) const BASE: &str = "base_link";
/// A variance that says that a number is unknown, m² or rad².
pub(crate) const UNKNOWN: f64 = 1e6;

/// Topics.
pub(crate) mod topic {
    pub(crate) const ESTIMATE: &str = "/scphd/estimate";
    pub(crate) const ODOMETRY: &str = "/scphd/odometry";
    pub(crate) const TRUTH: &str = "/scphd/truth";
    pub(crate) const FEATURES: &str = "/scphd/features";
    pub(crate) const MAP: &str = "/scphd/map";
    pub(crate) const LANDMARKS: &str = "/scphd/landmarks";
    pub(crate) const DETECTIONS: &str = "/scphd/detections";
    pub(crate) const INPUT_ODOMETRY: &str = "/scphd/input/odometry";
    pub(crate) const INPUT_WHEELS: &str = "/scphd/input/wheels";
    pub(crate) const INPUT_FIX: &str = "/scphd/input/fix";
    pub(crate) const TF: &str = "/tf";
    pub(crate) const TF_STATIC: &str = "/tf_static";
}

/// Joints of [`topic::INPUT_WHEELS`]: the speed of the first, m/s, and the angle of the second, rad.
pub(crate) const JOINTS: [&str; 2] = ["drive", "steering"];
