//! scphd on a GPU: many filters at once, or one large filter. A scan is a sequence of launches.
//!
//! A thread runs an ordinary function, a stage of a scan, which gets the index of the thread as its place. Stages and entry points
//! are compiled only for the target `nvptx64-nvidia-cuda`; a host has the buffers, the launches, and the library's own scan over the
//! same state.
#![cfg_attr(not(test), no_std)]
#![cfg_attr(target_arch = "nvptx64", feature(abi_ptx, stdarch_nvptx))]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

mod buffer;
mod launches;
mod memory;
mod setup;

#[cfg(target_arch = "nvptx64")]
#[expect(unsafe_code, reason = "threads share buffers")]
#[allow(unsafe_op_in_unsafe_fn, reason = "every stage has the contract of `run` in kernel.rs, for its whole body")]
mod device {
    mod group;
    mod joint;
    mod kernel;
    mod room;
    mod select;
    mod stages;
    mod store;
    mod tell;
}

pub use buffer::{Feature, Layout, Prediction, Run, Scan, ScanResult, Setup, Status};
pub use launches::{HELPERS, JOINT_LAUNCHES, LAUNCHES, Lists, Places};
pub use memory::{
    JointMemory, JointTracks, LARGE_PARTICLES, LargeMemory, MEASUREMENTS, Memory, PARTICLES, Particles, SAMPLES, Slot,
};
pub use setup::{Filter, Sensing, Sighted, control_of, over, setup_of};
