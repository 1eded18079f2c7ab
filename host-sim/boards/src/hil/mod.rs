//! Hardware in the loop: a stream is sent to a target over a line, frame by frame, and the results are compared with the host's
//! (`docs/link.md`).

mod bench;
mod expected;
mod line;
mod trouble;

pub use bench::{Bench, HilError, Limits, Outcome, Scanned};
pub use expected::{Expected, expected};
pub use line::{Line, Port};
pub use trouble::{Rates, Trouble};
