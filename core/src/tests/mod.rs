//! Tests of the whole filter that look into its memory or ask its private steps: words that are flipped or miscounted (`faults`,
//! `drafts`, `flips`, `prior`, `scrubbing`, `taken_over`), snapshots by their bytes, and how often a step goes round (`lying`, `settled`, `smallest`). What a
//! user can see of the filter is tested in `core/tests/filter`, with the models of `alone` and `linear`.

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
