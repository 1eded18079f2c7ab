//! Several hypotheses of data association: each a whole joint Gaussian with its map and its tracks.
//!
//! With one Gaussian, a measurement that several landmarks may have caused is shared between them, and a wrong association cannot be undone. With
//! several, each of its likeliest causes is a hypothesis, and later scans decide. A scan with [`scan`](MultiHypothesisSlam::scan):
//! its measurements are processed one after the other; each hypothesis has a child for every likely cause of a measurement, an old landmark
//! or a new one ([`causes`]); the likeliest children go on, each corrected in its own place ([`branch`]); children with practically
//! the same pose are joined ([`joining`]); unlikely hypotheses are dropped ([`pruning`]).

mod branch;
mod causes;
mod children;
mod config;
mod filter;
mod finish;
mod joining;
mod pruning;
mod report;
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
pub use report::HypothesesReport;
pub use scrub::HypothesesScrubber;
pub use storage::JointHypotheses;
pub use tracks::MoversOf;

/// Most hypotheses.
const MOST: usize = 16;
