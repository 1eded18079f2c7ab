//! The arithmetic: scalars, vectors, symmetric matrices, random numbers, sums of logarithms.

pub(crate) mod angle;
pub(crate) mod bounds;
#[cfg(any(test, feature = "flips"))]
pub(crate) mod flip;
pub(crate) mod fnv;
pub(crate) mod links;
pub(crate) mod ln_sum;
pub(crate) mod noise;
#[cfg(test)]
mod properties;
pub(crate) mod range;
pub(crate) mod real;
pub(crate) mod single;
pub(crate) mod sort;
pub(crate) mod symmetric;
pub(crate) mod triangle;
pub(crate) mod vector;
pub(crate) mod work;
pub(crate) mod zero;

pub use angle::wrap;
pub use bounds::Bounds;
pub use ln_sum::LnSum;
pub use nalgebra;
pub use noise::Noise;
pub use symmetric::{Factor, Symmetric};
pub use vector::{Array, Linear, Matrix, Place, Vector};
pub use zero::Zero;
