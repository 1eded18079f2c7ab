//! Output of the operations: reports, health, errors, and probes of a scan.

pub(crate) mod any_error;
pub(crate) mod config_error;
pub(crate) mod error;
pub(crate) mod health;
pub(crate) mod probe;
pub(crate) mod reports;
pub(crate) mod watch;
#[cfg(any(test, feature = "flips"))]
mod words;
