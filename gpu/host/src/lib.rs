//! scphd on a GPU, or the same threads on the host: Monte Carlo studies with one thread for each candidate or map of many
//! filters, and single large filters.
//!
//! The measurements of all runs are simulated here and stored in flat buffers ([`Batch`]). A [`Device`] processes all scans. Its
//! outputs are [replayed](Played) to the simulator's scores as if a filter had produced them. `docs/gpu.md` describes the layout.
#![deny(missing_docs)]

mod setup;
mod unfit;

mod batch;
mod device;

mod cuda;
mod emulated;
mod interpreted;
mod played;

mod source;

mod check;
mod study;

mod large;

pub use batch::{Batch, MOVERS_A_SCAN, SPARE_FEATURES};
pub use check::{Checked, Difference, digests_of_host, drive_on_host};
pub use cuda::{Cuda, Modules};
pub use device::{Device, DeviceError, Outcome};
pub use emulated::Emulated;
pub use interpreted::{Execution, Interpreted};
pub use large::{LargeRun, large};
pub use played::Played;
pub use setup::setup_of;
pub use source::{Source, SourceError, Tuning};
pub use study::{Short, Studied, StudyError, Took, study, time};
pub use unfit::Unfit;
