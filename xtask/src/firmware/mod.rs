//! The firmware: images for every board, run in QEMU, compared with the host bit by bit.

pub mod board;
mod digests;
pub mod emulator;
pub mod image;
pub mod output;
mod proof;
pub mod streams;

pub use digests::{image_name, step as digests};
pub use proof::step as proof;
