//! Snapshots: a filter that is restored goes on to the bit, and nothing that is not whole is taken.

mod crafted;
mod damaged;
mod elsewhere;
mod goes_on;
pub(super) mod world;
