//! The firmware: images for every board, run in QEMU, compared with the host bit by bit.

pub mod board;
mod digests;
pub mod emulator;
pub mod image;
mod library;
pub mod output;
mod proof;
mod stack;
pub mod streams;
mod thumb;

pub use digests::{image_name, step as digests};
pub use proof::{PROOF, step as proof};
