//! The single-cluster PHD filter: its memory, its steps and its queries.

pub(crate) mod audit;
mod audit_maps;
mod context;
pub(crate) mod detector;
pub(crate) mod digest;
pub(crate) mod draft;
pub(crate) mod executor;
pub(crate) mod extract;
pub(crate) mod newborn;
pub(crate) mod observe;
pub(crate) mod predict_moving;
pub(crate) mod relocate;
mod restore;
pub(crate) mod sampling;
mod save;
pub(crate) mod scanning;
pub(crate) mod scphd;
pub(crate) mod scrub;
pub(crate) mod stages;
pub(crate) mod state;
pub(crate) mod step;
mod store;
mod survivor;
pub(crate) mod tally;
mod task;
pub(crate) mod together;
pub(crate) mod update;
pub(crate) mod waiting;
mod walk;
#[cfg(any(test, feature = "flips"))]
mod words;
