//! The state as bytes: what walks through it, and the frame in which it is written down and read again. What there is to walk
//! through stands with each filter. `docs/snapshot.md` has every byte.

mod bytes;
mod error;
pub(crate) mod frame;
mod map;
pub(crate) mod pages;
pub(crate) mod read;
pub(crate) mod visit;
mod watch;
pub(crate) mod write;

pub use bytes::{SliceEnd, from_slice, into_slice};
pub use error::{RestoreError, SaveError};
pub use map::{restore_map, save_map};
