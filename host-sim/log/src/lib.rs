//! Recorded logs: folders, truth, events in order of time, and motion models of the vehicles.

pub mod angle;
pub mod dimensions;
pub mod events;
pub mod lines;
pub mod log;
pub mod log_folder;
pub mod noise;
pub mod truth;
pub mod underwater;
pub mod vehicle;
