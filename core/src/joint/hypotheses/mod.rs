//! Several hypotheses of data association: each is a joint Gaussian with its own map and tracks.
//!
//! One Gaussian divides a measurement between all landmarks that may have caused it, and cannot undo a wrong association.
//! With several hypotheses each likely cause is a hypothesis, and later scans decide between them.
//!
//! A [`scan`](MultiHypothesisSlam::scan) processes its measurements one after the other. Each hypothesis has a child for
//! every likely cause of the measurement: an old landmark, or clutter or a new landmark ([`causes`]). Most
//! measurements are in no gate, which is found for all at once ([`gated`]). The likeliest children are kept; those that would have
//! practically the same pose are joined ([`joining`]); the others are copied and corrected ([`branch`]). At the end of the scan
//! unlikely hypotheses are dropped ([`pruning`]).
//!
//! The memory of a hypothesis is its *place*: number 0 is the state of the filter, which has the likeliest hypothesis
//! between scans; the others are [`slot`]s.

mod best;
mod branch;
mod causes;
mod children;
mod config;
mod filter;
mod finish;
mod gated;
mod joining;
mod localise;
mod pruning;
mod scan;
mod scrub;
mod slot;
mod snapshot;
mod steps;
mod storage;
#[cfg(test)]
mod tests;
mod tracks;

pub use config::HypothesesConfig;
pub use filter::MultiHypothesisSlam;
pub use scrub::HypothesesScrubber;
pub use storage::JointHypotheses;
pub use tracks::MoversOf;

/// Most hypotheses.
const MOST: usize = 16;
