//! A filter's stream over a serial line: frames that detect damage and loss, and the status that the vehicle sends back.
//!
//! Each frame contains one complete record of `scphd-stream`, with a version, a session, a number and a checksum, between zeros
//! that occur nowhere else (consistent overhead byte stuffing). The line is any type that implements [`embedded_io::Read`] and
//! [`embedded_io::Write`]. `docs/link.md` has the format.
//!
//! * [`Sender`] sends records in frames.
//! * [`Receiver`] receives frames, in a buffer whose size is part of its type. It refuses frames that are damaged, too long,
//!   duplicate or out of order, counts them in a [`Report`], and continues at the next zero.
//! * [`Target`] is the vehicle's side of a test bench: it passes the records to a filter, and reports its state, the pose, the
//!   last record and the cost in an [`Answer`]. `scphd-sim hil` is the other side.
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
