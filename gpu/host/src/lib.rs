//! Many filters or large ones on a GPU, or by an interpreter of the same module: for `scphd-sim --device` and for the checks of the
//! program `scphd-gpu`.
//!
//! The measurements of all runs are stored in flat buffers ([`Batch`]). A device processes all scans. Its outputs are replayed
//! ([`Played`]) as if a filter had produced them. `docs/gpu.md` describes the layout.

mod batch;
mod cuda;
mod device;
mod failure;
mod interpreted;
mod played;
mod runs;

pub use batch::{Batch, Sort};
pub use cuda::Cuda;
pub use device::{Asked, Machine, Outcome};
pub use failure::Failure;
pub use interpreted::Interpreted;
pub use played::Played;
pub use runs::{Input, Took, run_all};

/// Default folder of the module, which `cargo xtask module` builds.
pub const MODULES: &str = "target/xtask/gpu/modules";
