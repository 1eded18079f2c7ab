//! A filter's inputs as a compact binary stream, and the loop that feeds one to the filter.
//!
//! The same code runs on a vehicle computer and on a desk: [`Reader`] and [`Writer`] for the format
//! (`docs/stream.md`), [`Onboard`] for a filter in fixed memory that is set up from a stream's [`Header`], and
//! [`replay()`] for the loop, which tells a [`Monitor`] the digest of the filter's state after every scan. Whoever logs a
//! flight with the writer can replay it to the last bit.
//!
//! No heap, no panics; everything a filter of the library is made of is named in `onboard.rs`, and nowhere else.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

#[cfg(test)]
extern crate std;

mod bytes;
mod header;
mod onboard;
mod reader;
mod replay;
mod writer;

pub use header::{Extraction, Header, Likelihood, Proposal, Reduction, Scalar, UNKNOWN, Vehicle};
pub use onboard::{
    CAPACITIES, Capacities, MEASUREMENTS, Memory, Onboard, RamPart, Refusal, Scan, Seen, memory, ram_parts,
};
pub use reader::{Measurements, Reader, Record, StreamError};
pub use replay::{Monitor, ReplayError, ScanCost, Totals, replay};
pub use writer::Writer;
