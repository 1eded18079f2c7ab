//! The state as bytes: the traversal of a state by a visitor, and the frame in which it is written and read. Each filter defines
//! its own traversal. `docs/snapshot.md` has the format.

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
