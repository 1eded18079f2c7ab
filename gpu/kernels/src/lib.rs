//! scphd on a GPU: one run of the filter for each thread, over a whole scenario; or one large filter, of which every thread weighs a
//! candidate and updates a map.
//!
//! What a thread does is an ordinary function, [`thread`](thread()) or one of the [stages](STAGES) of a scan, that gets its place as a
//! number. `kernel.rs` has the entry points of the device, which call it, and the panic handler; it is compiled for the target
//! `nvptx64-nvidia-cuda` alone. On a host the same function is called for the same places, over the same buffers. `docs/gpu.md` says how
//! buffers are laid out and what it costs.
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
mod slot;

mod run;
mod thread;

mod large;
mod room;

#[cfg(target_arch = "nvptx64")]
mod kernel;

pub use buffer::{Feature, Mover, Prediction, Run, Scan, ScanResult, Status};
pub use large::{Body, PREDICT, Places, STAGES, START, Stage};
pub use room::{Desk, DraftPlace, LARGE_PARTICLES, Large, LargeSlot, Room, Sight, large_bytes};
pub use run::{Inputs, Outputs, Span, follow};
pub use setup::{MOUNTED, Setup, extraction, likelihood, vehicle};
pub use slot::{FEATURES, MEASUREMENTS, MOVERS, PARTICLES, SAMPLES, Slot, SlotOf};
pub use thread::{Launch, thread};
