//! The C interface of [`scphd`].
//!
//! The user's memory is initialised in place as a filter, a detector or a description (`memory.rs`); functions then receive a
//! pointer to it. The types of pointers from C state what is required of them (`pointer.rs`). These two files have all `unsafe`
//! code, except the declaration of a function that the panic handler calls and nobody defines. All other files convert arguments
//! and results.
//!
//! The package `header` generates `include/scphd.h` from this crate; `docs/c.md` is its documentation.
#![cfg_attr(not(test), no_std)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]
// The names of C.
#![allow(non_camel_case_types)]

// In the order of the header.
mod version;

mod status;

mod block;
mod memory;
mod pointer;
mod reason;
mod sets;

mod fix;
mod map;
mod pose;
mod report;

mod description;
mod running;
mod slam;
mod starts;

mod sonar;

mod water;

mod sizes;

#[cfg(all(feature = "archive", not(test)))]
mod panic;

pub use description::*;
pub use fix::{scphd_fix, scphd_fix_report};
pub use map::{scphd_feature, scphd_feature_3d, scphd_map, scphd_mover, scphd_range_bearing};
pub use memory::{scphd_memory_alignment, scphd_release};
pub use pointer::{Bytes, Handed, In, Out};
pub use pose::{scphd_odometry, scphd_plane_pose, scphd_water_pose};
pub use reason::scphd_reason;
pub use report::*;
pub use running::scphd_slam;
pub use sets::{SETS, Set};
pub use slam::*;
pub use sonar::*;
pub use starts::*;
pub use status::{scphd_error_text, scphd_status};
pub use version::{SCPHD_ABI_VERSION, scphd_abi_version};
pub use water::*;
