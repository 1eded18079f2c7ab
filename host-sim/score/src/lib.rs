//! Scores: comparison of estimates with the truth.

pub mod alignment;
pub mod assignment;
pub mod chi_squared;
pub mod consistency;
pub mod cutoff;
pub mod final_map;
pub mod gospa;
pub mod map_error;
pub mod moving;
pub mod ospa;
pub mod record;
pub mod results;
pub mod trajectory;

#[cfg(test)]
mod dead_reckoning;
