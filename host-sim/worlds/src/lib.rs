//! Simulated scenarios and random worlds, in the plane and under water.

pub mod scenario;
pub mod underwater;
