//! scphd on a GPU, or the same threads on the host: Monte Carlo studies with one thread for each candidate or map of many
//! filters or one block for each of many joint maps, and single large filters.
//!
//! The measurements of all runs are simulated here and stored in flat buffers ([`Batch`]). A device ([`Machine`]) processes all
//! scans. Its outputs are [replayed](Played) to the simulator's scores as if a filter had produced them. `docs/gpu.md` describes the
//! layout.
#![deny(missing_docs)]

mod batch;
mod check;
mod cuda;
mod device;
mod emulated;
mod interpreted;
mod played;
mod source;
mod study;

pub use batch::{Batch, Sort, Unfit};
pub use check::{StudyError, on_host};
pub use cuda::{Cuda, Modules};
pub use device::{DeviceError, Kernels, Launch, Machine, Outcome};
pub use emulated::Emulated;
pub use interpreted::Interpreted;
pub use played::Played;
pub use source::{FilterName, Source, SourceError, Tuning};
pub use study::{Checked, Difference, Short, Studied, Took, check, study};
