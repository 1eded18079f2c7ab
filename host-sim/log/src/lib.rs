//! Recorded logs: the folders that they are in, what is true in them, their events in order of time, and how their vehicles move.

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
