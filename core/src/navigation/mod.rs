//! Navigation filters outside the SLAM filter: the velocity of the vehicle, and dead reckoning without a map.

mod dead_reckoning;
mod kalman;
mod navigator;
mod snapshot;
mod velocity_filter;

pub use dead_reckoning::DeadReckoning;
pub use kalman::Outcome;
pub use navigator::{Instruments, Navigator};
pub use velocity_filter::{VelocityFilter, VelocityNoise};
