//! SLAM filters with one interface for the simulator: the fixed-capacity filter in either precision, the filter with a joint map,
//! and the reference.

mod config;
pub mod contract;
mod core_filter;
mod filter;
mod fix_watch;
mod fixes;
mod in_map;
mod joint_filter;
mod joint_room;
mod joint_snapshot;
mod models;
mod nearby;
mod planar;
mod planar_numbers;
mod reference_filter;
mod stage_times;
mod underwater;

/// Greatest number of measurements in a scan, for all filters of the host except the EKF.
pub const MEASUREMENTS: usize = 256;

pub(crate) use config::config_of;
pub use contract::refusal;
pub use contract::{FoundPlace, PoseAndCovariance, Refusal, ScanOutcome, Search, Slam};
pub use core_filter::{Snapshot, Transparent};
pub use filter::{Filter, Precision};
pub(crate) use fix_watch::{NoFixes, PlanarWatch};
pub use fix_watch::{Taken, WatchesFixes};
pub use joint_filter::OpenJoint;
pub use models::{feature_of, full, moving_of};
pub(crate) use nearby::started_nearby;
pub(crate) use planar::odometry_prior;
pub use planar::range_bearing;
pub use planar::{core_filter, joint_config, joint_filter};
pub use planar_numbers::PlanarNumbers;
pub use reference_filter::ReferenceFilter;
pub use reference_filter::{joint_config_of, joint_references_of, references_of};
pub use scphd_stream::underwater::joint_config as underwater_joint_config;
pub use stage_times::STAGES;
pub use underwater::{core_filter as underwater_core_filter, joint_filter as underwater_joint_filter};
