//! The inputs of a filter as a compact binary stream, and the loop that replays a stream.
//!
//! The same code runs on a vehicle computer and on a host: [`Reader`] and [`Writer`] for the format (`docs/stream.md`),
//! [`Filter`] for a filter in fixed memory that is constructed from the [`Header`] of a stream, and [`replay()`] for the loop,
//! which passes the digest of the filter's state after every scan to a [`Monitor`]. A flight that was recorded with the writer
//! can be replayed to the last bit.
//!
//! There are two kinds of stream, for planar vehicles ([`planar`]) and for underwater vehicles ([`underwater`]). These two
//! modules contain their differences: the numbers of models and records ([`Kind`]), the capacities of the memory, and the filter
//! ([`Aboard`]), which `scphd-vehicle` builds in the plane. Format and loop are generic over both.
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

pub use black_box::Saves;
pub use error::StreamError;
pub use find::{find_snapshot, find_whole_snapshot};
#[cfg(feature = "flips")]
pub use flips::{FLIP_SEEDS, Failing, Round, replay_with_flips};
pub use front::{Begins, Mark};
pub use head::Head;
pub use header::{Header, Parameters, Settings, UNKNOWN};
pub use kind::{Input, Kind};
pub use numbers::Numbers;
pub use onboard::{Aboard, Capacities, Filter, RamPart, Refusal, Scan, Seen};
pub use piecewise::{Piece, Piecewise, pieces};
pub use reader::Reader;
pub use record::{Features, How, Later, Measurements, Part, Place, Record, Shown, Which};
pub use recover::{Recovered, recover};
pub use replay::{Monitor, ReplayError, ScanCost, Totals, replay};
pub use rerecord::{RerecordError, rerecord};
pub use scalar::Scalar;
pub use snapshot::Snapshot;
pub use writer::Writer;
