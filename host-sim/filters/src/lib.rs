//! Filters over logs: what they are tuned with, and what a kind of vehicle supplies for them.

pub mod describe;
pub mod ekf;
pub mod kind;
pub mod settings;
pub mod slam;
pub mod threads;
pub mod underwater;
pub mod window;
