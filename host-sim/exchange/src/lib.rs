//! A run as files that other programs read, and files of others as logs.
//!
//! | folder or file | |
//! |---|---|
//! | `tum.rs` | trajectories as text |
//! | `mcap/` | a run as messages of ROS 2 |
//! | `import/` | logs of files of others |

pub mod calendar;
pub mod import;
pub mod mcap;
pub mod tum;
