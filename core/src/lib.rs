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
mod gaussian;
mod ln_sum;
mod models;
mod noise;
mod real;
mod symmetric;

pub use angle::wrap;
pub use bounds::Bounds;
pub use gaussian::{Correction, Gaussian};
pub use ln_sum::LnSum;
pub use models::*;
pub use noise::Noise;
pub use real::Real;
pub use symmetric::{Dim, Factor, Lower, Packed, Symmetric};
