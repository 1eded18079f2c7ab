//! Names and numbers shared by all messages of a run.

/// The frame of the map.
pub const MAP: &str = "map";
/// The frame of the smooth odometry.
pub const ODOM: &str = "odom";
/// The frame of the vehicle's pose.
pub const BASE: &str = "base_link";
/// The variance of an unknown quantity, m² or rad².
pub const UNKNOWN: f64 = 1e6;

pub mod topic {
    pub const ESTIMATE: &str = "/scphd/estimate";
    pub const ODOMETRY: &str = "/scphd/odometry";
    pub const TRUTH: &str = "/scphd/truth";
    pub const FEATURES: &str = "/scphd/features";
    pub const MAP: &str = "/scphd/map";
    pub const LANDMARKS: &str = "/scphd/landmarks";
    pub const DETECTIONS: &str = "/scphd/detections";
    pub const INPUT_ODOMETRY: &str = "/scphd/input/odometry";
    pub const INPUT_WHEELS: &str = "/scphd/input/wheels";
    pub const INPUT_FIX: &str = "/scphd/input/fix";
    pub const TF: &str = "/tf";
    pub const TF_STATIC: &str = "/tf_static";
}

/// Joints of [`topic::INPUT_WHEELS`]: the speed of the first, m/s, and the angle of the second, rad.
pub const JOINTS: [&str; 2] = ["drive", "steering"];
