//! The firmware: images for all boards, run in QEMU and compared with the host bit by bit.

pub mod board;
mod digests;
pub mod emulator;
mod faults;
mod flips;
mod guide;
mod hil;
pub mod image;
mod library;
pub mod output;
mod proof;
pub mod rig;
mod rtos;
mod stack;
pub mod streams;
mod thumb;
mod workbench;

pub use digests::{robot, step as digests};
pub use hil::step as hil;
pub use proof::{PROOF, step as proof};
pub use rtos::step as rtos;
