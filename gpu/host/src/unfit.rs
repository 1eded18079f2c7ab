//! What the kernels cannot do.

/// A run that the kernels have no room or no code for: what of it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("not for the kernels: {0}")]
pub struct Unfit(pub String);
