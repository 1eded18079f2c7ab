//! A filter's stream over a serial line: frames that tell damage and loss, and what the vehicle answers.
//!
//! The records are those of `scphd-stream`, whole and unchanged, each in a frame of its own with a version, a session, a number
//! and a check, between zeros that stand nowhere else (consistent overhead byte stuffing). The line is whatever implements
//! [`embedded_io::Read`] and [`embedded_io::Write`]. `docs/link.md` has the layout of the bytes.
//!
//! * [`Sender`] puts records into frames.
//! * [`Receiver`] takes frames out of a line in a buffer of a size known from its type. Whatever is damaged, too long, doubled or
//!   out of order it refuses and counts in a [`Report`]; the next zero is where it goes on.
//! * [`Target`] is the vehicle's end of a test bench: it feeds a filter with what comes, and says in an [`Answer`] what state the filter
//!   is in, where the vehicle is, which record came last, and how long it took. `scphd-sim hil` is the other end.
//!
//! ```
//! use scphd_link::{Gaps, Received, Receiver, Refused, Sender};
//! # struct Wire(Vec<u8>);
//! # impl embedded_io::ErrorType for Wire {
//! #     type Error = core::convert::Infallible;
//! # }
//! # impl embedded_io::Write for Wire {
//! #     fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
//! #         self.0.extend_from_slice(bytes);
//! #         Ok(bytes.len())
//! #     }
//! #     fn flush(&mut self) -> Result<(), Self::Error> {
//! #         Ok(())
//! #     }
//! # }
//! let mut wire = Wire(Vec::new()); // anything with embedded_io::Write
//! let mut sender = Sender::<600>::new(7); // the session
//! sender.open(&mut wire, b"head", None)?;
//! sender.record(&mut wire, b"first", None)?;
//! sender.record(&mut wire, b"second", None)?;
//! let hit = wire.0.len() - 5;
//! wire.0[hit] ^= 1; // the line flips a bit of the last frame
//! sender.record(&mut wire, b"third", None)?;
//!
//! let mut receiver = Receiver::<512>::new(Gaps::Passed);
//! let mut line = &wire.0[..]; // anything with embedded_io::Read
//! let mut taken = Vec::new();
//! while let Some(received) = receiver.receive(&mut line).unwrap() {
//!     match received {
//!         Received::Frame { frame, lost } => taken.push((frame.content.to_vec(), lost)),
//!         Received::Refused { why, .. } => assert_eq!(why, Refused::Damaged),
//!     }
//! }
//! assert_eq!(taken, [(b"head".to_vec(), 0), (b"first".to_vec(), 0), (b"third".to_vec(), 1)]);
//! assert_eq!((receiver.report().damaged, receiver.report().lost), (1, 1));
//! # Ok::<(), scphd_link::SendError<core::convert::Infallible>>(())
//! ```
//!
//! No heap, no panics.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

#[cfg(test)]
extern crate std;

mod answer;
mod frame;
mod order;
mod receiver;
mod report;
mod sender;
mod target;

pub use answer::{Answer, Cost, Standing, Unit};
pub use frame::{Frame, FrameKind, OVERHEAD, Token, VERSION, line_bytes};
pub use order::Gaps;
pub use receiver::{Received, Receiver};
pub use report::{Refused, Report};
pub use sender::{SendError, Sender};
pub use target::Target;
