//! Simulator, replayer and full-precision reference for the `scphd` SLAM filter.

pub mod log;
pub mod record;
pub mod reference;
