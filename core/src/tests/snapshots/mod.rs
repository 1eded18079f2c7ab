//! Snapshots: a restored filter continues with the same bits, and incomplete snapshots are refused.

mod crafted;
mod damaged;
mod elsewhere;
mod goes_on;
pub(super) mod world;
