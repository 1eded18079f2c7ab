//! Logs and scenarios as the binary stream that a vehicle computer reads (`docs/stream.md`).

mod black_box;
mod entry;
mod planar;
mod underwater;
mod worst_case;

pub use black_box::Recorded;
pub(crate) use black_box::replaying;
pub use entry::Stream;
pub use planar::write;
pub use underwater::write as write_underwater;
pub use worst_case::{worst_case, worst_case_joint};
