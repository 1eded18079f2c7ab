//! The error for runs that the kernels cannot do.

/// Why the kernels have no capacity or no code for a run.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("not for the kernels: {0}")]
pub struct Unfit(pub String);
