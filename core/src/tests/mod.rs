//! Tests of the whole filter that access its memory or private functions: flipped or invalid words (`faults`, `drafts`, `flips`,
//! `prior`, `scrubbing`, `taken_over`), snapshots byte by byte, and the number of loop iterations in a step (`lying`, `settled`,
//! `smallest`). `core/tests/filter` tests the public interface, with the models of `alone` and `linear`.

pub(crate) mod alone;
mod drafts;
mod faults;
pub(crate) mod flips;
pub(crate) mod linear;
mod lying;
mod prior;
mod scrubbing;
mod settled;
mod smallest;
mod snapshots;
mod taken_over;
mod waiting;
