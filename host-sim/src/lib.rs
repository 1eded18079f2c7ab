//! Simulator, replayer and full-precision reference for the `scphd` SLAM filter.

pub mod angle;
pub mod log;
pub mod log_folder;
pub mod noise;
pub mod record;
pub mod score;

#[cfg(test)]
mod shared_data;
