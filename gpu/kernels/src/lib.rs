//! scphd on a GPU: many filters at once, or one large filter, a scan as a sequence of launches.
//!
//! What a thread does is an ordinary function, a [stage](Stage) of a scan, that gets its place as a number. `kernel.rs` has the entry points of
//! the device, which call it, and the panic handler; it is compiled for the target `nvptx64-nvidia-cuda` alone. On a host the same function is
//! called for the same places, over the same buffers. `docs/gpu.md` says how buffers are laid out and what it costs.
#![cfg_attr(not(test), no_std)]
#![cfg_attr(target_arch = "nvptx64", feature(abi_ptx, stdarch_nvptx))]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

mod buffer;
mod motion;
mod setup;
mod size;
mod slot;

mod run;

mod group;
mod room;
mod select;
mod stages;
mod store;
mod tell;

#[cfg(target_arch = "nvptx64")]
mod kernel;

pub use buffer::{Feature, Mover, Prediction, Run, Scan, ScanResult, Status};
pub use motion::Vehicle;
pub use room::{
    Desk, DraftPlace, Filters, Group, PartPlace, Room, Sight, StreamPlace, TOGETHER, bytes, parts, streams, words,
};
pub use run::{Inputs, Outputs, asks_for_digest, follow};
pub use setup::{MOUNTED, Setup, extraction, vehicle};
pub use size::{LARGE_PARTICLES, LargeMemory, Memory, PARTICLES, SAMPLES, Size};
pub use slot::{FEATURES, MEASUREMENTS, MOVERS, Slot};
pub use stages::{Places, Stage};
