//! Single-cluster PHD SLAM in fixed memory.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

#[cfg(test)]
extern crate std;

mod angle;
mod bounds;
mod candidate;
mod config;
mod digest;
mod error;
mod extract;
#[cfg(test)]
mod faults;
mod filter;
mod gaussian;
mod health;
mod ln_sum;
mod map;
mod models;
mod noise;
#[cfg(test)]
mod oracles;
mod predict;
mod real;
mod reduce;
mod report;
mod resample;
mod scan;
mod select;
mod sort;
mod state;
mod step;
mod symmetric;
mod update;
mod view;
mod weigh;
mod workspace;

pub use angle::wrap;
pub use bounds::Bounds;
pub use candidate::Candidate;
pub use config::{Config, ConfigError};
pub use error::{LoadMapError, PredictError, ResetError, ScanError, SetupError};
pub use extract::{MapEstimate, PoseEstimate};
pub use filter::ScPhd;
pub use gaussian::{Correction, Gaussian};
pub use health::Health;
pub use ln_sum::LnSum;
pub use map::PAGE_LEN;
pub use models::*;
pub use noise::Noise;
pub use real::Real;
pub use report::{PredictReport, ScanReport};
pub use state::State;
pub use symmetric::{Dim, Factor, Lower, Packed, Symmetric};
