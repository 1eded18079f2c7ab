//! Export of runs for other programs, and import of other formats as logs.
//!
//! | folder or file | |
//! |---|---|
//! | `tum.rs` | export of trajectories as text |
//! | `mcap/` | export of a run as messages of ROS 2 |
//! | `import/` | import of other formats |

pub mod calendar;
pub mod import;
pub mod mcap;
pub mod tum;
