//! scphd on a GPU, or the same threads on the host: Monte Carlo studies with every run a thread, and one large filter.
//!
//! The measurements of all runs are simulated here and laid into flat buffers ([`Batch`]); a [`Device`] takes them through the whole
//! scenario; what it leaves is [played](Played) to the simulator's scores as if a filter had said it. `docs/gpu.md` has the layout.
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
