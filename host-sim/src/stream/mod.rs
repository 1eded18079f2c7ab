//! Logs and scenarios as the binary stream that a vehicle computer reads (`docs/stream.md`).

mod entry;
mod planar;
mod underwater;
mod worst_case;

pub use entry::Stream;
pub use planar::write;
pub use underwater::write as write_underwater;
pub use worst_case::worst_case;
