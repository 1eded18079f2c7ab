//! Tests of the whole filter.

pub(crate) mod alone;
mod faults;
pub(crate) mod flips;
mod in_space;
mod informed;
pub(crate) mod linear;
mod lying;
#[cfg(all(test, feature = "adaptive"))]
mod mismatch;
mod movers;
mod observing;
mod oracles;
mod peaks;
mod scrubbing;
mod smallest;
mod snapshots;
mod taken_over;
mod unconfirmed;
