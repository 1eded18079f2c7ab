//! How far an estimate is from the truth.

pub mod assignment;
pub mod cutoff;
pub mod gospa;
pub mod ospa;
pub mod trajectory;
