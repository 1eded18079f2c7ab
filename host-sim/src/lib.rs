//! Simulator, replayer and full-precision reference for the `scphd` SLAM filter.

pub mod log;
pub mod output;
pub mod plot;
pub mod record;
