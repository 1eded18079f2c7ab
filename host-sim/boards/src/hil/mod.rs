//! Hardware in the loop: a stream goes to a target over a line, frame by frame, and what comes back is held against the host
//! (`docs/link.md`).

mod bench;
mod expected;
mod line;
mod trouble;

pub use bench::{Bench, HilError, Limits, Outcome, Scanned};
pub use expected::{Expected, Recorded, expected};
pub use line::{Line, Port};
pub use trouble::{Rates, Trouble};
