//! scphd on a GPU: many filters at once, or one large filter. A scan is a sequence of launches.
//!
//! A thread runs an ordinary function, a [stage](Stage) of a scan, which gets the index of the thread as its place. `kernel.rs`
//! has the entry points of the device, which call the stages, and the panic handler; it is compiled only for the target
//! `nvptx64-nvidia-cuda`. A host calls the same functions for the same places, over the same buffers. `docs/gpu.md` describes the
//! layout of the buffers and the cost.
#![cfg_attr(not(test), no_std)]
#![cfg_attr(target_arch = "nvptx64", feature(abi_ptx, stdarch_nvptx))]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

mod buffer;
mod setup;
mod size;
mod slot;

mod run;

mod group;
mod joint;
mod kind;
mod room;
mod select;
mod stages;
mod store;
mod tell;

#[cfg(target_arch = "nvptx64")]
mod kernel;

pub use buffer::{Feature, Prediction, Run, Scan, ScanResult, Status, halves, joined};
pub use joint::{HELPERS, JOINT_FEATURES, Joint};
pub use kind::{Kind, Particles};
pub use room::{Filters, Group, PartPlace, Room, Sight, Size, TOGETHER, bytes, parts, streams, words};
pub use run::{Inputs, Outputs, asks_for_digest, follow};
pub use setup::{Setup, setup_of};
pub use size::{LARGE_PARTICLES, LargeMemory, Memory, PARTICLES, SAMPLES};
pub use slot::{FEATURES, MEASUREMENTS, MOVERS, Slot};
pub use stages::{Launches, Places, Stage};
