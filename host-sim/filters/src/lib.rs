//! Filters over logs, their settings, and the parts that depend on the kind of vehicle.

pub mod describe;
pub mod ekf;
pub mod kind;
pub mod settings;
pub mod slam;
pub mod threads;
pub mod underwater;
pub mod window;
