//! Simulator, replayer and full-precision reference for the `scphd` SLAM filter.

pub mod angle;
pub mod compare;
pub mod dimensions;
pub mod ekf;
pub mod events;
pub mod figure;
pub mod kind;
pub mod log;
pub mod log_folder;
pub mod monte_carlo;
pub mod noise;
pub mod output;
pub mod plot;
pub mod point_process;
pub mod record;
pub mod reference;
pub mod scenario;
pub mod score;
pub mod session;
pub mod settings;
pub mod slam;
pub mod stream;
pub mod tally;
pub mod threads;
pub mod truth;
pub mod tune;
pub mod underwater;
pub mod vehicle;

#[cfg(test)]
mod shared_data;
