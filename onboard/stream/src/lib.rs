//! A filter's inputs as a compact binary stream, and the loop that feeds one to the filter.
//!
//! The same code runs on a vehicle computer and on a desk: [`Reader`] and [`Writer`] for the format
//! (`docs/stream.md`), [`Filter`] for a filter in fixed memory that is set up from a stream's [`Header`], and
//! [`replay()`] for the loop, which tells a [`Monitor`] the digest of the filter's state after every scan. Whoever logs a
//! flight with the writer can replay it to the last bit.
//!
//! There are two kinds of stream, of vehicles in the plane ([`planar`]) and under water ([`underwater`]). What they differ in
//! is in these two modules: the numbers of models and records ([`Kind`]), the capacities of the memory and the models
//! made of the numbers ([`Aboard`]). Format, filter and loop are written once over both.
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

mod black_box;
mod bytes;
mod error;
mod find;
#[cfg(feature = "flips")]
mod flips;
mod front;
mod head;
mod header;
mod joint;
mod kind;
mod numbers;
mod onboard;
mod piecewise;
pub mod planar;
mod reader;
mod record;
mod recover;
mod replay;
mod rerecord;
mod scalar;
mod snapshot;
pub mod underwater;
mod writer;

pub use black_box::{BlackBoxFilter, Saves};
pub use error::StreamError;
pub use find::{find_snapshot, find_whole_snapshot};
#[cfg(feature = "flips")]
pub use flips::{FLIP_SEEDS, Failing, Round, replay_with_flips};
pub use front::{Begins, Mark};
pub use head::Head;
pub use header::{Extraction, Header, Joint, Moving, Proposal, Recursion, UNKNOWN};
pub use joint::{Beside, JointMemory, OnboardJoint, Tracks};
pub use kind::{Input, Kind};
pub use numbers::Numbers;
pub use onboard::{Aboard, Capacities, Filter, Helm, Memory, Onboard, RamPart, Refusal, Scan, Seen};
pub use piecewise::{Piece, Piecewise, pieces};
pub use reader::Reader;
pub use record::{Features, How, Later, Measurements, Part, Place, Record, Shown, Which};
pub use recover::{Recovered, recover};
pub use replay::{Monitor, ReplayError, ScanCost, Totals, replay};
pub use rerecord::{RerecordError, rerecord};
pub use scalar::Scalar;
pub use snapshot::Snapshot;
pub use writer::Writer;
